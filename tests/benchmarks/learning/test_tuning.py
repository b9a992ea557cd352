from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.contract.suite import Scene
from benchmarks.contract.suite import suite as registered
from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.learning import tuning
from benchmarks.learning.tuning import (
    NO_VALUES,
    ControllerSearch,
    Settings,
    TrackerSearch,
    failures_in_words,
    rows_of,
    trackers_to_tune,
    tune,
    write_tuned,
)
from benchmarks.run.failures import Failure
from benchmarks.run.selection import job_on
from tests import fakes_scenario, fakes_trackers
from trackers.registry import entry, register, tunable, tuned_file
from trackers.types import Estimate, Observation


@dataclass(frozen=True)
class ShakyParameters:
    """Its error."""

    off_m: float = tunable(20.0, 0.0, 40.0)
    ignored: int = tunable(3, 1, 5)


@register("fake_shaky", role="baseline", summary="knows the circle, but for a constant error")
class Shaky(fakes_trackers.Knowing):
    """Is better with smaller ``off_m``."""

    Parameters = ShakyParameters  # type: ignore[assignment]

    def __init__(self, parameters: ShakyParameters, rng: np.random.Generator) -> None:
        super().__init__(fakes_trackers.NoParameters(), rng)
        self._off_px = parameters.off_m * fakes_scenario.CAMERA.focal_px / fakes_scenario.HEIGHT_M

    def misbehave(self, observation: Observation) -> Estimate:
        right = super().misbehave(observation)
        return Estimate(right.position_px + np.array([self._off_px, 0.0]))


@pytest.fixture(autouse=True)
def _fake_suite(monkeypatch: pytest.MonkeyPatch) -> None:
    fake = replace(FRAME_OUT, scenes=(Scene(fakes_scenario.FAKE_TOWN.id, "frame-out"),))
    monkeypatch.setattr(tuning, "suite", lambda name: fake if name == "frame-out" else registered(name))


def search(fresh_presets: tuple[str, ...] = ("tiny",), trials: int = 20) -> TrackerSearch:
    return TrackerSearch(
        name="fake_shaky",
        suite="frame-out",
        scenario=fakes_scenario.FAKE_TOWN.id,
        presets=("tiny",),
        seeds=range(1),
        fresh_presets=fresh_presets,
        fresh=range(1, 3),
        trials=trials,
        workers=0,
    )


def nothing(done: int, of: int) -> None:
    pass


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Settings, tuple[str, ...], range]]:
    """The settings, presets and seeds that are scored: the higher ``off_m`` the better, but in the check."""
    pytest.importorskip("optuna")
    found: list[tuple[Settings, tuple[str, ...], range]] = []

    def scores(
        self: TrackerSearch, settings: Settings, presets: tuple[str, ...], seeds: range, pictures: bool = False
    ) -> dict[str, float]:
        found.append((settings, presets, seeds))
        sign = -1.0 if presets == ("tiny-loop",) else 1.0
        return {label: sign * values["off_m"] for label, values in settings.items()}

    monkeypatch.setattr(TrackerSearch, "scores", scores)
    return found


@pytest.mark.heavy
def test_a_search_finds_the_better_setting_within_its_budget(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    tuned = tune(search(), lambda done, of: told.append((done, of)))
    assert tuned.trials == 20
    assert told[-1] == (20, 20)
    assert tuned.parameters["off_m"] < 5.0
    assert isinstance(tuned.parameters["ignored"], int)
    assert tuned.score > tuned.default_score
    assert tuned.check_score > tuned.check_default_score
    assert tuned.fresh is not None
    assert tuned.fresh["seeds"] == "9000:9008"
    assert tuned.fresh["tuned"] > tuned.fresh["written"]
    assert tune(search(), nothing) == tuned

    path = write_tuned(search(), tuned, "frameout tune fake_shaky", tmp_path)
    document = json.loads(path.read_text())
    assert path.name == "fake_shaky.json"
    assert document["parameters"] == tuned.parameters
    for key in ("score", "trials", "seeds", "suite", "preset", "command"):
        assert key in document
    assert entry("fake_shaky").parameters(**document["parameters"]).off_m == tuned.parameters["off_m"]
    assert document["episodes"] == 1
    assert document["fresh"] == tuned.fresh
    # The scores of a file are those of its own function.
    settings = {"tuned": tuned.parameters, "written": entry("fake_shaky").written()}
    scores = search().scores(settings, ("tiny",), range(1))
    assert scores == pytest.approx({"tuned": document["score"], "written": document["default_score"]}, abs=1e-6)


def test_a_tracker_that_lacks_a_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("optuna")

    def init(*given: object) -> None:
        raise ModuleNotFoundError("No module named 'torch'")

    monkeypatch.setattr(Shaky, "__init__", init)
    told = "^tracker: expected one that can begin, got fake_shaky: ModuleNotFoundError: No module named 'torch'$"
    with pytest.raises(ValueError, match=told):
        tune(search(trials=2), nothing)


def test_the_first_setting_tried_is_the_default(asked: list[Any]) -> None:
    tune(search(), nothing)
    tried = [values for settings, _, seeds in asked if seeds == range(1) for values in settings.values()]
    assert tried[0] == {"off_m": 20.0, "ignored": 3}
    assert len(tried) == 20
    assert all(0.0 <= values["off_m"] <= 40.0 and 1 <= values["ignored"] <= 5 for values in tried)


def test_a_setting_that_was_only_lucky_leaves_the_defaults_in_place(
    asked: list[Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The check is on the preset that it names, and announced."""
    tuned = tune(search(fresh_presets=("tiny-loop",)), nothing)
    assert tuned.parameters == {}
    assert tuned.score == -tuned.check_score > tuned.default_score == -tuned.check_default_score == 20.0
    written = json.loads(write_tuned(search(), tuned, "", tmp_path).read_text())
    assert (written["fresh"], written["no_fresh"]) == (None, NO_VALUES)
    assert (asked[-1][1], asked[-1][2]) == (("tiny-loop",), range(1, 3))
    told = "fake_shaky: the best setting and the defaults now run on 2 fresh episodes …\n"
    assert capsys.readouterr().err == told


def test_fresh_scores_are_those_of_tuned_and_written_values_on_seeds_of_no_search(asked: list[Any]) -> None:
    tuned = tune(search(), nothing)
    settings, presets, seeds = asked[-1]
    assert tuned.parameters["off_m"] > 20.0
    assert settings == {"written": {"off_m": 20.0, "ignored": 3}, "tuned": tuned.parameters}
    assert (presets, seeds) == (("tiny",), range(9_000, 9_008))
    assert tuned.fresh == {"seeds": "9000:9008", "written": 20.0, "tuned": round(tuned.parameters["off_m"], 6)}
    tune(replace(search(), seeds=range(64)), nothing)
    assert asked[-1][2] == range(9_000, 9_064)


def test_every_as_written_and_own_tracker_declares_what_is_tuned() -> None:
    own = {"colour_pf", "road_shape_pf", "background_pf", "mosaic_graph_pf", "hold", "constant_velocity"}
    assert own <= set(trackers_to_tune())


def test_every_file_says_on_how_many_episodes_and_what_fresh_ones_gave() -> None:
    folder = tuned_file("hold", "trackers.baselines.single_target").parent
    for file in sorted(folder.rglob("*.json")):
        found = json.loads(file.read_text())
        first, end = map(int, found["seeds"].split(":"))
        assert found["episodes"] == len(found["preset"].split()) * (end - first), file.name
        fresh = found["fresh"]
        if fresh is None:
            assert found["no_fresh"] == NO_VALUES, file.name
            assert not found["parameters"], file.name
        else:
            assert set(fresh) == {"seeds", "written", "tuned"}, file.name
            assert int(fresh["seeds"].split(":")[0]) >= end, file.name
            assert "no_fresh" not in found, file.name


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("carrier", "scenario", "tracker"),
    [("helicopter", "road-town-v2", "mosaic_graph_pf"), ("robot", "stereo-follow-v2", "stereo_people")],
)
def test_the_scores_of_a_controller_are_those_of_its_function(
    carrier: str, scenario: str, tracker: str, tmp_path: Path
) -> None:
    """Where a scene or an error model has changed, ``frameout tune`` makes them anew."""
    stored = json.loads(tuned_file(f"controllers/{carrier}/reentry", "trackers.controllers.reentry").read_text())
    seeds = range(*map(int, stored["seeds"].split(":")))
    own = ControllerSearch(
        name="reentry",
        suite="follow",
        scenario=scenario,
        tracker=tracker,
        presets=(stored["preset"],),
        seeds=seeds,
        fresh_presets=(stored["preset"],),
        fresh=range(0),
        trials=0,
        workers=0,
        cache=tmp_path,
    )
    scores = own.scores({"tuned": stored["parameters"], "written": own.entry.written()}, own.presets, seeds)
    assert scores["tuned"] == pytest.approx(stored["score"], abs=1e-6)
    assert scores["written"] == pytest.approx(stored["default_score"], abs=1e-6)


@pytest.mark.heavy
@pytest.mark.parametrize("values", [{}, {"gain_per_s": 3.0}])
def test_answers_played_to_a_head_give_the_scores_of_whole_episodes(values: dict[str, float], tmp_path: Path) -> None:
    """The tracker watches a camera at rest; a row has seven digits."""
    own = ControllerSearch(
        name="lead",
        suite="follow",
        scenario="fish-tank-v1",
        tracker="shoal_chain",
        presets=("quick",),
        seeds=range(1),
        fresh_presets=("quick",),
        fresh=range(0),
        trials=0,
        workers=0,
        cache=tmp_path / "episodes",
        runs=tmp_path / "runs",
    )
    seeds = range(1002, 1003)
    played = own.scores({"it": values}, own.presets, seeds, pictures=True)["it"]
    assert played == pytest.approx(own._with_pictures(values, seeds), abs=2e-6)
    assert own.failures == []
    assert len(list((tmp_path / "runs").iterdir())) == 1


def test_all_of_a_suite_were_tuned_for_one_score() -> None:
    folder = tuned_file("hold", "trackers.baselines.single_target").parent
    for file in sorted(folder.glob("*.json")):
        found = json.loads(file.read_text())
        told = " + ".join(f"{factor:g} {metric}" for metric, factor in registered(found["suite"]).tuned_for.items())
        assert found["score_is"] == told, file.name


def test_a_search_goes_on_unless_what_it_depends_on_has_changed(asked: list[Any], tmp_path: Path) -> None:
    def tried(given: TrackerSearch) -> int:
        """Return how many settings a search scores on its own episodes."""
        asked.clear()
        assert tune(given, nothing, tmp_path).trials == given.trials
        return sum(len(settings) for settings, _, seeds in asked if seeds == given.seeds)

    assert tried(search(trials=3)) == 3
    assert tried(search(trials=5)) == 2
    assert tried(replace(search(trials=5), seeds=range(5, 6))) == 5


@pytest.mark.heavy
def test_a_tracker_that_ends_its_process_scores_as_one_without_answers() -> None:
    town, modules = fakes_scenario.FAKE_TOWN.id, ("tests.fakes_scenario",)
    trackers = ("fake_kills", "fake_silent")
    jobs = [job_on("frame-out", town, "tiny", seed, trackers, modules=modules) for seed in (1, 0)]
    failures: list[Failure] = []
    rows = [row for row in rows_of(jobs, 2, failures) if row["metric"] == "offscreen_error_m"]
    values = {name: [(row["seed"], row["value"]) for row in rows if row["tracker"] == name] for name in trackers}
    assert values["fake_kills"] == values["fake_silent"]
    assert list(dict(values["fake_kills"])) == [1, 0]
    assert [(failure.tracker, failure.seed) for failure in failures] == [("fake_kills", 1), ("fake_kills", 0)]


def test_what_failed_is_told_in_the_last_line_of_a_search() -> None:
    failed = [Failure("hold#1", "town", "quick", seed, 3, "RuntimeError: a bug") for seed in range(3)]
    failed += [Failure("hold#2", "town", "quick", 0, 5, "took longer than 600 s of CPU time over one frame")]
    assert failures_in_words(failed) == (
        "; 4 runs failed, which counts as no answer: RuntimeError: a bug (3 times), "
        "took longer than 600 s of CPU time over one frame (1 time)"
    )
    assert failures_in_words([]) == ""
