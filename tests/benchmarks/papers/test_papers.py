"""The papers' experiments: they name things that exist, judge claims rightly, and leave rows, figure and page."""

from __future__ import annotations

import html
import json
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.cli import paper
from benchmarks.cli.main import main
from benchmarks.contract.suite import suite
from benchmarks.papers.experiment import NAMES, Claim, Finding, PaperExperiment, TextTable, experiment_named, findings
from benchmarks.papers.repeat import print_table, repeat, table_of_findings
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.run.result_folder import append_block
from benchmarks.run.selection import trackers_of
from scenarios import catalog
from scenarios.road_town.presets import RoadTown
from tests.benchmarks.papers.conftest import row
from trackers import registry
from trackers.controllers.catalogue import controllers

A2, A3, B1, B2, B3, C, D = ALL = tuple(map(experiment_named, NAMES))
EXPERIMENTS = (A2, A3)


@pytest.mark.parametrize("experiment", [*EXPERIMENTS, B3], ids=lambda each: each.name)
def test_an_experiment_names_what_exists(experiment: TrackerExperiment) -> None:
    preset = catalog.scenario(experiment.scenario).presets[experiment.preset]
    for name in experiment.presets:
        assert catalog.scenario(experiment.scenario).presets[name].frame_count == preset.frame_count
    assert experiment.scenario in catalog.names()
    assert preset.closed_loop == (experiment.controller is not None)
    assert experiment.controller is None or experiment.controller in controllers("helicopter")
    assert max(experiment.frames, default=0) < preset.frame_count
    for tracker in experiment.trackers:
        assert trackers_of()[tracker].role == "as-written"
    judged = suite(experiment.suite)
    assert set(experiment.beside) <= set(trackers_of(judged.tracked_by(judged.scene(experiment.scenario))))
    for claim in experiment.claims:
        assert claim.tracker in experiment.trackers
        metric = suite(experiment.suite).metric(claim.metric)
        assert claim.bound == "reported" or (metric.unit == "fraction" and 0 < claim.level < 1)


@pytest.mark.parametrize("experiment", [A2, A3, B3, C, D], ids=lambda each: each.name)
def test_methods_are_set_as_they_were_written_whatever_tuning_found(
    experiment: TrackerExperiment, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "tuned_values", lambda name, module: {"no_such_parameter": 99.0})
    as_written = [name for name in experiment.trackers if registry.entry(name).role == "as-written"]
    assert as_written
    for name in as_written:
        assert registry.entry(name).parameters() == registry.entry(name).tracker.Parameters()


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
    rows = [row(A3, "background_pf", "frames", 1.0)]
    for seed in range(100 if mean is not None else 0):
        kept = float(seed < round(100 * mean))
        rows.append(row(A3, "background_pf", "kept", kept, seed, frame_out={"kind": kind}))
        rows.append(row(A3, "colour_pf", "kept", 1.0 - kept, seed, frame_out={"kind": kind}))
    found = {each.claim.metric: each for each in findings(replace(A3, beside=()), rows)}
    assert found[metric].agrees == agrees
    assert found[metric].mean == (mean if mean is None else pytest.approx(mean))
    # The other claim has no value, which is shown and is no agreement.
    (other,) = found.keys() - {metric}
    assert (found[other].value, found[other].episodes, found[other].agrees) == ("–", 0, False)


def test_rows_of_something_else_in_the_folder_count_for_nothing(tmp_path: Path) -> None:
    mine = row(A2, "colour_pf", "frames", 80.0)
    for more in ({"suite": "paper"}, {"scenario": "x-v1"}, {"preset": "standard"}, {"controller": None}, {}):
        append_block(tmp_path, [{**mine, **more}])
    append_block(tmp_path, [{**mine, "renderer": "pybullet"}])
    for renderer in ("raster", "pybullet"):
        assert [(each["renderer"], each["value"]) for each in A2.rows_in(tmp_path, renderer)] == [(renderer, 80.0)]


@pytest.mark.parametrize("experiment", ALL, ids=lambda each: each.name)
def test_the_command_repeats_it_with_its_own_seeds(
    experiment: PaperExperiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr(paper, "repeat", lambda *given: asked.append(given))
    assert main(["paper", experiment.name, "--out", str(tmp_path), "--workers", "1"]) == 0
    count = 10 if experiment in (B3, D) else 50
    assert asked == [(experiment, tmp_path, range(10_000, 10_000 + count), "raster", 1)]


def test_the_command_takes_no_folder_of_something_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(paper, "repeat", lambda *given: None)
    mine = row(A2, "colour_pf", "frames", 80.0)
    append_block(tmp_path, [{**mine, "renderer": "pybullet"}])
    words = ["paper", "A2", "--seeds", "0:1", "--out", str(tmp_path)]
    assert main(words) == 0
    append_block(tmp_path, [{**mine, "suite": "fish", "scenario": "fish-tank-v1", "preset": "paper-c"}])
    assert main(words) == 2
    told = "which holds rows of suite fish, scenario fish-tank-v1, preset paper-c"
    assert f"out: expected a folder of paper A2 alone, e.g. an empty one, got '{tmp_path}', {told}" in (
        capsys.readouterr().err
    )


@pytest.mark.heavy
@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda each: each.name)
def test_a_run_leaves_rows_figures_and_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], experiment: TrackerExperiment
) -> None:
    experiment = replace(experiment, beside=("hold",))
    found = repeat(experiment, tmp_path, range(1), "raster", 0)
    printed = capsys.readouterr().out
    assert "paper.html" in printed
    rows = [json.loads(line) for line in (tmp_path / "records.jsonl").read_text().splitlines()]
    frames = {row["tracker"]: row["value"] for row in rows if row["metric"] == "frames"}
    preset = catalog.scenario(experiment.scenario).presets[experiment.preset]
    assert frames == dict.fromkeys((*experiment.trackers, "hold"), preset.frame_count)
    assert {(row["preset"], row["seed"]) for row in rows} == {(experiment.preset, 0)}
    # Of one episode the intervals are NaN.
    assert repr(found) == repr(findings(experiment, experiment.rows_in(tmp_path)))
    page = (tmp_path / "paper.html").read_text()
    for each in found:
        assert each.claim.words in page
        assert f'<span class="value">{each.value}</span>' in page
        assert each.value in printed
    assert f"Fitted: {html.escape(experiment.fitted).replace('&#x27;', '&#39;')}" in page
    picture = cv2.imread(str(tmp_path / "pictures" / f"paper-{experiment.name.lower()}-raster.jpg"))
    height, width = picture.shape[:2]
    # As many pictures beside each other as the paper shows, as many rows as methods; 4:3 each, and a strip of words.
    shape = (width / len(experiment.frames)) / (height / len(experiment.trackers))
    assert 1.2 < shape < 4 / 3
    cell_px = height // len(experiment.trackers), width // len(experiment.frames)
    cells = [
        picture[i * cell_px[0] : (i + 1) * cell_px[0], j * cell_px[1] : (j + 1) * cell_px[1]]
        for i in range(len(experiment.trackers))
        for j in range(len(experiment.frames))
    ]
    # Each shows something, and each something else.
    assert min(cell.std() for cell in cells) > 15
    assert min(np.abs(one.astype(float) - other).mean() for one, other in pairwise(cells)) > 5


@pytest.mark.parametrize("experiment", ALL, ids=lambda each: each.name)
def test_the_table_says_what_was_fitted(experiment: PaperExperiment, capsys: pytest.CaptureFixture[str]) -> None:
    print_table(table_of_findings(experiment, findings(experiment, []), range(1), "raster"))
    printed = "".join(capsys.readouterr().out.split())
    assert ("fitted:" in printed) == bool(experiment.fitted)
    assert "".join(experiment.fitted.split()) in printed


def test_names_and_numbers_are_whole_in_80_columns(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    counted = "kept in the picture to the end"
    claim = Claim("kept_rate", counted, "it stays", "at least", 0.9, tracker="stereo_wb_shutter_gain")
    found = [Finding(claim, 0.94, 0.8, 0.99, "fraction", 50)]
    print_table(table_of_findings(replace(A2, title="A2", fitted=""), found, range(50), "raster"))
    printed = capsys.readouterr().out
    assert printed.count(" stereo_wb_shutter_gain ") == printed.count(" 94.0 % ") == 1
    # The last column: a table that is too wide loses what is on its right.
    assert len(re.findall(r" yes\b", printed)) == 1
    assert "renderer raster" in printed


def test_long_heads_cost_no_digits(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    heads = ("illuminance on the sheet, lx", "P_l", "P_c if register values counted as they are")
    print_table(TextTable("", "", heads, (("609", "0.25", "0.75"),)))
    assert {"609", "0.25", "0.75", "P_l", "register"} <= {*capsys.readouterr().out.split()}


@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda each: each.name)
def test_what_is_said_to_be_fitted_is_what_the_preset_holds(experiment: TrackerExperiment) -> None:
    preset = catalog.scenario(experiment.scenario).presets[experiment.preset]
    assert isinstance(preset, RoadTown)
    gusts, (low, high) = preset.frame_outs, preset.altitude_m
    words = [
        f"through {preset.field_of_view_deg:g}° from {low:g} to {high:g} m",
        f"tilts it by {preset.attitude_noise_deg:g}°",
        "{} to {} frames".format(*gusts.frames),
    ]
    words += [f"from frame {gusts.start_frame:d} on"] if gusts.start_frame else [f"{preset.turn_preference:g}"]
    assert [each for each in words if each not in experiment.fitted] == []


def test_trackers_beside_run_in_the_same_episodes_and_are_counted_without_a_verdict() -> None:
    experiment = replace(A3, beside=("colour_pf", "hold_ground"))
    assert list(experiment.runs(range(2), "raster", 1).trackers) == ["background_pf", "colour_pf", "hold_ground"]
    rows = [row(experiment, "hold_ground", "kept", 1.0, seed, frame_out={"kind": "road"}) for seed in range(5)]
    found = findings(experiment, rows)[len(experiment.claims) :]
    assert [(each.claim.tracker, each.claim.metric) for each in found] == [
        (tracker, metric)
        for metric in ("road_kept_rate", "excursion_kept_rate")
        for tracker in ("colour_pf", "hold_ground")
    ]
    assert {each.claim.words for each in found} == {"not in the paper"}
    assert [(each.value, each.agrees) for each in found[:2]] == [("–", None), ("100.0 %", None)]


def test_a_variant_runs_beside_and_its_rows_are_counted_apart(tmp_path: Path) -> None:
    experiment = replace(A3, beside=("colour_pf",), variants={"standard": "elsewhere"})
    assert {each.preset for each in experiment.runs(range(2), "raster", 1).episodes} == {"paper-a3", "standard"}
    for preset, kept in (("paper-a3", 1), ("standard", 4)):
        for tracker in ("background_pf", "colour_pf"):
            for seed in range(5):
                made = {"tracker": tracker, "seed": seed, "preset": preset}
                kept_row = row(experiment, metric="kept", value=float(seed < kept), frame_out={"kind": "road"}, **made)
                append_block(tmp_path, [kept_row, row(experiment, metric="frames", value=160.0, **made)])
    assert len(experiment.rows_in(tmp_path)) == 2 * 2 * 5 * 2
    found = {
        (each.claim.preset, each.claim.tracker): (each.mean, each.claim.counted)
        for each in findings(experiment, experiment.rows_in(tmp_path))
        if each.claim.metric == "road_kept_rate"
    }
    counted = next(claim.counted for claim in experiment.claims if claim.metric == "road_kept_rate")
    assert found == {
        ("", "background_pf"): (pytest.approx(0.2), counted),
        ("", "colour_pf"): (pytest.approx(0.2), counted),
        ("standard", "background_pf"): (pytest.approx(0.8), f"elsewhere: {counted}"),
        ("standard", "colour_pf"): (pytest.approx(0.8), f"elsewhere: {counted}"),
    }
