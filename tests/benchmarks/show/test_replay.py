"""Scored and shown runs of an episode are the same: the same commands and the same failures."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli import main as cli
from benchmarks.contract import suite as registry
from benchmarks.contract.rows import read_rows
from benchmarks.run.jobs import opened
from benchmarks.run.selection import job_of
from benchmarks.show.replay import replay
from tests import fakes_scenario
from tests.benchmarks.named import NamedExperiment as Experiment
from tests.benchmarks.named import run_named as run
from tests.benchmarks.run.fake_steering import FAKE_CONTROLLERS, FAKE_FOLLOW
from trackers.controllers import catalogue
from trackers.types import CameraCommand

Commands = list[CameraCommand | None]
TRACKER = "fake_knowing"


@pytest.fixture(autouse=True)
def obeyed(monkeypatch: pytest.MonkeyPatch) -> Commands:
    """Return what the carrier gets from now on, in a world of arithmetic that the suite ``follow`` is about."""
    registry.suites()
    monkeypatch.setitem(registry._SUITES, "follow", FAKE_FOLLOW)
    for entry in FAKE_CONTROLLERS:
        monkeypatch.setitem(catalogue._ENTRIES, (entry.carrier, entry.name), entry)
    commands: Commands = []
    step = fakes_scenario.FakeEpisode.step

    def noted(self: Any, command: CameraCommand | None = None) -> Any:
        commands.append(command)
        return step(self, command)

    monkeypatch.setattr(fakes_scenario.FakeEpisode, "step", noted)
    return commands


def scored(out: Path, obeyed: Commands, **changes: Any) -> Commands:
    """Run one episode of a suite; return what the carrier got."""
    experiment = Experiment(
        suite="follow",
        scenario=fakes_scenario.FAKE_TOWN.id,
        presets=("tiny",),
        trackers=(TRACKER,),
        controllers=("centre",),
        seeds=range(3, 4),
        workers=0,
    )
    run(replace(experiment, **changes), out)
    return taken(obeyed)


def taken(obeyed: Commands) -> Commands:
    """Return the commands noted so far, and forget them."""
    commands = obeyed.copy()
    obeyed.clear()
    return commands


@pytest.mark.heavy
@pytest.mark.parametrize("link", ["prompt", "noisy"])
def test_render_shows_what_the_suite_of_controllers_scores(link: str, tmp_path: Path, obeyed: Commands) -> None:
    expected = scored(tmp_path, obeyed, link=link)
    words = ["render", "fake-town", "--preset", "tiny", "--seed", "3", "--tracker", TRACKER, "--controller", "centre"]
    words += ["--frames", "40", "--scale", "1", "--out", str(tmp_path / "x.mp4")]
    assert cli.main(words if link == "prompt" else [*words, "--link", link]) == 0
    shown = taken(obeyed)
    assert len(shown) == 40
    assert shown == expected[:40]
    assert len({command for command in shown if command is not None}) > 20, "it is steered"


@pytest.mark.heavy
def test_a_preset_that_is_steered_by_itself_is_shown_as_suites_of_trackers_have_it(
    tmp_path: Path, obeyed: Commands
) -> None:
    expected = scored(tmp_path / "as written", obeyed, suite="frame-out", presets=("tiny-loop",))
    linked = scored(tmp_path / "linked", obeyed, presets=("tiny-loop",))
    words = ["render", "fake-town", "--preset", "tiny-loop", "--seed", "3", "--tracker", TRACKER]
    words += ["--controller", "centre", "--frames", "40", "--scale", "1", "--out", str(tmp_path / "x.mp4")]
    assert cli.main(words) == 0
    assert taken(obeyed) == expected[:40] != linked[:40]
    assert cli.main([*words, "--link", "prompt"]) == 0
    assert taken(obeyed) == linked[:40]


@pytest.mark.heavy
@pytest.mark.parametrize(
    "changes",
    [{}, {"link": "delayed"}, {"suite": "frame-out", "presets": ("tiny-loop",)}, {"suite": "frame-out"}],
)
def test_a_run_named_by_its_row_is_repeated_as_it_was_scored(
    changes: dict[str, Any], tmp_path: Path, obeyed: Commands
) -> None:
    """The report's pictures are made from such runs."""
    expected = scored(tmp_path, obeyed, **changes)
    row = read_rows(tmp_path)[0]
    with opened(job_of(row, row["seed"])) as live:
        count = live.loop.episode.frame_count
        instants = list(replay(live, scale=1.0, wanted=(5,), frame_count=count))
    assert taken(obeyed) == expected
    assert [instant.frame.truth.frame for instant in instants] == [5]


def test_a_failed_one_is_shown_silent_and_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["render", "fake-town", "--preset", "tiny", "--tracker", "fake_raises", "--scale", "1", "--frames", "23"]
    assert cli.main([*words, "--controller", "fake_raises", "--out", str(tmp_path / "x.mp4")]) == 1
    out, err = capsys.readouterr()
    assert out == f"{tmp_path / 'x.mp4'}\n"
    failures = [line for line in err.splitlines() if line.startswith("error:")]
    assert [re.findall(r"frame \d+: [^;(]*", line) for line in failures] == [["frame 20: RuntimeError: a bug "]] * 2
    assert [line.split()[-1] for line in failures] == ["nothing", "nothing"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--controller", "centre"], "tracker: expected a name, as 'centre' steers by one, got none"),
        (["--link", "noisy"], "controller: expected a name, whose commands take the link 'noisy', got none"),
        (
            ["--controller", "centre", "--tracker", TRACKER, "--link", "nix"],
            "link: expected one of prompt, delayed, noisy, late, got 'nix'",
        ),
        (["--preset", "nix"], "preset: expected one of"),
    ],
)
def test_what_cannot_be_shown_is_reported_in_one_line(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    town = "road-town" if "--preset" in words else "fake-town"
    preset = [] if "--preset" in words else ["--preset", "tiny"]
    assert cli.main(["render", town, *preset, *words, "--out", str(tmp_path / "x.mp4")]) == 2
    (line,) = (line for line in capsys.readouterr().err.splitlines() if not line.startswith("compiling kernels"))
    assert line.startswith(f"error: {message}")
