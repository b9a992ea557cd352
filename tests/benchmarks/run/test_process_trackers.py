"""Trackers in processes of their own: the same rows as in this one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks import bench
from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.judges.tracker_speed import times
from benchmarks.run.experiment import run
from benchmarks.run.process_trackers import ProcessTracker, process_trackers
from benchmarks.run.selection import experiment_on, tracker_named
from benchmarks.show.provenance import _command
from benchmarks.show.replay import is_of_present_editions
from scenarios import catalog
from tests import fakes_scenario  # noqa: F401
from tests.toy_scene import register  # noqa: F401
from tests.trackers.clients import followers
from trackers.clients.child import Limits

FOLLOWERS = {"follows_one": "one", "follows_many": "many"}
TIMES = {score.metric for score in times([(1.0, 1.0)] * 10, (0.0, 0.0), 10)}


def program(folder: Path) -> Path:
    """Return the file of the followers, with nothing beside it."""
    return Path(shutil.copy(followers.__file__, folder))


def rows_of(judging: str, scenario: str, preset: str, tracker: TrackerSpec, out: Path) -> list[dict[str, Any]]:
    """Return the rows of two episodes, without what depends on time, and on how the tracker is called."""
    how: dict[str, Any] = {"workers": 0}
    outcome = run(experiment_on(judging, scenario, [preset], {"follower": tracker}, range(2), **how), out)
    assert not outcome.failures, outcome.failures
    left = ("seconds", "editions", "process", "role")
    kept = [row for row in read_rows(out) if row["metric"] not in TIMES]
    return [{key: value for key, value in row.items() if key not in left} for row in kept]


def check_alike(python: str, judging: str, scenario: str, preset: str, tracker: str, folder: Path) -> None:
    """Check the rows of a follower here and in a process of ``python``."""
    here = replace(tracker_named(tracker), name="follower")
    command = f"{python} {program(folder)} {FOLLOWERS[tracker]}"
    there = process_trackers([f"follower={command}"], 60.0)["follower"]
    wanted = rows_of(judging, scenario, preset, here, folder / "here")
    assert len(wanted) > 10
    assert rows_of(judging, scenario, preset, there, folder / "there") == wanted


@pytest.mark.parametrize(
    ("judging", "scenario", "preset", "tracker"),
    [
        ("frame-out", "fake-town", "tiny", "follows_one"),
        ("frame-out", "fake-town", "tiny", "follows_many"),
        ("toy-many", "toy-yard", "quick", "follows_many"),
    ],
)
def test_a_process_has_the_rows_of_the_same_class_here(
    judging: str, scenario: str, preset: str, tracker: str, tmp_path: Path
) -> None:
    check_alike(sys.executable, judging, scenario, preset, tracker, tmp_path)


def test_one_of_a_single_target_fails_where_many_are_judged(tmp_path: Path) -> None:
    one = process_trackers([f"one={sys.executable} {program(tmp_path)} one"], 60.0)
    outcome = run(experiment_on("toy-many", "toy-yard", ["quick"], one, range(1), workers=0), tmp_path / "out")
    [failure] = outcome.failures
    assert (failure.frame, failure.reason) == (
        0,
        "ValueError: tracker: expected one of many targets, with a method start, got one of a single target",
    )


def test_rows_name_the_process_and_are_made_again_when_its_files_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    command = f"{sys.executable} {program(tmp_path).name} many"

    def benched(**how: Any) -> Any:
        given: dict[str, Any] = {"trackers": "mine", "process": {"mine": command}, "preset": "quick"}
        return bench("toy-many", seeds=range(1), out="out", workers=0, **given | how)

    assert benched().outcome.episodes == 1
    rows = read_rows(tmp_path / "out")
    assert {row["process"] for row in rows} == {f"mine={command}"}
    assert {row["role"] for row in rows} == {"external"}
    assert f"--trackers mine --process 'mine={command}'" in _command(rows, "0:1")
    assert is_of_present_editions(rows[0])
    assert benched().outcome.resumed == 1
    with (tmp_path / "followers.py").open("a") as file:
        file.write("# another tracker\n")
    assert not is_of_present_editions(rows[0])
    again = benched()
    assert (again.outcome.episodes, again.outcome.resumed) == (1, 0)
    beside = benched(trackers="warm_bodies")
    assert set(beside.rows()["tracker"]) == {"mine", "warm_bodies"}


def test_a_program_of_the_folder_protocol_runs_like_others(tmp_path: Path) -> None:
    (tmp_path / "trackers.toml").write_text(
        f"[vots]\ncommand = '{sys.executable} {Path(followers.__file__).with_name('vots_program.py')}'\n"
        "protocol = 'folder'\n"
    )
    vots = process_trackers([str(tmp_path / "trackers.toml")], 60.0)
    outcome = run(experiment_on("frame-out", "fake-town", ["tiny"], vots, range(1), workers=0), tmp_path / "rows")
    assert not outcome.failures, outcome.failures
    assert outcome.silent["vots"] == 239  # Its pictures are black.
    assert dict(outcome.oddities) == {("vots", "gets all pictures of an episode before its first answer"): 1}
    with pytest.raises(
        ValueError, match="real_time: expected none with trackers that get all pictures at once, got vots"
    ):
        experiment_on("frame-out", "fake-town", ["tiny"], vots, range(1), workers=0, real_time_hz=15.0)
    outcome = run(experiment_on("frame-out", "fake-town", ["tiny-loop"], vots, range(1), workers=0), tmp_path / "loop")
    assert outcome.failures[0].reason.startswith("ValueError: tracker: expected one that answers picture by picture")


TABLE = '[mine]\ncommand = "python x.py"\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mine", "process: expected NAME=COMMAND, or a TOML file, got 'mine'"),
        ("a b=python", "process: expected NAME=COMMAND"),
        ("mine=", "process mine: expected a command, got none"),
        ("mine='python", "process mine: expected a command with closed quotes, got "),
        ("mine=no_such_program", "process mine: expected a program, .*, got 'no_such_program'"),
        ("mine=python nix.py", r"process mine: expected a program whose files exist, got no file nix.py in /\S+$"),
        ("mine=python3 x.py --with=nix.toml", "process mine: expected a program whose files exist, got no file nix.to"),
        ("none.toml", "process: expected a TOML file with a table for each tracker, got 'none.toml'"),
        ("[mine", "process: expected a TOML file with a table for each tracker, got "),
        ("# none\n", "process: expected a TOML file with a table for each tracker, got none in 'trackers.toml'"),
        (TABLE + "parameters = {day = 2020-01-01}", "process mine: parameters: expected what JSON has, .* type date"),
        (TABLE + "environment = {'A=B' = 'c'}", "process mine: environment: expected names and values .*'A=B=c'"),
        ("mine = 3", r"process: expected a table \[mine\], got 3"),
        ("[mine]\n", "process mine: expected a command, got none"),
        (TABLE + "sweets = 3", r"process mine: expected one of command, .*; got 'sweets'"),
        (TABLE + 'suites = "frame-out"', "process mine: suites: expected a list of suites, got 'frame-out'"),
        (TABLE + 'suites = ["nix"]', "process mine: suites: expected one of .*; got 'nix'"),
        (TABLE + "start_limit_s = 0", "process mine: start_limit_s: expected a number > 0, at most 1,000,000, got 0"),
        (TABLE + "frame_limit_s = inf", "process mine: frame_limit_s: expected a number > 0, .*, got inf"),
        (TABLE + "protocol = 'mail'", "process mine: protocol: expected 'folder', or none, got 'mail'"),
        (TABLE + "files = [1]", r"process mine: files: expected a list of files, got \[1\]"),
        (TABLE + "memory_limit_gb = true", "process mine: memory_limit_gb: expected a number > 0, .*, got True"),
        (TABLE + 'reproducible = "no"', "process mine: reproducible: expected true or false, got 'no'"),
        (TABLE + 'files = ["nix"]', "process mine: files: expected files that exist, got .*nix"),
        (TABLE + "environment = {X = 1}", "process mine: environment: expected a table of texts, got "),
    ],
)
def test_what_is_no_process_is_named(text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x.py").touch()
    if "\n" in text or "[" in text or " = " in text:
        Path("trackers.toml").write_text(text)
        text = "trackers.toml"
    with pytest.raises(ValueError, match=f"^{message}"):
        process_trackers([text], 60.0)


def test_files_of_other_programs_may_be_elsewhere() -> None:
    """A command of a container names files that only the container has."""
    assert process_trackers(["mine=env docker run image python /app/nix.py"], 60.0)["mine"].name == "mine"


@pytest.mark.parametrize("name", ["hold", "oracle_map"])
def test_names_of_trackers_are_taken(name: str) -> None:
    with pytest.raises(ValueError, match=f"process: expected names that no tracker of .* has, got {name}"):
        process_trackers([f"{name}={sys.executable}"], 60.0)


def test_limits_and_parameters_come_from_the_table(tmp_path: Path) -> None:
    (tmp_path / "x.py").write_text("")
    table = (
        TABLE + "start_limit_s = 7\nmemory_limit_gb = 2.5\nparameters = {size = 3}\nenvironment = {A = 'b'}\n"
        "suites = ['fish']\nreproducible = false\nsummary = 'mine'\nfiles = ['x.py']\n"
    )
    (tmp_path / "trackers.toml").write_text(table.replace("\n", "\r\n"), "utf-8-sig")
    mine = process_trackers([str(tmp_path / "trackers.toml")], 9.0)["mine"]
    assert isinstance(mine, ProcessTracker)
    assert mine.program.command[1:] == (str(tmp_path / "x.py"),)
    assert mine.program.limits == Limits(start_s=7.0, frame_s=90.0, frame_cpu_s=9.0, memory_gb=2.5)
    assert mine.program.environment == (("A", "b"),)
    assert (mine.suites, mine.reproducible, mine.summary) == (("fish",), False, "mine")
    assert mine.parameters.parameters == {"size": 3}


OTHER_NUMPY = "1.26.4" if sys.version_info < (3, 13) else "2.2.6"


@pytest.fixture(scope="session")
def other_python(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a Python with another NumPy; ``FRAMEOUT_OTHER_PYTHON`` names one that there is already."""
    if named := os.environ.get("FRAMEOUT_OTHER_PYTHON"):
        return named
    folder = tmp_path_factory.mktemp("other")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    python = str(folder / "bin" / "python")
    made = subprocess.run([python, "-m", "pip", "install", "-q", f"numpy=={OTHER_NUMPY}"], check=False)
    if made.returncode:
        pytest.skip(f"NumPy {OTHER_NUMPY} cannot be installed here")
    return python


@pytest.mark.heavy
@pytest.mark.parametrize("tracker", FOLLOWERS)
@pytest.mark.parametrize("judging", ["frame-out", "stereo", "fish", "harbour", "follow"])
def test_another_numpy_has_the_same_rows_in_every_suite(
    judging: str, tracker: str, other_python: str, tmp_path: Path
) -> None:
    if judging not in tracker_named(tracker).suites:
        pytest.skip(f"{tracker} is not entered for {judging}")
    judged = suite(judging)
    scenario = catalog.id_of(judged.scenes[0].scenario)
    check_alike(other_python, judging, scenario, judged.quick_preset, tracker, tmp_path)
