"""``--modules`` with every command: a user's tracker in a file takes part, and what is printed runs verbatim."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from joblib.externals.loky import get_reusable_executor

from benchmarks.cli import main as cli
from benchmarks.cli import tune as tune_command
from benchmarks.cli.arguments import WithModules
from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.learning.tuning import Search, Tuned
from trackers import registry

ROOT = Path(__file__).parents[3]
TRACKER = """
from dataclasses import dataclass

from trackers.registry import register, tunable
from trackers.types import Estimate


@dataclass(frozen=True)
class Parameters:
    gain: float = tunable(1.0, 0.5, 2.0)


@register("waits", role="external", summary="stays where the car was")
class Waits:
    Parameters = Parameters

    def __init__(self, parameters, rng):
        pass

    def initialise(self, observation, box_xyxy):
        self._middle = (box_xyxy[:2] + box_xyxy[2:]) / 2

    def update(self, observation):
        return Estimate(position_px=self._middle)
"""
FOR_ALL_EPISODES = {"bench", "compare", "export", "generate", "list", "play", "render", "report"}
WITH_MODULES = FOR_ALL_EPISODES | {"merge", "rollout", "score", "track", "train", "tune", "verify"}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A file beside a folder with the name of one of our packages; registered here for one test alone."""
    # Worker processes that an earlier test has left would look for the file in the folder of that test.
    get_reusable_executor().shutdown(wait=True)
    monkeypatch.setattr(registry, "_ENTRIES", registry.entries())
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "my_waiting", raising=False)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trackers").mkdir()
    (tmp_path / "my_waiting.py").write_text(TRACKER)
    return "my_waiting.py"


def test_every_command_about_trackers_or_episodes_has_the_option() -> None:
    kinds: dict[str, Any] = {name: cli._kind(cli.FRAMEOUT, name) for name in cli.FRAMEOUT.commands}
    assert {name for name, kind in kinds.items() if issubclass(kind, WithModules)} == WITH_MODULES
    fields = {name for name, kind in kinds.items() if "modules" in {each.name for each in dataclasses.fields(kind)}}
    assert fields == WITH_MODULES


@pytest.mark.heavy
@pytest.mark.usefixtures("fake_suite")
def test_the_command_on_the_report_of_an_own_tracker_runs_as_it_stands(own: str, tmp_path: Path) -> None:
    words = ["--trackers", "waits", "fake_still", "--seeds", "0:1", "--modules", "tests.fakes_scenario", own]
    assert main(["bench", "--workers", "2", *words]) == 0
    page = Path("results/frame-out/report.html").read_text()
    assert "role-external" in page
    assert "var(--own)" in page
    (command,) = re.findall(r"<code>(frameout bench[^<]*)</code>", page)
    assert command.endswith(f"--trackers fake_still waits --modules tests.fakes_scenario {own}")
    rows = read_rows(Path("results/frame-out"))
    # Its rows are there: nothing is run again, since they are of the same code.
    assert main(shlex.split(command)[1:]) == 0
    assert read_rows(Path("results/frame-out")) == rows
    comparisons = json.loads(Path("results/frame-out/comparisons.json").read_text())
    assert {(entry["tracker"], entry["other"]) for entry in comparisons} == {("waits", "fake_still")}
    assert main(["compare", "waits", "fake_still", "--modules", own]) == 0


def test_an_own_tracker_is_tuned_in_processes_that_know_it_and_the_file_says_how(
    own: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Search] = []

    def tuned(search: Search, *_: object) -> Tuned:
        asked.append(search)
        return Tuned({}, 1.0, 1.0, 1.0, 1.0, trials=40)

    monkeypatch.setattr(tune_command, "tune", tuned)
    assert main(["tune", "waits", "--out", "tuned", "--modules", own]) == 0
    assert [search.modules for search in asked] == [(own,)]
    told = json.loads(Path("tuned/waits.json").read_text())["command"]
    assert told.endswith(f" --modules {own}")


@pytest.mark.parametrize(
    ("command", "status", "told"),
    [
        ([str(Path(sys.executable).with_name("frameout"))], 0, "frameout "),
        (
            [sys.executable, "-m", "benchmarks.cli.main"],
            2,
            r"error: sim: expected Frameout's package in \S+, got {place}, ",
        ),
    ],
)
def test_a_folder_with_our_name_where_the_command_starts(
    command: list[str], status: int, told: str, tmp_path: Path
) -> None:
    """The command does not look there; ``python -m`` does, and the user learns which folder it is."""
    (tmp_path / "sim").mkdir()
    (tmp_path / "sim" / "__init__.py").touch()
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [*command, "--version"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == status, done.stderr
    assert re.match(told.format(place=tmp_path / "sim"), done.stdout + done.stderr)
