"""The papers' experiments: they name things that exist, judge claims rightly, and leave rows, figure and page."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType

import cv2
import pytest

from benchmarks.papers import a2, a3
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.papers.repeat import findings
from benchmarks.run.contestants import entrants
from benchmarks.suites.registry import suite
from scenarios import catalog
from trackers import registry
from trackers.controllers.catalogue import controllers

EXPERIMENTS = (a2.EXPERIMENT, a3.EXPERIMENT)


@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda each: each.name)
def test_an_experiment_names_what_exists(experiment: PaperExperiment) -> None:
    preset = catalog.scenario("road-town").presets[experiment.preset]
    assert preset.closed_loop == (experiment.controller is not None)
    assert experiment.controller is None or experiment.controller in controllers("helicopter")
    assert max(experiment.frames) < preset.frame_count
    for tracker in experiment.trackers:
        assert entrants()[tracker].role == "as-written"
    for claim in experiment.claims:
        assert claim.tracker in experiment.trackers
        assert suite("frame-out").metric(claim.metric).unit == "fraction"
        assert 0 < claim.level < 1


@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda each: each.name)
def test_methods_are_set_as_they_were_written_whatever_tuning_found(
    experiment: PaperExperiment, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "tuned_values", lambda name: {"colour_sharpness": 99.0})
    for name, values in experiment.settings.items():
        assert registry.entry(name).parameters().colour_sharpness == 99.0
        assert registry.entry(name).parameters(**values) == registry.entry(name).tracker.Parameters()


def test_frames_and_bounds_are_those_of_paper_and_issue() -> None:
    assert a2.EXPERIMENT.frames == (10, 65, 80)
    assert a3.EXPERIMENT.frames == (40, 80, 120, 160)
    bounds = {(c.tracker, c.metric, c.bound, c.level) for each in EXPERIMENTS for c in each.claims}
    assert bounds == {
        ("colour_pf", "kept_run_rate", "at most", 0.2),
        ("road_shape_pf", "kept_run_rate", "at least", 0.9),
        ("background_pf", "road_kept_rate", "at least", 0.7),
        ("background_pf", "excursion_kept_rate", "at most", 0.3),
    }


@pytest.mark.parametrize(
    ("mean", "metric", "agrees"),
    [
        (0.70, "road_kept_rate", True),
        (0.69, "road_kept_rate", False),
        (0.30, "excursion_kept_rate", True),
        (0.31, "excursion_kept_rate", False),
        (None, "road_kept_rate", False),
    ],
)
def test_a_claim_is_judged_by_its_bound(mean: float | None, metric: str, agrees: bool) -> None:
    entry = {"preset": "paper-a3", "tracker": "background_pf", "metric": metric, "mean": mean}
    entry |= {"renderer": "raster", "unit": "fraction", "ci_low": 0.1, "ci_high": 0.9, "n": 50}
    strangers = [{**entry, "preset": "standard"}, {**entry, "tracker": "colour_pf"}]
    found = {each.claim.metric: each for each in findings(a3.EXPERIMENT, [*strangers, entry])}
    assert found[metric].agrees == agrees
    assert found[metric].interval == "10.0 … 90.0"
    # Of the other claim nothing is known: that is said, and is no agreement.
    (other,) = found.keys() - {metric}
    assert (found[other].value, found[other].episodes, found[other].agrees) == ("–", 0, False)


def test_both_renderers_are_shown_where_both_were_run() -> None:
    entry = {"preset": "paper-a2", "tracker": "colour_pf", "metric": "kept_run_rate", "mean": 0.1}
    entry |= {"unit": "fraction", "ci_low": 0.0, "ci_high": 0.2, "n": 50}
    found = findings(a2.EXPERIMENT, [{**entry, "renderer": name} for name in ("raster", "pybullet")])
    assert [(each.claim.tracker, each.renderer, each.episodes) for each in found] == [
        ("colour_pf", "raster", 50),
        ("colour_pf", "pybullet", 50),
        ("road_shape_pf", "raster", 0),
        ("road_shape_pf", "pybullet", 0),
    ]


@pytest.mark.parametrize("paper", [a2, a3], ids=lambda module: module.EXPERIMENT.name)
def test_a_run_leaves_rows_figure_and_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], paper: ModuleType
) -> None:
    experiment = paper.EXPERIMENT
    paper.run(tmp_path, range(1), "raster", 0)
    printed = capsys.readouterr().out
    assert "paper.html" in printed
    rows = [json.loads(line) for line in (tmp_path / "records.jsonl").read_text().splitlines()]
    assert {row["tracker"] for row in rows} == set(experiment.trackers)
    assert {row["preset"] for row in rows} == {experiment.preset}
    page = (tmp_path / "paper.html").read_text()
    for claim in experiment.claims:
        assert claim.words in page
    picture = cv2.imread(str(tmp_path / "pictures" / f"paper-{experiment.name.lower()}-raster.jpg"))
    height, width = picture.shape[:2]
    # As many pictures beside each other as the paper shows, as many rows as methods; 4:3 each, and a strip of words.
    shape = (width / len(experiment.frames)) / (height / len(experiment.trackers))
    assert 1.2 < shape < 4 / 3
