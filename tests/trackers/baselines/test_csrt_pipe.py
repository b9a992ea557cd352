"""CSRT behind its pipe: with children that speak the protocol, and with OpenCV's own where it is installed."""

from __future__ import annotations

import gc
import io
import os
import sys
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.suite import suite
from benchmarks.run.guards import GuardedTracker
from benchmarks.run.selection import choices
from benchmarks.run.time_limit import TooSlow, at_most
from scenarios.loop import FromPictures
from tests.benchmarks.fake_episode import FakeEpisode
from tests.benchmarks.run.test_time_limit import burn
from tests.fakes import DrawnTown, drive, look_down, straight_road
from trackers.baselines import csrt_pipe
from trackers.baselines.csrt_child import HELLO, REPLY, REQUEST, VERSION_BYTES, serve
from trackers.baselines.csrt_pipe import PYTHON_VARIABLE, ChildError, ChildPipe, CsrtPipe, missing_csrt
from trackers.registry import entry
from trackers.types import CameraModel, Observation

GREETING = HELLO + cv2.__version__.encode().ljust(VERSION_BYTES)
CHILD = """#!{python}
import os, struct, sys, time
request, reply = struct.Struct({request!r}), struct.Struct({reply!r})
read, write = sys.stdin.buffer, sys.stdout.buffer
write.write({hello!r}); write.flush()
box, updates = (0, 0, 0, 0), 0
while len(head := read.read(request.size)) == request.size:
    began_s = time.process_time()
    kind, width, height, *given = request.unpack(head)
    assert len(read.read(3 * width * height)) == 3 * width * height
    if kind == b"i":
        box = given
    else:
        updates += 1
        box = (box[0] + 3, *box[1:])
    {fault}
    write.write(reply.pack(updates != 2, *map(float, box), time.process_time() - began_s)); write.flush()
"""


def fake(folder: Path, monkeypatch: pytest.MonkeyPatch, fault: str = "", hello: bytes = GREETING) -> None:
    """Make a program that follows by 3 pixels a picture, except on the second one, the interpreter of CSRT."""
    program = folder / "python"
    words = {"request": REQUEST.format, "reply": REPLY.format, "hello": hello, "fault": fault or "pass"}
    program.write_text(CHILD.format(python=sys.executable, **words))
    program.chmod(0o755)
    monkeypatch.setenv(PYTHON_VARIABLE, str(program))


def picture(k: int = 0, width: int = 64, height: int = 48) -> Observation:
    return Observation(np.zeros((height, width, 3), np.uint8), k / 15, CameraModel(width, height, 50.0))


def is_running(pid: int) -> bool:
    """Return whether there is a process, a zombie included."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_boxes_come_back_and_a_failure_keeps_the_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(tmp_path, monkeypatch)
    tracker = entry("opencv_csrt").create(np.random.default_rng(0))
    tracker.initialise(picture(), np.array([10.0, 8.0, 22.0, 20.0]))
    first, second, third = (tracker.update(picture(k)) for k in (1, 2, 3))
    np.testing.assert_array_equal(first.box_xyxy, [13.0, 8.0, 25.0, 20.0])
    np.testing.assert_array_equal(second.box_xyxy, first.box_xyxy)
    np.testing.assert_array_equal(third.position_px, [25.0, 14.0])
    assert [each.in_view_probability for each in (first, second, third)] == [1.0, 0.0, 1.0]


def test_a_large_picture_and_another_size_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(tmp_path, monkeypatch)
    tracker = entry("opencv_csrt").create(np.random.default_rng(0))
    tracker.initialise(picture(0, 1280, 720), np.array([10.0, 8.0, 22.0, 20.0]))
    assert tracker.update(picture(1, 30, 20)).box_xyxy[0] == 13.0


def test_a_tiny_picture_has_no_answer_and_no_child(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PYTHON_VARIABLE, str(tmp_path / "none"))
    tracker = entry("opencv_csrt").create(np.random.default_rng(0))
    tracker.initialise(picture(0, 9, 7), np.array([1.0, 1.0, 5.0, 5.0]))
    assert np.isnan(tracker.update(picture(1, 9, 7)).position_px).all()


def test_the_time_of_the_child_is_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(tmp_path, monkeypatch, fault="all(iter(lambda: time.process_time() < began_s + 0.05, False))")
    episode, tracker = FakeEpisode(), entry("opencv_csrt").create(np.random.default_rng(0))
    guard = GuardedTracker(lambda: FromPictures(tracker), 30.0)
    guard.initialise(episode.step(), episode.start)
    for _ in range(3):
        guard.update(episode.step())
    assert guard.reason is None
    assert all(0.05 <= taken.cpu_s < 0.5 for taken in guard.taken)


def test_a_dropped_tracker_leaves_no_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake(tmp_path, monkeypatch)
    tracker = entry("opencv_csrt").create(np.random.default_rng(0))
    tracker.initialise(picture(), np.array([10.0, 8.0, 22.0, 20.0]))
    pid = tracker._csrt._pipe.pid
    assert is_running(pid)
    del tracker
    gc.collect()
    assert not is_running(pid)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("time.sleep(60)", r"opencv_csrt: expected a box .* but it did not answer within 0\.5 s"),
        ("sys.exit('no memory left')", "opencv_csrt: expected a box .* but it ended: no memory left"),
        ("os.kill(os.getpid(), 9)", "opencv_csrt: expected a box .* but it ended$"),
    ],
)
def test_a_child_that_hangs_or_dies_is_reported_once(
    fault: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake(tmp_path, monkeypatch, fault=f"updates == 1 and {fault}")
    csrt = CsrtPipe(limit_s=10.0)
    csrt.start(picture().image_rgb, np.array([10.0, 8.0, 22.0, 20.0]))
    monkeypatch.setattr(csrt._pipe, "_limit_s", 0.5 if "sleep" in fault else 10.0)
    pid = csrt._pipe.pid
    with pytest.raises(RuntimeError, match=message):
        csrt.update(picture().image_rgb)
    assert not is_running(pid)
    with pytest.raises(RuntimeError, match="it is closed"):
        csrt.update(picture().image_rgb)


def test_a_child_that_reads_nothing_is_late_too() -> None:
    pipe = ChildPipe([sys.executable, "-c", "import time; time.sleep(60)"], limit_s=0.3)
    with pytest.raises(ChildError, match=r"it did not answer within 0\.3 s"):
        pipe.ask(bytes(1 << 20), 1)
    assert not is_running(pipe.pid)


def test_a_child_that_closes_a_stream_and_lives_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csrt_pipe, "_ENDING_S", 0.1)
    pipe = ChildPipe([sys.executable, "-c", "import os, time; os.close(1); time.sleep(60)"], limit_s=30.0)
    with pytest.raises(ChildError, match=r"^it closed a stream and runs on$"):
        pipe.ask(b"", 1)
    assert not is_running(pipe.pid)


def test_a_reply_after_an_interruption_is_not_taken_for_the_next_one() -> None:
    late = "import sys, time; sys.stdin.buffer.read(1); time.sleep(0.6); print('old', flush=True); time.sleep(60)"
    pipe = ChildPipe([sys.executable, "-c", late], limit_s=30.0)
    with pytest.raises(TooSlow), at_most(0.03):
        pipe.ask(b"1", 4)
    assert not is_running(pipe.pid)
    with pytest.raises(ChildError, match="it is closed"):
        pipe.ask(b"2", 4)


def test_a_missing_interpreter_or_package_is_told_with_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(PYTHON_VARIABLE, str(tmp_path / "none"))
    assert PYTHON_VARIABLE in missing_csrt()
    with pytest.raises(RuntimeError, match=r"FRAMEOUT_CSRT_PYTHON: expected .* make one by: python -m venv ~/\.cache"):
        CsrtPipe()
    fake(tmp_path, monkeypatch, hello=b"something else 1")
    with pytest.raises(RuntimeError, match=r"expected .*it greets by b'something else 1'.*; make one by"):
        CsrtPipe()
    fake(tmp_path, monkeypatch, hello=HELLO + b"4.5.4".ljust(VERSION_BYTES))
    with pytest.raises(
        RuntimeError, match=rf"expected a Python with OpenCV {cv2.__version__} .*\(it has OpenCV 4\.5\.4\)"
    ):
        CsrtPipe()
    (tmp_path / "python").write_text(f"#!{sys.executable}\nraise ImportError('No module named cv2')\n")
    with pytest.raises(RuntimeError, match="it ended: ImportError: No module named cv2"):
        CsrtPipe()


def test_the_wheels_that_are_asked_for_are_the_tested_versions() -> None:
    tested = (Path(__file__).parents[3] / "constraints.txt").read_text().split()
    [opencv] = [line.replace("-python", "-contrib-python") for line in tested if line.startswith("opencv-python")]
    [numpy] = [line for line in tested if line.startswith("numpy==")]
    assert f"pip install {opencv} {numpy}\n" in str(csrt_pipe.__doc__)


def test_default_runs_take_it_where_its_interpreter_exists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frame_out = suite("frame-out")
    for present in (False, True):
        if present:
            fake(tmp_path, monkeypatch)
        else:
            monkeypatch.setenv(PYTHON_VARIABLE, str(tmp_path / "none"))
        [choice] = choices(frame_out, variants=False)
        assert ("opencv_csrt" in choice.trackers) == present
    monkeypatch.setenv(PYTHON_VARIABLE, str(tmp_path / "none"))
    [choice] = choices(frame_out, trackers=("opencv_csrt",), variants=False)
    assert choice.trackers == ("opencv_csrt",)


def test_the_child_hands_pictures_to_opencv(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[NDArray[np.uint8], object]] = []

    class Csrt:
        def init(self, bgr: NDArray[np.uint8], box: tuple[int, ...]) -> None:
            seen.append((bgr, box))

        def update(self, bgr: NDArray[np.uint8]) -> tuple[bool, tuple[int, ...]]:
            seen.append((bgr, None))
            burn(0.05)
            return True, (4, 5, 6, 7)

    monkeypatch.setitem(
        sys.modules,
        "cv2",
        SimpleNamespace(setNumThreads=lambda count: None, TrackerCSRT_create=Csrt, __version__="5.1"),
    )
    rgb = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3)
    requests = REQUEST.pack(b"i", 3, 2, 1, 0, 2, 2) + rgb.tobytes() + REQUEST.pack(b"u", 3, 2, 0, 0, 0, 0)
    replies = io.BytesIO()
    serve(io.BytesIO(requests + rgb.tobytes()), replies)
    greeting, answers = replies.getvalue()[: len(GREETING)], replies.getvalue()[len(GREETING) :]
    assert greeting == HELLO + b"5.1".ljust(VERSION_BYTES)
    (*started, _), (*found, burnt_s) = REPLY.iter_unpack(answers)
    assert (started, found) == ([True, 1, 0, 2, 2], [True, 4, 5, 6, 7])
    assert 0.05 <= burnt_s < 1.0
    assert [box for _, box in seen] == [(1, 0, 2, 2), None]
    np.testing.assert_array_equal(seen[1][0], rgb[..., ::-1])


@pytest.mark.skipif(csrt_pipe.missing_csrt() != "", reason="no interpreter with opencv-contrib-python-headless")
def test_opencv_csrt_follows_a_drawn_car_and_answers_alike_twice() -> None:
    road = straight_road()
    town = DrawnTown(road, 160.0, np.random.default_rng(0))
    frames = list(drive(town, road, 110.0, 0.4, [look_down(0, 0, 60.0, 0.0)] * 15))
    runs = []
    for _ in range(2):
        tracker = entry("opencv_csrt").create(np.random.default_rng(0))
        tracker.initialise(frames[0].observation, frames[0].box_xyxy)
        runs.append([tracker.update(frame.observation).position_px for frame in frames[1:]])
    np.testing.assert_array_equal(*runs)
    assert np.hypot(*(runs[0][-1] - frames[-1].position_px)) < 24
