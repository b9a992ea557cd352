"""Scores of one tracker in one episode of the suite ``frame-out``, from truth and estimates made by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.contract.suite import suite
from benchmarks.judges.frame_out.episode_scores import NEES_CAP, score_episode
from benchmarks.judges.frame_out.metrics.series import EstimateSeries
from benchmarks.statistics.bootstrap import bootstrap_interval
from tests.benchmarks.hand_made import estimate_at, pixels_of, truth_of

STATES = ["in", *["out"] * 4, *["in"] * 22]


def said_of(levels: list[float], nees: list[float]) -> EstimateSeries:
    """Return estimates with these levels and NEES on the four frames outside, NaN = no posterior."""
    full_level, full_nees = np.full((2, len(STATES)), np.nan)
    full_level[1:5], full_nees[1:5] = levels, nees
    return replace(
        estimate_at(np.zeros((len(STATES), 2))),
        has_posterior=np.isfinite(full_level),
        credible_level=full_level,
        nees=full_nees,
    )


def values(estimate: EstimateSeries) -> dict[str, Any]:
    scores = score_episode(truth_of(STATES), estimate, None, closed_loop=False)
    return {score.metric: (score.value, score.weight) for score in scores if score.event is None}


def test_silence_where_it_is_hard_is_a_miss() -> None:
    honest = values(said_of([0.32, 0.96, 0.97, 1.0], [1.0, 9.0, 11.0, np.inf]))
    silent = values(said_of([0.32, np.nan, np.nan, np.nan], [1.0, np.nan, np.nan, np.nan]))
    assert honest["coverage_95"] == silent["coverage_95"] == (0.25, 4.0)
    assert honest["nees"] == (pytest.approx((1.0 + 9.0 + 11.0 + NEES_CAP) / 4), 4.0)
    assert silent["nees"] == (pytest.approx((1.0 + 3 * NEES_CAP) / 4), 4.0)
    histogram = np.array(silent["credible_level_histogram"][0])
    assert (histogram[6], histogram[-1]) == (0.25, 0.75)


def test_who_never_gives_a_posterior_has_no_coverage_and_who_did_in_view_has() -> None:
    never = said_of([np.nan] * 4, [np.nan] * 4)
    told = values(never)
    assert told["coverage_95"] == told["nees"] == (None, 0.0)
    assert "credible_level_histogram" not in told
    in_view_alone = replace(never, has_posterior=np.arange(len(STATES)) == 10)
    assert values(in_view_alone)["coverage_95"] == (0.0, 4.0)


def test_a_frame_out_without_a_return_counts_in_the_errors_outside_and_is_not_judged() -> None:
    states = [*["in"] * 10, *["out"] * 40]
    scores = score_episode(truth_of(states), estimate_at(np.zeros((50, 2))), None, closed_loop=False)
    of_frame_out = {score.metric for score in scores if score.event is not None}
    assert {"offscreen_error_30_m", "offscreen_error_by_frame_m"} <= of_frame_out
    assert "recovered" not in of_frame_out
    assert [score.weight for score in scores if score.metric == "offscreen_error_m"] == [40.0]


def errors_of(states: list[str], off_m: list[float]) -> dict[str, list[tuple[float, float]]]:
    """Return values and weights of the frame-outs' errors, of a tracker that is so far beside the car."""
    places = np.tile([60.0, -3.0], (len(states), 1))
    said = pixels_of(places + np.column_stack([np.zeros(len(states)), off_m]))
    scores = score_episode(truth_of(states, places[:, None]), estimate_at(said), None, closed_loop=False)
    found: dict[str, list[tuple[float, float]]] = {}
    for score in scores:
        if score.event is not None and (score.metric == "had" or score.metric.startswith("offscreen_error_")):
            assert isinstance(score.value, float | list)
            if isinstance(score.value, float):
                found.setdefault(score.metric, []).append((round(score.value, 6), score.weight))
    return found


def test_errors_of_who_had_the_car_at_the_exit_stand_apart() -> None:
    """The first frame-out finds the tracker on the car, the second one off it: it counts in the plain error alone."""
    states = ["in", *["out"] * 31, "in", *["out"] * 2, "in"]
    found = errors_of(states, [0.0, *[4.0] * 30, 8.0, 50.0, 50.0, 60.0, 0.0])
    assert found == {
        "had": [(1.0, 1.0), (0.0, 1.0)],
        "offscreen_error_m": [(round((30 * 4.0 + 8.0) / 31, 6), 31.0), (55.0, 2.0)],
        "offscreen_error_30_m": [(8.0, 1.0)],
        "offscreen_error_if_had_m": [(round((30 * 4.0 + 8.0) / 31, 6), 31.0)],
        "offscreen_error_30_if_had_m": [(8.0, 1.0)],
    }


def test_one_that_is_told_the_state_on_the_first_frame_outside_had_the_car() -> None:
    """Blind trackers and oracles; a car on the last frame before the exit is had too, two frames before not."""
    states = ["in", "partial", "out", "out", "in"]
    assert errors_of(states, [50.0, 50.0, 0.0, 9.0, 9.0])["had"] == [(1.0, 1.0)]
    assert errors_of(states, [50.0, 0.0, 50.0, 9.0, 9.0])["had"] == [(1.0, 1.0)]
    assert errors_of(states, [0.0, 50.0, 50.0, 9.0, 9.0])["had"] == [(0.0, 1.0)]


def test_mean_and_median_over_frame_outs_come_from_the_same_rows() -> None:
    """The mean weighs frames, the median counts each frame-out once."""
    metric = suite("frame-out").metric
    rows = [
        {"suite": "frame-out", "seed": k, "metric": "offscreen_error_m", "value": value, "weight": weight}
        for k, (value, weight) in enumerate([(1.0, 10.0), (2.0, 10.0), (30.0, 80.0)])
    ]
    mean, median = (metric(name).statistic.pooled(rows) for name in ("offscreen_error_m", "offscreen_error_median_m"))
    assert mean is not None
    assert median is not None
    assert (mean.mean, median.mean) == (24.3, 2.0)
    assert bootstrap_interval(median) == (1.0, 30.0)


LEVELS = st.lists(st.floats(0, 1), min_size=4, max_size=4)
NEES = st.lists(st.floats(0, 200), min_size=4, max_size=4)


@given(LEVELS, NEES, st.sets(st.integers(0, 3), max_size=3))
def test_no_silence_raises_coverage_or_lowers_nees(levels: list[float], nees: list[float], hushed: set[int]) -> None:
    spoken = values(said_of(levels, nees))
    quiet = [np.nan if k in hushed else level for k, level in enumerate(levels)]
    silent = values(said_of(quiet, [np.nan if k in hushed else each for k, each in enumerate(nees)]))
    for percent in (50, 90, 95):
        assert silent[f"coverage_{percent}"][0] <= spoken[f"coverage_{percent}"][0]
    assert silent["nees"][0] >= spoken["nees"][0] - 1e-9


@given(st.lists(st.booleans(), min_size=len(STATES), max_size=len(STATES)))
def test_every_answer_has_rows_of_the_same_frame_outs(right: list[bool]) -> None:
    """The return is 22 frames before the end: late enough to drop only the misses of it."""
    truth = truth_of(STATES)
    position_px = np.where(np.array(right)[:, None], truth.position_px[:, 0], 0.0)
    for frames, expected in ((len(STATES), 1), (len(STATES) - 2, 0)):
        shorter = truth_of(STATES[:frames])
        scores = score_episode(shorter, estimate_at(position_px[:frames]), None, closed_loop=False)
        rows = [score.metric for score in scores if score.event is not None]
        assert [rows.count(name) for name in ("recovered", "kept", "locked_on_wrong_car")] == [expected] * 3
        assert [rows.count(name) for name in ("recovery_frames", "watched_frames")] == [1, 1]
