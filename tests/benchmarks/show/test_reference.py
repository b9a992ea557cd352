"""The page of definitions can be made, and is complete."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pytest

from benchmarks.cli.main import main
from benchmarks.contract import rows as records
from benchmarks.contract import suite as registry
from benchmarks.contract.metric import NOT_STATED, Mean, Metric, Quantity
from benchmarks.contract.suite import suite
from benchmarks.run.jobs import heading_of
from benchmarks.run.selection import job_on
from benchmarks.show.definitions import (
    attribute_meanings,
    definitions_of,
    metric_definitions,
    metrics_of,
    preset_settings,
)
from benchmarks.show.reference import truth_fields
from benchmarks.statistics import summary
from benchmarks.statistics.summary import compare_ours, grouped, summarise
from scenarios import catalog
from tests.benchmarks.fake_rows import TRACKERS, rows_of
from trackers.belief.features import COMMANDS, FEATURES, features_of
from trackers.belief.kernel import BELIEF

OURS = [each.id for each in catalog.entries() if each.place.startswith("scenarios.")]
SUITES = ("fish", "follow", "frame-out", "harbour", "stereo")


def test_the_command_prints_all_definitions(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--reference"]) == 0
    page = capsys.readouterr().out
    metrics = {metric.name for name in SUITES for metric in metrics_of(suite(name))}
    fields = {field.name for name in OURS for field in truth_fields(catalog.scenario(name).truth)}
    presets = {preset for name in OURS for preset in catalog.scenario(name).presets}
    names = metrics | fields | presets | {*OURS}
    assert {name for name in names if not re.search(rf"\b{re.escape(name)}\b", page)} == set()
    # Each entry of the list at the top leads to a heading.
    headings = {
        re.sub(r"[^\w -]", "", words.lower()).replace(" ", "-") for words in re.findall(r"^## (.+)$", page, re.M)
    }
    listed = set(re.findall(r"\]\(#([^)]+)\)", page))
    assert len(listed) > len(SUITES)
    assert listed <= headings


@pytest.mark.parametrize("name", SUITES)
def test_every_metric_and_every_row_of_it_is_defined(name: str) -> None:
    """The docstring of a row has more than a few words, and defines nothing that no metric is made of.

    Rows of one kind may be conditioned in a metric, e.g. on the event; their range and source are the same.
    """
    scores = suite(name)
    quantities = [each for metric in metrics_of(scores) for each in metric.statistic.of]
    definitions = definitions_of(scores)
    assert {row for rows in definitions.values() for row in rows} == {each.name for each in quantities}
    for thing in definitions:
        assert len((thing.__doc__ or "").split()) >= 5, thing
    for each in metric_definitions(scores):
        assert all(each.values()), each
        assert NOT_STATED not in (each["conditions"], each["source"]), each
        assert f"`{each['rows'][0]}`" in each["formula"], each
    said = {(each.name, each.low, each.high, each.source) for each in quantities}
    assert len(said) == len({row for row, *_ in said})


def test_values_lie_in_the_range_that_is_said() -> None:
    scores = suite("frame-out")
    ranges = {each.name: (each.low, each.high) for metric in scores.metrics for each in metric.statistic.of}
    rows = [row for tracker in TRACKERS for seed in (1, 2) for row in rows_of(tracker, seed)]
    judged = [row for row in rows if row["metric"] in ranges and row["value"] is not None]
    assert len({row["metric"] for row in judged}) >= 5
    for row in judged:
        low, high = ranges[row["metric"]]
        assert low <= np.min(row["value"]) <= np.max(row["value"]) <= high, row


def test_a_users_metric_is_defined_by_its_docstring_and_what_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_SUITES", dict(registry.suites()))

    def jitter_px(truth: object, estimate: object) -> float:
        """Mean change of the error."""
        return 0.0

    mine = Quantity("jitter_px", 0, np.inf, "frames in view", "mine")
    registry.add_metric("frame-out", Metric("jitter_px", "jitter", "px", "lower", Mean(mine), value=jitter_px))
    registry.add_metric("frame-out", Metric("bare", "nothing said", "fraction", "lower"))
    told = {each["name"]: each for each in metric_definitions(suite("frame-out"))}
    assert (told["jitter_px"]["range"], told["jitter_px"]["source"]) == ("0 to infinity", "mine")
    assert told["jitter_px"]["defined_in"][0].endswith("jitter_px")
    assert (told["bare"]["range"], told["bare"]["source"]) == ("0 to 1", NOT_STATED)


def test_every_column_of_results_is_defined() -> None:
    rows = [row for tracker in ("sharp", "hold") for seed in (1, 2) for row in rows_of(tracker, seed)]
    follow = job_on(
        "follow", "road-town", "quick", 1, ("colour_pf",), controller="hold", link="prompt", modules=("a.py",)
    )
    text = records.__doc__ or ""
    for column in {*rows[0], *heading_of(follow, "colour_pf", "as-written")}:
        assert f"``{column}``" in text, column
    summarised = summary.__doc__ or ""
    for column in {key for make in (summarise, compare_ours) for entry in make(grouped(rows)) for key in entry}:
        assert f"``{column}``" in summarised, column


@pytest.mark.parametrize("name", OURS)
def test_every_setting_of_presets_and_field_of_truth_is_defined(name: str) -> None:
    scenario = catalog.scenario(name)
    for presets, settings in preset_settings(scenario.presets):
        assert set(presets) <= set(scenario.presets)
        for setting in settings:
            assert setting.meaning, setting.name
            held = [preset for mine in setting.presets.values() for preset in mine]
            assert len(held) == len(set(held)), setting.name
    assert all(field.meaning for field in truth_fields(scenario.truth))


def test_meanings_are_read_from_a_docstring() -> None:
    @dataclass
    class Camera:
        """A camera.

        Attributes:
            width_px, height_px: of the picture.
            rate_hz: frames a second; 0
                for none. gain: (3,) of each colour.

        Raises:
            ValueError: gain: never here.
        """

        width_px: int
        height_px: int
        rate_hz: float
        gain: float
        secret: int

    shared = "`width_px`, `height_px`: of the picture"
    expected = (shared, shared, "frames a second; 0 for none", "(3,) of each colour", "")
    assert tuple(attribute_meanings(Camera).values()) == expected


def test_there_are_as_many_meanings_as_features() -> None:
    """The vector is filled by index: a row of ones at the end shows that it is as long as its list of names."""
    out = np.full((1, len(FEATURES)), np.nan, np.float32)
    features_of(np.zeros(1, BELIEF), np.ones((1, COMMANDS)), out)
    assert np.isfinite(out).all()
    assert (out[0, -COMMANDS:] == 1.0).all()
    assert FEATURES[-COMMANDS:] == ("command_forward", "command_right", "command_climb", "command_yaw_rate")
