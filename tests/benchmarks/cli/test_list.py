"""``frameout list``: surveys of scenarios are stored beside each other and shown in their own columns."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path
from typing import Any, get_args

import pytest

from benchmarks.cli import list_all
from benchmarks.cli.main import main
from benchmarks.contract.suite import suites
from benchmarks.run.editions import preset_edition
from benchmarks.run.selection import trackers_of
from benchmarks.show.definitions import metric_definitions
from scenarios import catalog
from scenarios.road_town.survey import FRAME_OUTS, Held
from tests import fakes_scenario
from trackers.controllers.catalogue import ControllerRole, controllers
from trackers.papers import PAPERS
from trackers.registry import Role

FAKE = "fake-town-v1"


class CountsFrames:
    """See ``scenarios.scenario.Survey``."""

    columns = ("all frames",)

    def measure(self, preset: fakes_scenario.FakeTown, seeds: range) -> dict[str, Any]:
        return {"frames": preset.frame_count * len(seeds)}

    def cells(self, held: dict[str, Any]) -> tuple[str, ...]:
        return (f"{held['frames']} in all",)


SURVEY = CountsFrames()


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file of contents, with the fake town as the only scenario."""
    (entry,) = (entry for entry in catalog.entries() if entry.id == FAKE)
    monkeypatch.setattr(catalog, "_ENTRIES", (dataclasses.replace(entry, survey=f"{__name__}:SURVEY"),))
    monkeypatch.setattr(list_all, "_CONTENTS", tmp_path / "contents.json")
    return tmp_path / "contents.json"


def test_what_is_measured_is_kept_and_shown(
    kept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["list"]) == 0
    assert "contents measured" not in " ".join(capsys.readouterr().out.split())
    kept.write_text(json.dumps({"another-v1": {"holds": {}}}))
    monkeypatch.setattr(list_all, "_MEASURED_SEEDS", range(3))
    assert main(["list", "--measure"]) == 0
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    assert "all frames" in out
    assert "measured over episodes 0:3" in " ".join(out.split())
    presets = catalog.scenario(FAKE).presets
    for configuration in presets.values():
        assert f"{3 * configuration.frame_count} in all" in out
    contents = json.loads(kept.read_text())
    assert contents["another-v1"] == {"holds": {}}
    assert set(contents[FAKE]["holds"]) == set(presets)


def test_a_suite_is_listed_with_the_presets_that_its_scenes_run_with(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {each["name"] for each in told["envs"]} >= set(catalog.envs())
    roles = {each["name"] for each in told["roles"]}
    assert {each["kind"] for each in (*told["trackers"], *told["controllers"])} <= roles
    listed = {each["name"]: each["kind"] for each in told["suites"]}
    steered = "road-town standard; stereo-follow standard; fish-tank standard; harbour patrol"
    # Scenes that other tests registered in this process stand behind the suite's own.
    assert f"{listed['follow']}; ".startswith(f"{steered}; ")
    assert listed["stereo"] == "stereo-follow standard; paper-sheet (--preset paper-b1, paper-b2)"


def test_names_are_whole_in_a_narrow_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where nothing but ``COLUMNS`` tells its width."""
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    words = set(" ".join(lines).split())
    named = {preset for name in catalog.names() for preset in catalog.scenario(name).presets}
    named |= {*trackers_of(), *catalog.envs(), *suites(), *controllers("helicopter"), *controllers("robot")}
    assert named <= words
    assert not [line for line in lines if "…" in line]
    for carrier in ("helicopter", "robot"):
        assert re.search(rf"\bhold +blind +{carrier}", "\n".join(lines))


def test_frame_outs_are_told_in_a_cell_each() -> None:
    held = Held(2, 100, 1.5, 1, 10, 20.5, 30, 0.25, 1.0, 0.125, 0.4)
    cells = FRAME_OUTS.cells(dataclasses.asdict(held))
    assert cells == ("1.5 (≥ 1)", "10 / 20.5 / 30", "25%", "100%", "12%")
    assert len(cells) == len(FRAME_OUTS.columns)


def test_what_is_kept_with_the_code_is_what_surveys_return() -> None:
    contents = json.loads(list_all._CONTENTS.read_text())
    for name, kept in contents.items():
        assert set(kept["holds"]) == set(catalog.scenario(name).presets)
        assert kept["editions"] == {preset: preset_edition(name, preset) for preset in kept["holds"]}
        measured = catalog.survey(name)
        assert measured is not None
        assert all(len(measured.cells(held)) == len(measured.columns) for held in kept["holds"].values())


def test_what_does_not_go_together_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--reference", "--json"]) == 2
    assert "list: expected one of its options, got json, reference" in capsys.readouterr().err


def test_metrics_are_defined_as_text(capsys: pytest.CaptureFixture[str]) -> None:
    defined = [each for its_suite in suites().values() for each in metric_definitions(its_suite)]
    known = {(name, metric.name) for name, each in suites().items() for metric in each.metrics}
    assert {(each["suite"], each["name"]) for each in defined} >= known
    assert main(["list", "--metrics"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if not line.startswith(" ")] == [f"{e['suite']}: {e['name']}" for e in defined]
    for part in ("formula", "range", "unit", "better", "conditions", "source"):
        told = [line.split(":", 1)[1].strip() for line in lines if line.startswith(f"    {part}:")]
        assert told == [each[part] for each in defined]
        assert all(told)


def test_papers_are_told_with_the_methods() -> None:
    told = list_all._everything()["papers"]
    assert [each["reference"] for each in told] == [each.reference() for each in PAPERS.values()]
    assert [each["name"] for each in told] == [f"paper {letter}" for letter in "ABCD"]


def test_every_role_is_explained() -> None:
    assert set(list_all._ROLES) == {*get_args(Role), *get_args(ControllerRole)}
