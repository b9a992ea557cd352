"""The bytes of a data set do not depend on who made it, nor on how often that was stopped."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks.cli.main import main
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import Workers, forecast, generate
from benchmarks.data.sets.jobs import note_job
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.request import first_episode
from benchmarks.run.result_folder import alone_in
from tests.benchmarks.data.sets.small import HERE, MODULES, made, tiny
from tests.benchmarks.no_room import no_room
from tests.fakes_scenario import FAKE_TOWN


def digests(folder) -> dict[str, str]:
    """Return the checksum of every file in a folder."""
    files = sorted(path for path in Path(folder).rglob("[!.]*") if path.is_file() and ".unfinished" not in str(path))
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.heavy
@pytest.mark.parametrize("workers", [1, 2, 4])
def test_any_number_of_workers_makes_the_same_bytes(data, tmp_path, workers):
    made(tiny(), tmp_path / "set", Workers(workers, modules=MODULES))
    assert digests(tmp_path / "set") == digests(data.root)


def test_a_killed_run_continues_with_the_same_command_and_makes_the_same_bytes(data, tmp_path):
    out = tmp_path / "set"
    script = f"from tests.benchmarks.data.sets.small import made, tiny\nmade(tiny(), {str(out)!r})\n"
    run = subprocess.Popen([sys.executable, "-c", script], env=os.environ, cwd=Path(__file__).parents[4])
    limit = time.monotonic() + 60
    while not list(out.glob("episodes/*/*.tar")) and time.monotonic() < limit:
        time.sleep(0.005)
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    assert not (out / "manifest.parquet").exists()
    made(tiny(), out)
    assert digests(out) == digests(data.root)


@pytest.mark.heavy
def test_thirty_kills_at_random_moments_change_nothing(tmp_path):
    """Each run lives for a little longer than it takes to begin. Its two workers outlive it for a while."""
    asked = "tiny(seeds=(0, 24), frame_count=200)"
    made(tiny(seeds=(0, 24), frame_count=200), tmp_path / "whole")
    out = tmp_path / "set"
    script = (
        f"from tests.benchmarks.data.sets.small import *\nmade({asked}, {str(out)!r}, Workers(2, modules=MODULES))\n"
    )
    rng, kills = np.random.default_rng(0), 0
    while kills < 30:
        run = subprocess.Popen([sys.executable, "-c", script], env=os.environ, cwd=Path(__file__).parents[4])
        before = len(list(out.glob("episodes/0*/episode.json")))
        limit = time.monotonic() + 60
        while not out.exists() and run.poll() is None and time.monotonic() < limit:
            time.sleep(0.01)
        time.sleep(float(rng.uniform(1.0, 4.0)))
        if run.poll() is None:
            os.kill(run.pid, signal.SIGKILL)
            kills += 1
        run.wait()
        assert len(list(out.glob("episodes/0*/episode.json"))) >= before
        if (out / "manifest.parquet").exists():
            shutil.rmtree(out)
    made(tiny(seeds=(0, 24), frame_count=200), out)
    assert digests(out) == digests(tmp_path / "whole")


def peak_mib(work: str) -> float:
    """Return the largest resident memory of a process that does some work, in MiB."""
    script = (
        "import resource\nfrom benchmarks.data.sets.generating import make_episode\n"
        f"from tests.benchmarks.data.sets.small import *\n{work}\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", script], env=os.environ, cwd=Path(__file__).parents[4], capture_output=True, check=True
    )
    return int(run.stdout) / 1024


@pytest.mark.heavy
def test_memory_hardly_grows_with_the_number_of_frames(tmp_path):
    """512 frames are two blocks of rows, which are in memory until they are written.

    What is left in memory of a longer episode are the footers of its tables, 3 KiB a frame. The data card is written
    from tables that are read in parts.
    """

    def worker_mib(name: str, frames: int, episodes: int) -> float:
        request = f"tiny(seeds=(0, {episodes}), frame_count={frames})"
        return peak_mib(f"for k in range({episodes}): make_episode({request}, {str(tmp_path / name)!r}, MODULES, k)")

    few, blocks = worker_mib("few", 10, 1), worker_mib("blocks", 512, 1)
    assert blocks < 1.15 * few
    assert worker_mib("long", 10_000, 1) < 1.12 * blocks
    assert worker_mib("many", 100, 100) < 1.06 * blocks
    one, many = (
        peak_mib(f"made(tiny(seeds=(0, {episodes}), frame_count=100), {str(tmp_path / str(episodes))!r})")
        for episodes in (1, 100)
    )
    assert many < 1.15 * one


@pytest.mark.heavy
@pytest.mark.parametrize("mark", [None, b"", b'{"seed": 4'])
def test_an_episode_without_a_mark_is_made_again(data, tmp_path, mark):
    shutil.copytree(data.root, tmp_path / "set")
    path = tmp_path / "set/episodes/000004/episode.json"
    path.unlink() if mark is None else path.write_bytes(mark)
    made(tiny(), tmp_path / "set")
    assert digests(tmp_path / "set") == digests(data.root)


def test_more_seeds_are_added_and_whole_episodes_are_kept(tmp_path):
    made(tiny(seeds=(3, 4)), tmp_path / "set")
    mark = tmp_path / "set/episodes/000003/episode.json"
    before = mark.stat().st_mtime_ns
    assert made(tiny(), tmp_path / "set").seeds == (3, 4)
    assert mark.stat().st_mtime_ns == before


def test_a_set_that_grew_has_no_manifest_and_card_of_before(tmp_path, monkeypatch):
    """The run is killed after the last episode, or after the manifest."""
    out = tmp_path / "set"
    made(tiny(seeds=(3, 4)), out)
    for seeds, stopped in (((3, 5), "finish"), ((3, 6), "write_card")):
        with monkeypatch.context() as patch:
            patch.setattr(f"benchmarks.data.sets.generating.{stopped}", lambda *_: (_ for _ in ()).throw(SystemExit))
            with pytest.raises(SystemExit):
                made(tiny(seeds=seeds), out)
        data = made(tiny(seeds=seeds), out)
        assert data.is_listed
        assert [entry.seed for entry in data.entries()] == list(range(*seeds))
        assert f"(seeds {seeds[0]}–{seeds[1] - 1})" in (out / "README.md").read_text()


def test_a_folder_with_something_else_is_refused(tmp_path):
    made(tiny(), tmp_path / "set")
    with pytest.raises(ValueError, match=r"out: expected a data set with pictures 'png', got .* with 'blosc2'"):
        made(tiny(pictures="png"), tmp_path / "set")
    before = (tmp_path / "set/dataset.json").read_bytes()
    with pytest.raises(ValueError, match="out: expected a data set with pictures 'png'"):
        made(tiny(pictures="png", seeds=(3, 9)), tmp_path / "set")
    assert (tmp_path / "set/dataset.json").read_bytes() == before
    with pytest.raises(ValueError, match="made by another edition"):
        made(tiny(scene="other"), tmp_path / "set")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/thesis.txt").touch()
    with pytest.raises(ValueError, match="out: expected a new or empty folder, or a data set"):
        made(tiny(), tmp_path / "mine")


def test_a_full_disk_leaves_whole_episodes_alone(tmp_path):
    made(tiny(seeds=(3, 4)), tmp_path / "set")
    whole = digests(tmp_path / "set/episodes")
    with no_room(20_000), pytest.raises(OSError, match="File too large"):
        made(tiny(), tmp_path / "set")
    assert digests(tmp_path / "set/episodes") == whole
    assert DataSet(str(tmp_path / "set")).seeds == (3,)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"channels": ("depth",)}, "channels: expected some of image_rgb, .*, got 'depth'"),
        ({"pictures": "gif"}, "pictures: expected one of blosc2, png, jpeg, jpeg-1 to jpeg-100, got 'gif'"),
        ({"pictures": "jpeg-0"}, "pictures: expected one of .*, got 'jpeg-0'"),
        ({"splits": {"train": 0.5, "val": 0.4}}, "splits: expected shares that sum to 1, got 0.9"),
        ({"splits": {"trian": 1.0}}, r"splits: expected one of train, val, test; got 'trian' \(did you mean train"),
        ({"splits": {"train": 1.5, "val": -0.5}}, "splits train: expected a share of 0 to 1, got 1.5"),
        ({"negatives": 2}, "negatives: expected a share of 0 to 1, got 2"),
        ({"classes": ("car", "car")}, "classes: expected each class once, got car, car"),
        ({"seeds": (4, 4)}, "seeds: expected A:B with 0 <= A < B, got 4:4"),
    ],
)
def test_wrong_requests_are_named(changes, message):
    with pytest.raises(ValueError, match=message):
        tiny(**changes)


def test_a_channel_that_only_other_scenes_have_is_refused(tmp_path, capsys):
    words = ["fake-town", "--preset", "tiny", "--seeds", "0:1", "--out", str(tmp_path / "set"), "--modules", *MODULES]
    assert main(["generate", *words, "--channels", "right_rgb"]) == 2
    error = capsys.readouterr().err
    assert re.match(r"error: channels: expected some of image_rgb, .*, got 'right_rgb'", error)
    assert "counts" not in error


def test_values_of_fields_are_drawn_for_each_episode_and_kept_in_the_preset_s_name(tmp_path, capsys):
    words, out = ["--seeds", "3:8", "--modules", *MODULES, "--workers", "0"], tmp_path / "set"
    assert (
        main(
            [
                "generate",
                "fake-town",
                "--preset",
                "tiny",
                *words,
                "--set",
                "frame_count=4:12",
                "--set",
                "rate_hz=10",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    data = DataSet(str(out))
    assert data.request.preset == "tiny[frame_count=4:12,rate_hz=10]"
    lengths = [data.episode(seed).frame_count for seed in data.seeds]
    assert lengths == [data.request.configuration(seed).frame_count for seed in data.seeds]
    assert len(set(lengths)) > 1
    capsys.readouterr()
    assert (
        main(["generate", "road-town", *words, "--set", "rate_hz=uniform(-10,10)", "--out", str(tmp_path / "none")])
        == 2
    )
    assert re.match(r"error: seed \d: rate_hz: expected a number in ", capsys.readouterr().err)
    assert not (tmp_path / "none").exists()


def test_a_preset_in_closed_loop_is_refused():
    request = tiny()
    object.__setattr__(request, "preset", "tiny-loop")
    with pytest.raises(ValueError, match="preset: expected one on a set path or at rest, got 'tiny-loop'"):
        request.episode(3)


def test_a_forecast_is_near_what_is_made_and_makes_nothing(data):
    told = forecast(tiny(), frames=4)
    assert told.frames == len(data)
    made_bytes = data.stored_bytes()
    for channel in data.request.channels:
        assert told.bytes_a_frame[channel] == pytest.approx(made_bytes[channel] / len(data), rel=0.2), channel
    assert set(told.bytes_a_frame) == {*data.request.channels, "tables"}
    assert told.bytes >= sum(told.bytes_a_frame.values()) * told.frames
    assert told.seconds > 0


@pytest.fixture
def refuse(monkeypatch):
    """Return a function that lets building the episodes of some seeds fail; it returns the list of seeds tried."""
    build, tried = FAKE_TOWN.__class__.episode, []

    def refuse(seeds, error):
        def episode(scenario, preset, seed, **others):
            tried.append(seed)
            if seed in seeds:
                raise error
            return build(scenario, preset, seed, **others)

        monkeypatch.setattr(FAKE_TOWN.__class__, "episode", episode)
        return tried

    return refuse


def test_an_episode_that_cannot_be_built_is_named_and_what_was_made_is_kept(tmp_path, capsys, refuse):
    refuse([4], ValueError("frame_count: expected enough, got 12"))
    words = ["fake-town", "--preset", "tiny", "--seeds", "3:6", "--set", "frame_count=3", "--workers", "0"]
    words += ["--out", str(tmp_path / "set"), "--modules", *MODULES, "--channels", "image_rgb"]
    assert main(["generate", *words]) == 2
    assert capsys.readouterr().err.endswith("\nerror: seed 4: frame_count: expected enough, got 12\n")
    assert DataSet(str(tmp_path / "set")).seeds == (3,)
    before = digests(tmp_path / "set/episodes")
    assert main(["generate", *words, "--on-error", "skip"]) == 0
    said = "left out: seed 4: ValueError: seed 4: frame_count: expected enough, got 12\n1 episode could not be built\n"
    assert capsys.readouterr().err.endswith(said)
    data = DataSet(str(tmp_path / "set"))
    assert (data.seeds, data.missing()) == ((3, 5), [])
    assert data.left_out == {4: "ValueError: seed 4: frame_count: expected enough, got 12"}
    assert digests(tmp_path / "set/episodes").items() > before.items()
    assert "could not be built: seed 4: ValueError" in (tmp_path / "set/README.md").read_text()
    assert main(["verify", str(tmp_path / "set"), "--modules", *MODULES]) == 0
    assert "left out: seed 4: " in capsys.readouterr().out


def test_where_no_episode_can_be_built_nothing_is_left_out(tmp_path, refuse):
    refuse([4], ValueError("no road"))
    with pytest.raises(ValueError, match=r"seeds: expected some whose episodes can be built, got none; .*: seed 4: "):
        generate(tiny(seeds=(4, 5)), str(tmp_path / "set"), HERE, lambda done, of: None, "skip")


@pytest.mark.parametrize("dry", [["--dry-run"], []])
def test_any_number_of_first_episodes_is_skipped_on_demand_alone(tmp_path, refuse, dry):
    tried = refuse(range(9), RuntimeError("no road"))
    words = ["generate", "fake-town", "--preset", "tiny", "--seeds", "0:10", "--set", "frame_count=2", "--workers", "0"]
    words += ["--out", str(tmp_path / "set"), "--modules", *MODULES, *dry]
    with pytest.raises(RuntimeError, match="no road"):
        main(words)
    assert tried == [0]
    assert main([*words, "--on-error", "skip"]) == 0
    assert (tmp_path / "set").exists() != bool(dry)
    assert dry or DataSet(str(tmp_path / "set")).seeds == (9,)


def test_an_error_of_the_disk_is_not_one_of_an_episode(refuse):
    refuse(range(9), OSError(errno.ENOSPC, "no space"))
    with pytest.raises(OSError, match="no space") as found:
        first_episode(tiny(), "skip")
    assert found.value.__notes__ == ["of seed 3"]


def test_a_second_writer_is_refused_in_one_line(tmp_path):
    made(tiny(seeds=(3, 4)), tmp_path / "set")
    note_job(*place_of(str(tmp_path / "set")), range(3, 5))
    with (
        alone_in(tmp_path / "set/jobs/000003-000005.json"),
        pytest.raises(ValueError, match="out: expected a folder that no"),
    ):
        made(tiny(), tmp_path / "set")
    assert made(tiny(), tmp_path / "set").seeds == (3, 4)


def test_a_whole_set_is_not_written_again(tmp_path, monkeypatch):
    made(tiny(seeds=(3, 4)), tmp_path / "set")
    monkeypatch.setattr("benchmarks.data.sets.generating.put", None)
    assert made(tiny(seeds=(3, 4)), tmp_path / "set").seeds == (3,)


def test_folders_that_cannot_be_made_or_written_are_named(tmp_path):
    (tmp_path / "file").touch()
    for out in (tmp_path / "file/inside", "/proc/1/set"):
        with pytest.raises(ValueError, match=f"out: expected a folder that can be written, got '{out}"):
            made(tiny(), out)
