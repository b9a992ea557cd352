"""Scores of gaps: errors, coverage, successors; by recording and by block of time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.judges.fish.gap_protocol import BLOCK_FRAMES, GAP_FRAMES, BridgedGap, Gap, GapTask, Tracks
from benchmarks.judges.fish.gap_scores import gap_scores, successors
from benchmarks.run.guards import Guard, GuardedGapMethod
from benchmarks.show.suites.fish import charts
from tests.benchmarks.judges.fish.gap_methods import Fails, GivesUp, Knows, swimming
from trackers.gaps import Bridge

TRUE_PX = swimming()
TRACKS = Tracks(TRUE_PX + 0.5, 1 / 30, true_px=TRUE_PX)
TASK = GapTask(TRACKS, 50, 500.0, sees_mates=True)


def scored(task: GapTask, method: Knows) -> dict[str, tuple[float, float]]:
    return {each.metric: (each.value, each.weight) for each in gap_scores(task.tracks, task.bridged(lambda: method))}  # type: ignore[misc]


def test_errors_are_those_of_the_true_place() -> None:
    method = Knows(TRUE_PX, off_px=3.0, deviation_px=2.0)
    scores = scored(TASK, method)
    for count in GAP_FRAMES:
        first = range(100, 700 - count + 1, 50)
        assert scores[f"gap_error_{count}_px"] == (pytest.approx(3.0), 3 * len(first))
        assert scores[f"gap_interpolation_error_{count}_px"][0] == pytest.approx(3.0)
        # The region reaches sqrt(-2 log 0.05) = 2.45 deviations far.
        assert scores[f"gap_coverage_{count}"][0] == 1.0
        assert scores[f"successor_rate_{count}"] == (1.0, 3 * len(first))
    assert scores["gap_error_by_frame_px"][0] == pytest.approx([3.0] * 200)
    assert scored(TASK, Knows(TRUE_PX, off_px=5.0, deviation_px=2.0))["gap_coverage_50"][0] == 0.0
    assert set(method.mates) == {2}


def test_where_truth_is_known_most_of_the_past_must_be_measured_and_nothing_of_the_gap() -> None:
    measured = TRUE_PX.copy()
    measured[260:300] = np.nan
    known, unknown = (
        GapTask(Tracks(measured, 1 / 30, true_px=true_px), 10, 500.0, sees_mates=False) for true_px in (TRUE_PX, None)
    )
    first = {gap.first for gap in known.open_gaps if gap.count == 50}
    # Ten of a hundred frames may be missing, but not the last one.
    assert first == {*range(100, 261, 10), *range(390, 651, 10)}
    first = {gap.first for gap in unknown.open_gaps if gap.count == 50}
    assert first == {*range(100, 211, 10), *range(400, 651, 10)}
    closed = {gap.first for gap in known.closed_gaps if gap.count == 50}
    assert closed == {*range(100, 121, 10), *range(250, 261, 10), *range(390, 551, 10)}


def test_a_gap_that_a_method_gives_up_on_counts_as_failed_and_the_others_as_they_are() -> None:
    bridged = TASK.bridged(lambda: GivesUp(TRUE_PX, {7}))
    failed = [each for each in bridged.extrapolated if each.error_px[-1] > 0.0]
    assert [each.gap for each in failed] == [TASK.open_gaps[7]]
    assert failed[0].error_px == pytest.approx(np.full(failed[0].gap.count, 500.0))
    assert len(bridged.extrapolated) == len(TASK.open_gaps)
    count = failed[0].gap.count
    scores = {each.metric: each.value for each in gap_scores(TRACKS, bridged)}
    assert scores[f"successor_rate_{count}"] == pytest.approx(1 - 1 / sum(g.count == count for g in TASK.open_gaps))
    # None for the first: it does not extrapolate.
    assert TASK.bridged(lambda: GivesUp(TRUE_PX, {0})).extrapolated == []


def test_a_method_without_covariance_or_far_end_has_no_such_scores() -> None:
    scores = scored(TASK, Knows(TRUE_PX, deviation_px=None, both_ends=False))
    assert not [name for name in scores if "coverage" in name or "interpolation" in name]
    assert scores["successor_rate_200"][0] == 1.0


def test_a_method_that_fails_has_the_worst_error() -> None:
    guard = Guard(60.0)
    bridged = TASK.bridged(lambda: GuardedGapMethod(Fails(), guard, 7))
    scores = {each.metric: each.value for each in gap_scores(TRACKS, bridged)}
    assert scores["gap_error_50_px"] == 500.0
    assert scores["gap_interpolation_error_200_px"] == 500.0
    assert (guard.failed_at_frame, guard.reason) == (7, "RuntimeError: it fails")
    assert scores["successor_rate_50"] == 0.0


def test_blocks_hold_all_gaps_once() -> None:
    bridged = TASK.bridged(lambda: Knows(TRUE_PX))
    blocks = [bridged.of_block(block) for block in range(2)]
    assert [gap for each in blocks for gap in each.extrapolated] == bridged.extrapolated
    assert all(each.gap.first < BLOCK_FRAMES for each in blocks[0].interpolated)


def lost(target: int, place: tuple[float, float], deviation_px: float | None = None) -> BridgedGap:
    covariance = None if deviation_px is None else deviation_px**2 * np.eye(2)[None]
    return BridgedGap(Gap(target, 0, 1), np.zeros(1), None, Bridge(np.array([place]), covariance))


def test_successors_are_chosen_together() -> None:
    """Fish at 0, 10 and 20: alone, the second would choose the place of the first."""
    tracks = Tracks(np.array([[[0.0, 0], [10, 0], [20, 0]]]), 1 / 30)
    assert successors(tracks, [lost(0, (1, 0)), lost(1, (4, 0)), lost(2, (19, 0))]) == [True] * 3
    assert successors(tracks, [lost(0, (9, 0)), lost(1, (1, 0))]) == [False] * 2
    # One that is sure of its place goes before one that is not.
    sure, unsure = lost(0, (3, 0), 1.0), lost(1, (2, 0), 50.0)
    assert successors(tracks, [sure, unsure]) == [True, True]


def test_one_that_predicts_the_same_for_all_is_right_by_chance() -> None:
    """The order of fish is that of the truth, and must tell nothing."""
    tracks = Tracks(TRUE_PX, 1 / 30)
    same = [[replace(lost(k, (5, 0)), gap=Gap(k, first, 1)) for k in range(3)] for first in range(600)]
    right = np.mean([each for group in same for each in successors(tracks, group)])
    assert right == pytest.approx(1 / 3, abs=0.04)


def test_the_error_is_drawn_over_the_gap() -> None:
    bridged = TASK.bridged(lambda: Knows(TRUE_PX, off_px=3.0))
    heading = {"suite": "fish", "role": "ours", "seed": 0, "repeat": 0, "event": None}
    rows = [
        {**heading, "metric": each.metric, "value": each.value, "weight": each.weight}
        for each in gap_scores(TRACKS, bridged)
    ]
    chart, links = charts({"knows": rows})
    assert not links.values
    assert chart.title == "How far off is a lost fish?"
    curve = chart.curves["knows"]
    assert curve.x.tolist() == list(range(1, GAP_FRAMES[-1] + 1))
    assert curve.mean == pytest.approx(np.full(len(curve.x), 3.0))
