"""Which controllers steer by default, and whose failure the end of a process is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.contract.suite import suite
from benchmarks.run.episodes import simulated
from benchmarks.run.failures import ENDED_PROCESS
from benchmarks.run.jobs import Job, _noting, read_note, run_job
from benchmarks.run.selection import choices, default_controllers, tracker_named
from scenarios import catalog
from tests.benchmarks.run.fake_steering import NothingToSet, RaisingController
from tests.fakes_scenario import FAKE_TOWN
from trackers.controllers import catalogue
from trackers.controllers.catalogue import ControllerEntry
from trackers.types import CameraCommand, Estimate, Observation


def test_all_controllers_of_the_carrier_steer_by_default() -> None:
    scenario = "road-town-v2"
    (choice,) = choices(suite("follow"), scenarios=(scenario,), variants=False)
    assert {"hold", "centre", "search", "reentry"} <= set(choice.controllers)
    assert choice.controllers == default_controllers(catalog.scenario(scenario))


def test_ablations_steer_only_if_they_are_asked_for() -> None:
    assert "centre_as_written" not in default_controllers(catalog.scenario("road-town"))
    assert "centre_as_written" in default_controllers(catalog.scenario("road-town"), variants=True)


def test_a_short_note_takes_the_place_of_a_long_one(tmp_path: Path) -> None:
    with _noting(tmp_path / "note") as note:
        for name in (f"policy:{200 * 'ü'}.json", "centre"):
            note(name, 7)
            assert read_note(tmp_path / "note") == (name, 7)
    assert read_note(tmp_path / "note") is None


def test_the_note_names_a_controller_on_its_turns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the tracker is taken for the one that ended the process."""
    noted: list[tuple[str, int] | None] = []

    class Reads(RaisingController):
        def __init__(self, parameters: NothingToSet) -> None:
            super().__init__(parameters)
            noted.append(read_note(job.note_file))

        def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
            noted.append(read_note(job.note_file))
            return CameraCommand()

    episode = simulated(FAKE_TOWN.id, "tiny-loop", 0, controller="reads", changed={"frame_count": 4})
    job = Job(suite("frame-out"), episode, {"fake_still": tracker_named("fake_still")}, out=tmp_path)
    monkeypatch.setitem(
        catalogue._ENTRIES, ("helicopter", "reads"), ControllerEntry("reads", "helicopter", "external", "", Reads)
    )
    assert run_job(job).failures == []
    assert noted == [("reads", frame) for frame in range(4)]
    noted.clear()
    (failure,) = run_job(replace(job, deadly={"reads": 2})).failures
    assert (failure.tracker, failure.frame, failure.reason) == ("reads", 2, ENDED_PROCESS)
    assert noted == [("reads", 0), ("reads", 1)]
