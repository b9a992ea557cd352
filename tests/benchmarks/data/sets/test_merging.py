"""Several jobs make one set: its bytes are those of one run, whoever made what and however often that was stopped."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.cli.data_functions import merge, split
from benchmarks.cli.main import main
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.generating import generate
from tests.benchmarks.data.sets.small import HERE, MODULES, made, tiny
from tests.benchmarks.data.sets.test_generating import digests
from tests.fakes_scenario import FAKE_TOWN

SPLITS = {"train": 0.5, "val": 0.5}


def request(first: int, end: int, **changes):
    return tiny(seeds=(first, end), frame_count=2, splits=SPLITS, **changes)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> DataSet:
    """Return the set of six episodes that one run made."""
    return made(request(0, 6), tmp_path_factory.mktemp("whole") / "set")


@pytest.mark.parametrize("order", [(0, 2, 4), (4, 0, 2), (2, 4, 0)])
def test_jobs_of_disjoint_seeds_make_the_bytes_of_one_run(whole: DataSet, tmp_path: Path, order) -> None:
    out = tmp_path / "set"
    for first in order:
        made(request(first, first + 2), out)
    data = DataSet(str(out))
    assert not data.is_listed
    assert (data.seeds, data.request.seeds) == (tuple(range(6)), (0, 6))
    (data,) = merge(out)
    assert data.is_listed
    assert digests(out) == digests(whole.root)
    assert digests(merge(out)[0].root) == digests(whole.root), "once more changes nothing"


@pytest.mark.heavy
def test_jobs_that_run_at_once_and_are_killed_make_the_bytes_of_one_run(whole: DataSet, tmp_path: Path) -> None:
    out = tmp_path / "set"
    scripts = [
        f"from tests.benchmarks.data.sets.test_merging import *\nmade(request({first}, {first + 2}), {str(out)!r})"
        for first in (0, 2, 4)
    ]

    def started() -> list[subprocess.Popen[bytes]]:
        root = Path(__file__).parents[4]
        return [subprocess.Popen([sys.executable, "-c", script], env=os.environ, cwd=root) for script in scripts]

    running, limit = started(), time.monotonic() + 120
    while not list(out.glob("episodes/0*")) and time.monotonic() < limit:
        time.sleep(0.001)
    for each in running:
        os.kill(each.pid, signal.SIGKILL)
        each.wait()
    with pytest.raises(ValueError, match=r"out: expected all episodes of 0:6, .*, got .* without .* episodes?: seeds"):
        merge(out)
    assert [each.wait() for each in started()] == [0, 0, 0]
    merge(out)
    assert digests(out) == digests(whole.root)


def test_seeds_of_a_set_that_is_described_as_a_whole_are_made_by_jobs(whole: DataSet, tmp_path: Path) -> None:
    out, asked = str(tmp_path / "set"), request(0, 6)
    for seeds in (range(3, 6), range(0, 3)):
        generate(asked, out, HERE, lambda done, of: None, seeds=seeds)
    merge(out)
    assert digests(out) == digests(whole.root)


def test_several_folders_become_one_without_room(whole: DataSet, tmp_path: Path) -> None:
    made(request(0, 4), tmp_path / "a")
    made(request(4, 6), tmp_path / "b")
    merge([tmp_path / "b", tmp_path / "a"], tmp_path / "set")
    assert digests(tmp_path / "set") == digests(whole.root)
    one, other = (tmp_path / name / "episodes/000005/frames.parquet" for name in ("b", "set"))
    assert one.stat().st_ino == other.stat().st_ino
    shutil.rmtree(tmp_path / "set/episodes/000002")
    (tmp_path / "set/manifest.parquet").unlink()
    merge([tmp_path / "b", tmp_path / "a"], tmp_path / "set")
    assert digests(tmp_path / "set") == digests(whole.root)


def test_what_cannot_be_merged_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made(request(0, 2), tmp_path / "a")
    made(request(1, 3), tmp_path / "b")
    made(request(4, 5), tmp_path / "c")
    made(request(2, 4, pictures="png"), tmp_path / "d")
    for names, message in (
        ("a b", "directory: expected folders without a common episode, got the seeds 1 in "),
        ("a c", "directory: expected folders with all episodes of 0:5, got none with 2–3"),
        ("a d", "out: expected a data set with pictures 'blosc2', got .* with 'png'"),
        ("a x", "directory: expected a data set with a file dataset.json, got none in"),
        ("", "directories: expected a data set, or several folders of one, got none"),
    ):
        words = [str(tmp_path / name) for name in names.split()]
        assert main(["merge", *words, "--out", str(tmp_path / f"to{names}"), "--modules", *MODULES]) == 2
        told = capsys.readouterr().err
        assert re.match(f"error: {message}", told), told
        assert not (tmp_path / f"to{names}").exists()
    assert main(["merge", str(tmp_path / "a"), str(tmp_path / "b"), "--modules", *MODULES]) == 2
    assert capsys.readouterr().err.startswith("error: out: expected a folder for the merged set (--out), got none")


def test_seeds_that_another_job_makes_in_part_are_refused(tmp_path: Path) -> None:
    made(request(0, 4), tmp_path / "set")
    with pytest.raises(ValueError, match=r"seeds: expected none of those of another job, 0:4, or all, got 2:6"):
        made(request(2, 6), tmp_path / "set")


def test_what_a_job_left_out_is_known_after_the_merge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    build = type(FAKE_TOWN).episode

    def refusing(self, preset, seed, **options):
        if seed == 3:
            raise ValueError("no road")
        return build(self, preset, seed, **options)

    monkeypatch.setattr(type(FAKE_TOWN), "episode", refusing)
    made(request(0, 2), tmp_path / "set")
    generate(request(2, 5), str(tmp_path / "set"), HERE, lambda done, of: None, "skip")
    assert DataSet(str(tmp_path / "set")).left_out == {3: "ValueError: seed 3: no road"}
    (data,) = merge(tmp_path / "set")
    assert (data.left_out, data.seeds) == ({3: "ValueError: seed 3: no road"}, (0, 1, 2, 4))
    made(request(5, 6), tmp_path / "set")
    (data,) = merge(tmp_path / "set")
    assert (list(data.left_out), len(data.seeds)) == ([3], 5)


def test_a_set_is_split_anew_without_moving_a_file(tmp_path: Path) -> None:
    data = made(request(0, 6), tmp_path / "set")
    before = digests(tmp_path / "set/episodes")
    assert split(data.url) == {data.url: data.splits}
    found = split(data.url, {"train": 1.0})
    assert found == {data.url: {"train": (0, 1, 2, 3, 4, 5)}}
    assert DataSet(data.url).request.splits == {"train": 1.0}
    assert digests(tmp_path / "set/episodes") == before
    with pytest.raises(ValueError, match=r"splits: expected shares that sum to 1, got 0\.5"):
        split(data.url, {"train": 0.5})


def test_what_a_running_job_writes_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While it makes its last episode, another merges the set, then makes all of it."""
    out, asked, build = tmp_path / "set", request(0, 4), type(FAKE_TOWN).episode
    told: list[str] = []

    class Watched:
        def __init__(self, episode):
            self._episode = episode

        def step(self):
            for other in (
                lambda: merge(out),
                lambda: made(asked, out),
                lambda: generate(asked, str(out), HERE, lambda done, of: None, seeds=range(3, 4)),
            ):
                with pytest.raises(ValueError, match="out: expected") as error:
                    other()
                told.append(str(error.value))
            return self._episode.step()

        def __getattr__(self, name):
            return getattr(self._episode, name)

    def watched(self, preset, seed, **options):
        episode = build(self, preset, seed, **options)
        return Watched(episode) if seed == 3 else episode

    generate(asked, str(out), HERE, lambda done, of: None, seeds=range(0, 2))
    monkeypatch.setattr(type(FAKE_TOWN), "episode", watched)
    generate(asked, str(out), HERE, lambda done, of: None, seeds=range(2, 4))
    assert ["that no other run writes" in each for each in told] == [False, True, True] * 2
    monkeypatch.undo()
    merge(out)
    assert digests(out) == digests(made(asked, tmp_path / "whole").root)


def test_what_killed_runs_left_is_gone_after_the_merge(whole: DataSet, tmp_path: Path) -> None:
    out = tmp_path / "set"
    made(request(0, 4), out)
    generate(request(0, 6), str(out), HERE, lambda done, of: None, seeds=range(4, 6))
    for name in (".dataset.json", ".manifest.parquet", "jobs/.000004-000006.json"):
        (out / f"{name}.0123456789abcdef").write_text("half")
    (out / "episodes/.unfinished-000005-0123456789abcdef").mkdir()
    (out / ".mine").write_text("of somebody else")
    merge(out)
    assert digests(out) == digests(whole.root)
    assert [path.name for path in out.rglob(".*")] == [".mine"]
    assert not (out / "jobs").exists()


def test_a_disk_without_second_names_of_files_will_do(
    whole: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def link(*names: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", link)
    made(request(0, 4), tmp_path / "a")
    made(request(4, 6), tmp_path / "b")
    merge([tmp_path / "a", tmp_path / "b"], tmp_path / "set")
    assert digests(tmp_path / "set") == digests(whole.root)
