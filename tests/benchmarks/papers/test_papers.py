"""The papers' experiments: they name things that exist, judge claims rightly, and leave rows, figure and page."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import pytest

from benchmarks.cli import main
from benchmarks.commands import paper
from benchmarks.papers import a2, a3, b1, b2, b3, c, d
from benchmarks.papers.claims import print_findings
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.papers.repeat import findings, repeat
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.run.contestants import entrants
from benchmarks.run.records import Row, append_block
from benchmarks.suites.registry import suite
from scenarios import catalog
from trackers import registry
from trackers.controllers.catalogue import controllers

EXPERIMENTS = (a2.EXPERIMENT, a3.EXPERIMENT)
ALL = (*EXPERIMENTS, b1.EXPERIMENT, b2.EXPERIMENT, b3.EXPERIMENT)


def row(experiment: TrackerExperiment, tracker: str, metric: str, value: float, seed: int = 0, **more: Any) -> Row:
    """A row of an experiment."""
    heading = {name: getattr(experiment, name) for name in ("suite", "scenario", "preset", "controller")}
    ending = {"renderer": "raster", "seed": seed, "weight": 1.0, "frame_out": None}
    return {**heading, "tracker": tracker, "metric": metric, "value": value, **ending, **more}


@pytest.mark.parametrize("experiment", [*EXPERIMENTS, b3.EXPERIMENT], ids=lambda each: each.name)
def test_an_experiment_names_what_exists(experiment: TrackerExperiment) -> None:
    preset = catalog.scenario(experiment.scenario).presets[experiment.preset]
    assert experiment.scenario in catalog.names()
    assert preset.closed_loop == (experiment.controller is not None)
    assert experiment.controller is None or experiment.controller in controllers("helicopter")
    assert max(experiment.frames, default=0) < preset.frame_count
    for tracker in experiment.trackers:
        assert entrants()[tracker].role == "as-written"
    for claim in experiment.claims:
        assert claim.tracker in experiment.trackers
        assert suite(experiment.suite).metric(claim.metric).unit == "fraction"
        assert 0 < claim.level < 1


AS_WRITTEN = (*EXPERIMENTS, *(each.EXPERIMENT for each in (b3, c, d)))


@pytest.mark.parametrize("experiment", AS_WRITTEN, ids=lambda each: each.name)
def test_methods_are_set_as_they_were_written_whatever_tuning_found(
    experiment: TrackerExperiment, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "tuned_values", lambda name, module: {"no_such_parameter": 99.0})
    as_written = [name for name in experiment.trackers if registry.entry(name).role == "as-written"]
    assert as_written
    for name in as_written:
        assert registry.entry(name).parameters() == registry.entry(name).tracker.Parameters()


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
    kind = metric.split("_")[0]
    rows = [row(a3.EXPERIMENT, "background_pf", "frames", 1.0)]
    for seed in range(100 if mean is not None else 0):
        kept = float(seed < round(100 * mean))
        rows.append(row(a3.EXPERIMENT, "background_pf", "kept", kept, seed, frame_out={"kind": kind}))
        rows.append(row(a3.EXPERIMENT, "colour_pf", "kept", 1.0 - kept, seed, frame_out={"kind": kind}))
    found = {each.claim.metric: each for each in findings(a3.EXPERIMENT, rows)}
    assert found[metric].agrees == agrees
    assert found[metric].mean == (mean if mean is None else pytest.approx(mean))
    # The other claim has no value, which is shown and is no agreement.
    (other,) = found.keys() - {metric}
    assert (found[other].value, found[other].episodes, found[other].agrees) == ("–", 0, False)


def test_both_renderers_are_shown_where_both_were_run() -> None:
    renderers = ("raster", "pybullet")
    rows = [row(a2.EXPERIMENT, "colour_pf", "run_kept", 1.0, seed, renderer=r) for r in renderers for seed in range(5)]
    found = findings(a2.EXPERIMENT, rows)
    assert [(each.claim.tracker, each.renderer, each.episodes) for each in found] == [
        ("colour_pf", "raster", 5),
        ("colour_pf", "pybullet", 5),
        ("road_shape_pf", "raster", 0),
        ("road_shape_pf", "pybullet", 0),
    ]


def test_rows_of_something_else_in_the_folder_count_for_nothing(tmp_path: Path) -> None:
    mine = row(a2.EXPERIMENT, "colour_pf", "frames", 80.0)
    for more in ({"suite": "paper"}, {"scenario": "x-v1"}, {"preset": "standard"}, {"controller": None}, {}):
        append_block(tmp_path, [{**mine, **more}])
    append_block(tmp_path, [{**mine, "renderer": "pybullet"}])
    assert [(each["renderer"], each["value"]) for each in a2.EXPERIMENT.rows_in(tmp_path)] == [
        ("pybullet", 80.0),
        ("raster", 80.0),
    ]


@pytest.mark.parametrize("experiment", ALL, ids=lambda each: each.name)
def test_the_command_repeats_it_with_its_own_seeds(
    experiment: PaperExperiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr(paper, "repeat", lambda *given: asked.append(given))
    assert main(["paper", experiment.name, "--out", str(tmp_path), "--workers", "1"]) == 0
    count = 10 if experiment is b3.EXPERIMENT else 50
    assert asked == [(experiment, tmp_path, range(10_000, 10_000 + count), "raster", 1)]


def test_the_command_takes_no_folder_of_something_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(paper, "repeat", lambda *given: None)
    mine = row(a2.EXPERIMENT, "colour_pf", "frames", 80.0)
    append_block(tmp_path, [{**mine, "renderer": "pybullet"}])
    words = ["paper", "A2", "--seeds", "0:1", "--out", str(tmp_path)]
    assert main(words) == 0
    append_block(tmp_path, [{**mine, "suite": "fish", "scenario": "fish-tank-v1", "preset": "paper-c"}])
    assert main(words) == 2
    told = "which holds rows of suite fish, scenario fish-tank-v1, preset paper-c"
    assert f"out: expected a folder of paper A2 alone, e.g. an empty one, got '{tmp_path}', {told}" in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda each: each.name)
def test_a_run_leaves_rows_figure_and_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], experiment: TrackerExperiment
) -> None:
    repeat(experiment, tmp_path, range(1), "raster", 0)
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


@pytest.mark.parametrize("experiment", [b3.EXPERIMENT, a3.EXPERIMENT], ids=lambda each: each.name)
def test_the_table_says_what_was_fitted(experiment: TrackerExperiment, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [row(experiment, experiment.trackers[0], "frames", 1.0)]
    print_findings(experiment.title, findings(experiment, rows), range(1), experiment.fitted)
    assert ("fitted" in capsys.readouterr().out) == (experiment is b3.EXPERIMENT)


def test_trackers_beside_run_in_the_same_episodes_and_are_counted_without_a_verdict() -> None:
    experiment = replace(a3.EXPERIMENT, beside=("colour_pf", "hold_ground"))
    assert experiment.runs(range(2), "raster", 1).trackers == ("background_pf", "colour_pf", "hold_ground")
    rows = [row(experiment, "hold_ground", "kept", 1.0, seed, frame_out={"kind": "road"}) for seed in range(5)]
    found = findings(experiment, rows)[len(experiment.claims) :]
    assert [(each.claim.tracker, each.claim.metric) for each in found] == [
        (tracker, metric)
        for metric in ("road_kept_rate", "excursion_kept_rate")
        for tracker in ("colour_pf", "hold_ground")
    ]
    assert {each.claim.words for each in found} == {"not in the paper"}
    assert [(each.value, each.agrees) for each in found[:2]] == [("–", None), ("100.0 %", None)]
