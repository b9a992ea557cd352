"""In-view detection, VOT-LT, OTB and the off-screen error, against loops over frames."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from benchmarks.judges import in_view
from benchmarks.judges.frame_out.episode_scores import precision_plot, score_episode
from benchmarks.judges.frame_out.metrics import localisation
from benchmarks.statistics import long_term
from tests.benchmarks.hand_made import estimate_at, pixels_of, truth_of

UNIT = st.floats(0, 1, allow_nan=False)


def test_present_and_absent_leave_out_what_is_between() -> None:
    truth = truth_of(["in", "partial", "partial", "occluded", "out"], visible=[1.0, 0.5, 0.05, 0.3, 0.0])
    present, absent = in_view.present_and_absent(truth.state, truth.visible_fraction)
    assert present.tolist() == [True, False, False, False, False]
    assert absent.tolist() == [False, False, True, False, True]


def test_rates_count_place_where_the_car_is_seen_and_not_where_it_is_away() -> None:
    present = np.array([True, True, True, False, False])
    says = np.array([True, True, False, True, False])
    on = np.array([True, False, True, False, False])
    never, failed = np.zeros(5, dtype=bool), np.arange(5) >= 4

    def rates(absent: np.ndarray, failed: np.ndarray) -> list[float]:
        return [score.value for score in in_view.oxuva_scores(present, absent, says, on, failed)]

    assert rates(~present, never) == pytest.approx([1 / 3, 1 / 2])
    assert rates(~present, failed) == pytest.approx([1 / 3, 0.0])
    assert np.isnan(rates(never, never)[1])


def test_without_a_probability_the_position_speaks() -> None:
    said = estimate_at(np.array([[50.0, 40.0], [150.0, 40.0], [np.nan, np.nan], [50.0, 40.0]]), [np.nan] * 3 + [0.2])
    assert said.confidence((100, 80)).tolist() == [1.0, 0.0, 0.0, 0.2]


@settings(deadline=None)
@given(st.integers(1, 25).flatmap(lambda n: st.tuples(*(arrays(float, n, elements=UNIT) for _ in range(3)))))
def test_precision_and_recall_are_those_of_a_loop(data: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    iou, confidence, drawn = data
    visible = drawn < 0.7
    precision, recall = long_term.precision_recall_curves(iou, confidence, visible)
    for t, threshold in enumerate(long_term.THRESHOLDS):
        predicted = [k for k in range(len(iou)) if confidence[k] >= threshold and confidence[k] > 0]
        overlaps = [iou[k] if visible[k] else 0.0 for k in predicted]
        assert precision[t] == pytest.approx(np.mean(overlaps) if predicted else 1.0)
        if visible.any():
            assert recall[t] == pytest.approx(sum(overlaps) / visible.sum())


def test_f_score() -> None:
    precision, recall = np.array([0.5, 0.8, 0.0]), np.array([0.5, 0.4, 0.0])
    np.testing.assert_allclose(long_term.f_score(precision, recall), [0.5, 0.64 / 1.2, 0.0])
    assert long_term.best_f_score(precision, recall) == 1


@settings(deadline=None)
@given(st.integers(1, 25).flatmap(lambda n: arrays(float, n, elements=UNIT)))
def test_area_under_the_success_curve_is_about_the_mean_overlap(iou: np.ndarray) -> None:
    """OTB's sum over 21 thresholds lies within one step of the integral, which is the mean IoU."""
    curve = localisation.success_curve(iou)
    assert curve.mean() == pytest.approx(iou.mean(), abs=1 / 20)
    assert (np.diff(curve) <= 0).all()


def test_centre_error_is_capped_and_never_missing() -> None:
    truth = truth_of(["in"] * 3)
    said = truth.position_px[:, 0] + np.array([[3.0, 4.0], [np.nan, np.nan], [1e6, 0.0]])
    worst = np.hypot(100, 80)
    assert localisation.centre_error_px(truth, estimate_at(said)) == pytest.approx([5.0, worst, worst])


def test_offscreen_error_is_in_metres_on_the_ground_and_unconditional() -> None:
    places = np.array([[60.0, -3.0]] * 4)
    truth = truth_of(["out"] * 4, places[:, None])
    said = pixels_of(places + np.array([[3.0, 4.0], [0.0, 0.0], [500.0, 0.0], [0.0, 0.0]]))
    said[3] = np.nan
    error, worst = localisation.ground_error_m(truth, estimate_at(said)), localisation.WORST_ERROR_M
    np.testing.assert_allclose(error, [5.0, 0.0, worst, worst], atol=1e-6)


@settings(max_examples=50)
@given(offsets=arrays(float, (12, 2), elements=st.floats(-60, 60, allow_nan=False)), silent=st.integers(0, 11))
def test_the_precision_plot_is_the_share_of_frames_within_each_distance(offsets: np.ndarray, silent: int) -> None:
    truth = truth_of(["in"] * 10 + ["out"] * 2)
    places = truth.position_px[:, 0] + offsets
    places[silent] = np.nan
    estimate = estimate_at(places)
    scores = {score.metric: score for score in score_episode(truth, estimate, None, closed_loop=False)}
    (plot,) = precision_plot(truth, estimate)
    for distance_px, share in enumerate(plot.value):
        near = sum(bool(np.linalg.norm(places[k] - truth.position_px[k, 0]) <= distance_px) for k in range(10))
        assert share == pytest.approx(near / 10)
    assert plot.value[20] == scores["precision_20_px"].value
    assert plot.weight == scores["precision_20_px"].weight == 10.0
    assert list(precision_plot(truth_of(["out"] * 3), estimate_at(places[:3]))) == []
