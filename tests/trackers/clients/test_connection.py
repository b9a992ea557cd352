"""What travels between runner and client, and a process that is no good partner."""

from __future__ import annotations

import ast
import gc
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from benchmarks.run.time_limit import TooSlow, at_most
from trackers.clients.child import Limits, ProcessError
from trackers.clients.connection import SharedMemory, _answer_class
from trackers.clients.portable import frameout_client
from trackers.clients.remote import PORTABLE, Program, RemoteTracker, end_idle, remote_tracker
from trackers.gaps import Piece
from trackers.types import CameraModel, CameraSettings, EgoPose, Estimate, Observation, SiteSurvey, Track

values = arrays(
    st.sampled_from(["<f8", "<f4", "|u1", "<u2", "|b1", "<i8", ">f8"]), array_shapes(min_dims=0, min_side=0, max_side=4)
)


def same(sent: Any, came: Any) -> None:
    """Check that two arrays have the same bytes, layout and type."""
    assert (came.dtype, came.shape) == (sent.dtype, sent.shape)
    assert sent.size == 0 or came.strides == sent.strides
    assert came.tobytes() == sent.tobytes()
    assert not came.flags.writeable


@given(st.lists(values, max_size=4), st.sampled_from([slice(None), slice(None, None, -1), slice(None, None, 2)]))
def test_arrays_reach_the_process_bit_for_bit(given_arrays: list[Any], cut: slice) -> None:
    sent = [each[cut].T if each.ndim else each for each in given_arrays]
    sent += [np.broadcast_to(each, (3, *each.shape)) for each in sent]
    memory = SharedMemory()
    text = json.dumps(frameout_client.encode(sent, memory.put))
    came = frameout_client.decode(json.loads(text), os.pread(memory.file, memory.used, 0))
    for each, other in zip(sent, came, strict=True):
        same(each, other)


@given(st.tuples(st.floats(), st.integers(-(2**80), 2**80), st.text(), st.none() | st.booleans()))
def test_numbers_and_texts_reach_the_process_exactly(sent: Any) -> None:
    text = json.dumps(frameout_client.encode(sent, None))
    came = frameout_client.decode(json.loads(text), b"")
    assert list(map(repr, came)) == list(map(repr, sent))


def test_what_trackers_are_given_has_the_same_attributes() -> None:
    picture = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    camera = CameraModel(4, 2, 3.0)
    pose = EgoPose(np.eye(4))
    seen = Observation(picture, 0.1, camera, CameraSettings(0.01, 2.0), pose, picture[:, ::-1], counts=None)
    site = SiteSurvey((0.0, 1.0), (0.0, 1.0), -2.0, (3.0, 4.0, 5.0), 0.5)
    memory = SharedMemory()
    text = json.dumps(frameout_client.encode((seen, site, Piece(5, np.zeros((3, 2)), 0.1)), memory.put))
    came, surveyed, piece = frameout_client.decode(json.loads(text), os.pread(memory.file, memory.used, 0))
    same(seen.right_rgb, came.right_rgb)
    same(pose.T_world_camera, came.ego.T_world_camera)
    assert (came.counts, came.steered, came.time_s, came.settings.gain) == (None, None, 0.1, 2.0)
    np.testing.assert_array_equal(came.camera.centre_px, camera.centre_px)
    assert surveyed.watched_m == site.watched_m
    assert piece.end_frame == 8


def test_the_clients_answers_have_the_fields_of_ours() -> None:
    for ours in (Estimate, Track):
        theirs = getattr(frameout_client, ours.__name__)
        assert set(ours.__dataclass_fields__) == set(theirs.__dataclass_fields__)
    answer = frameout_client.Track(3, frameout_client.Estimate(np.zeros(2), heading_rad=np.float32(0.5)))
    arrays = bytearray(frameout_client._message(answer=answer))
    size, _ = frameout_client.HEAD.unpack(arrays[:16])
    came = frameout_client.decode(json.loads(arrays[16 : 16 + size]), bytes(arrays[16 + size :]), _answer_class)
    assert isinstance(came["answer"], Track)
    assert came["answer"].estimate.heading_rad.dtype == np.float32


def test_the_client_is_one_short_file_of_old_python() -> None:
    source = Path(frameout_client.__file__).read_text()
    assert len(source.splitlines()) < 150
    ast.parse(source, feature_version=(3, 8))
    imported = {line.split()[1] for line in source.splitlines() if line.startswith(("import ", "from "))}
    assert imported <= {*sys.stdlib_module_names, "numpy"}
    how: Any = {"capture_output": True, "text": True, "cwd": PORTABLE.parents[2]}
    assert subprocess.run([sys.executable, "-m", "trackers.clients"], **how).stdout == source
    serving = f"import sys; sys.path.append({str(PORTABLE)!r}); import frameout_client; frameout_client.serve(int)"
    alone = subprocess.run([sys.executable, "-c", serving], **how)
    assert alone.stderr.startswith("this is a tracker for Frameout: frameout bench --process NAME=")


PROGRAM = """
import os, sys, time
import numpy as np
from frameout_client import Estimate, serve

class Tracker:
    def __init__(self, parameters, rng): self.parameters = parameters
    def initialise(self, observation, box_xyxy): pass
    def update(self, observation):
        {update}
        return Estimate(np.zeros(2))

serve(Tracker)
"""


def started(folder: Path, update: str = "pass", **limits: Any) -> RemoteTracker:
    file = folder / "program.py"
    file.write_text(PROGRAM.format(update=update))
    program = Program((sys.executable, str(file)), limits=Limits(**limits))
    tracker = remote_tracker(program, {"some": 1.5}, np.random.default_rng(0))
    assert isinstance(tracker, RemoteTracker)
    return tracker


SEEN = Observation(np.zeros((4, 6, 3), np.uint8), 0.0, CameraModel(6, 4, 5.0))


def test_the_process_sees_no_file_and_no_folder_of_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("A_FOLDER_WITH_TRUTH", str(tmp_path / "truth"))
    monkeypatch.chdir(tmp_path)
    with (tmp_path / "truth").open("w") as truth:
        os.set_inheritable(truth.fileno(), True)
        seen = "os.listdir('.'), os.getcwd(), sorted(os.environ), os.listdir('/proc/self/fd')"
        told = f"raise ValueError(({seen}))"
        with pytest.raises(ProcessError) as caught:
            started(tmp_path, told).update(SEEN)
    text = str(caught.value)
    assert "ValueError: ([], " in text
    assert "TRUTH" not in text
    assert str(tmp_path) not in text
    child = started(tmp_path, "time.sleep(60)")._connection.child
    opened = {each.path for each in psutil.Process(child.pid).open_files()}
    assert not {path for path in opened if str(tmp_path) in path}
    child.kill()


def test_what_trackers_of_many_have_is_left_alone_in_one_of_a_single_target(tmp_path: Path) -> None:
    file = tmp_path / "program.py"
    more = "class Tracker:\n    survey = revised = gap_method = decides_at = None"
    file.write_text(PROGRAM.replace("class Tracker:", more).format(update="pass"))
    tracker = remote_tracker(Program((sys.executable, str(file))), {}, np.random.default_rng(0))
    np.testing.assert_array_equal(tracker.update(SEEN).position_px, np.zeros(2))
    tracker.release(whole=False)


def test_cpu_time_is_that_of_the_process_and_its_children(tmp_path: Path) -> None:
    burn = "end = time.process_time() + 0.1\n        while time.process_time() < end: pass"
    tracker = started(tmp_path, burn)
    tracker.update(SEEN)
    assert 0.1 <= tracker.elsewhere_cpu_s < 0.5
    tracker.release(whole=False)


def test_the_time_of_a_process_that_another_one_starts_counts(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(
        PROGRAM.format(update="end = time.process_time() + 0.1\n        while time.process_time() < end: pass")
    )
    launcher = Program(("/bin/sh", "-c", f"{sys.executable} {tmp_path / 'program.py'}; true"))
    tracker = remote_tracker(launcher, {}, np.random.default_rng(0))
    tracker.update(SEEN)
    assert 0.1 <= tracker.elsewhere_cpu_s < 2.0
    pid = tracker._connection.child.pid
    [below] = psutil.Process(pid).children()
    tracker.release(whole=False)
    assert not psutil.pid_exists(below.pid) or psutil.Process(below.pid).status() == psutil.STATUS_ZOMBIE


def test_it_may_take_no_more_cpu_time_than_its_limit(tmp_path: Path) -> None:
    tracker = started(tmp_path, "while True: pass", frame_cpu_s=0.3)
    with pytest.raises(ProcessError, match=r"it took longer than 0\.3 s of CPU time over one answer"):
        tracker.update(SEEN)
    with pytest.raises(ProcessError, match="it has been ended"):
        tracker.update(SEEN)


def test_a_process_serves_one_episode_after_another_and_an_ended_one_is_replaced(tmp_path: Path) -> None:
    first = started(tmp_path)
    pid = first._connection.child.pid
    first.release(whole=True)
    second = started(tmp_path)
    assert second._connection.child.pid == pid
    second.release(whole=False)
    assert not psutil.pid_exists(pid)
    third = started(tmp_path)
    assert third._connection.child.pid != pid
    third.release(whole=True)
    end_idle()
    assert not psutil.pid_exists(third._connection.child.pid)


def test_a_dropped_tracker_leaves_no_process(tmp_path: Path) -> None:
    tracker = started(tmp_path)
    pid = tracker._connection.child.pid
    assert psutil.pid_exists(pid)
    del tracker
    gc.collect()
    assert not psutil.pid_exists(pid)


def test_a_reply_after_an_interruption_is_not_taken_for_the_next_one(tmp_path: Path) -> None:
    tracker = started(tmp_path, "time.sleep(0.6)")
    with pytest.raises(TooSlow), at_most(0.03):
        tracker.update(SEEN)
    with pytest.raises(ProcessError, match="it has been ended"):
        tracker.update(SEEN)


def test_one_that_cannot_be_started_leaves_no_file_open() -> None:
    def failed() -> int:
        with pytest.raises(ProcessError, match=r"it cannot be started: .*No such file"):
            remote_tracker(Program(("/no/such/program",)), {}, np.random.default_rng(0))
        gc.collect()
        return psutil.Process().num_fds()

    assert failed() == failed()


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("print('hello')", "it ended with exit status 0: hello"),
        (
            "import os; os.write(int(os.environ['FRAMEOUT_PIPE'].split(',')[1]), b'x' * 40)",
            "expected a message of the protocol, got b'xx",
        ),
        ("raise ImportError('no torch')", "it ended with exit status 1: ImportError: no torch"),
        (
            "import os, time; os.closerange(3, 200); os.close(1); time.sleep(60)",
            "it closed its pipe and runs on, without a word",
        ),
    ],
)
def test_another_program_is_named(program: str, message: str) -> None:
    began_s = time.monotonic()
    with pytest.raises(ProcessError, match=message):
        remote_tracker(Program((sys.executable, "-c", program)), {}, np.random.default_rng(0))
    assert time.monotonic() - began_s < 30.0


BY_HAND = """
import os, struct, sys
from frameout_client import HEAD, _message
given, taken, _ = map(int, os.environ["FRAMEOUT_PIPE"].split(","))
def say(message): os.write(taken, message)
def of(text): return HEAD.pack(len(text), 64) + text + b"\\x11" * 64
say(_message(frameout=1, name="by hand", pid=0))
os.read(given, 1 << 20)
say(of(b'{{"number": 1, "answer": []}}'))
os.read(given, 1 << 20)
{then}
os.read(given, 1 << 20)
"""


@pytest.mark.parametrize(
    ("then", "message"),
    [
        ("""say(of(b'{"number": 2, "answer": null, "elsewhere_cpu_s": NaN}'))""", "elsewhere_cpu_s: expected a time"),
        ("say(of(b'[' * 100_000))", "one that is broken: RecursionError"),
        (
            """say(of(b'{"number":2, "answer": {"is": "array", "of": "O", "shape": [2], "strides": [8], "at": 0}}'))""",
            "one that is broken: TypeError: expected an array of numbers",
        ),
        (
            """say(of(b'{"number": 2, "error": "first\\\\nsecond", "at": [["/a/b.py", 3]]}'))""",
            r"^first \(b.py, line 3\)$",
        ),
        ("""say(of(b'{"number": 2, "error": "a word", "at": 5}'))""", "^a word$"),
        ("""say(HEAD.pack(2 << 30, 0))""", "expected a message of the protocol, got b'"),
        ("""say(of(b'{"number": 2}')[:30]); sys.exit()""", "it ended with exit status 0, without a word"),
        ("""say(of(b'{"number": 2}') * 2)""", "it answered before it was asked: b'"),
        ("""os.closerange(3, 200)\nwhile True: os.write(1, b"y" * 65536)""", "it closed its pipe and runs on: yyyy"),
    ],
)
def test_a_broken_reply_is_named_and_ends_the_process(then: str, message: str) -> None:
    program = Program((sys.executable, "-c", BY_HAND.format(then=then)))
    tracker = remote_tracker(program, {}, np.random.default_rng(0))
    assert isinstance(tracker, RemoteTracker)

    def asked_twice() -> None:
        tracker.initialise(SEEN, np.zeros(4))
        tracker.initialise(SEEN, np.zeros(4))

    with pytest.raises(ProcessError, match=message):
        asked_twice()
    assert not psutil.pid_exists(tracker._connection.child.pid)


def test_memory_is_weighed_also_between_quick_answers(tmp_path: Path) -> None:
    tracker = started(tmp_path, "self.kept = [*getattr(self, 'kept', []), np.ones(500_000)]", memory_gb=0.3)

    def updated_often() -> None:
        for _ in range(300):
            tracker.update(SEEN)
            time.sleep(0.001)

    with pytest.raises(ProcessError, match=r"GB of memory, more than its limit of 0\.3 GB"):
        updated_often()


def test_memory_that_processes_share_counts_once(tmp_path: Path) -> None:
    forks = "self.kept = np.ones(10_000_000); [time.sleep(60) for _ in range(6) if os.fork() == 0]; time.sleep(1.5)"
    tracker = started(tmp_path, forks, memory_gb=0.4)
    tracker.update(SEEN)
    assert len(psutil.Process(tracker._connection.child.pid).children()) == 6
    tracker.release(whole=False)
