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

from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.judges.tracker_speed import times
from benchmarks.run.experiment import run
from benchmarks.run.process_trackers import process_trackers
from benchmarks.run.selection import experiment_on, tracker_named
from scenarios import catalog
from tests import fakes_scenario  # noqa: F401
from tests.toy_scene import register  # noqa: F401
from tests.trackers.clients import followers

FOLLOWERS = {"follows_one": "one", "follows_many": "many"}
TIMES = {score.metric for score in times([(1.0, 1.0)] * 10, (0.0, 0.0), 10)}


def program(folder: Path) -> Path:
    """Return the file of the followers, with nothing beside it."""
    return Path(shutil.copy(followers.__file__, folder))


def rows_of(judging: str, scenario: str, preset: str, tracker: TrackerSpec, out: Path) -> list[dict[str, Any]]:
    """Return the rows of two episodes, without what depends on time, and on how the tracker is called."""
    how: dict[str, Any] = {"workers": 0, "repeats": 2}
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


OTHER_NUMPY = "1.26.4"


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
