"""The numbers of the report's charts against statsmodels and plain arithmetic."""

from __future__ import annotations

import numpy as np
import pytest
from statsmodels.duration.survfunc import SurvfuncRight

from benchmarks.contract.rows import Row
from benchmarks.judges.frame_out.metrics.localisation import CENTRE_ERRORS_PX, THRESHOLDS
from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.show import charts
from benchmarks.show.suites import follow, frame_out


def test_recovery_curve_is_kaplan_meier() -> None:
    """Against statsmodels, with cars watched for different times."""
    rng = np.random.default_rng(3)
    rows: list[Row] = []
    for seed in range(12):
        for _ in range(3):
            watched = float(rng.integers(5, 40))
            at = float(rng.integers(0, 60))
            rows.append({"metric": "recovery_frames", "value": at if at < watched else None, "seed": seed})
            rows.append({"metric": "watched_frames", "value": watched, "seed": seed})
    curve = charts.recovery(rows)
    assert curve is not None
    found = [row["value"] for row in rows if row["metric"] == "recovery_frames"]
    ends = [w["value"] if f is None else f for f, w in zip(found, rows[1::2], strict=True)]
    # statsmodels wants times > 0.
    theirs = SurvfuncRight(np.array(ends) + 1.0, np.array([f is not None for f in found]))
    ours = np.interp(theirs.surv_times - 1.0, curve.x, curve.mean)
    within = theirs.surv_times - 1.0 <= charts.RECOVERY_FRAMES
    np.testing.assert_allclose(ours[within], 1.0 - theirs.surv_prob[within], atol=1e-12)
    assert (curve.low <= curve.mean + 1e-12).all()
    assert (curve.mean <= curve.high + 1e-12).all()


def test_offscreen_error_is_the_mean_over_frame_outs_that_last_so_long() -> None:
    series = [[1.0, 2.0, 3.0], [3.0, 4.0], [5.0, 6.0, None], [7.0, 8.0, 9.0]]
    rows: list[Row] = [
        {"metric": "offscreen_error_by_frame_m", "value": values, "weight": 1.0, "seed": seed}
        for seed, values in enumerate(series)
    ]
    curve = charts.series_mean(rows, "offscreen_error_by_frame_m", fewest=charts.FEWEST)
    assert curve is not None
    # Only two last until the third frame: fewer than are drawn.
    np.testing.assert_allclose(curve.mean, [4.0, 5.0])
    np.testing.assert_allclose(curve.x, [0.0, 1.0])
    assert charts.series_mean(rows[:2], "offscreen_error_by_frame_m", fewest=charts.FEWEST) is None


def test_the_time_seen_has_a_line_for_each_tracker_and_a_dot_for_each_controller() -> None:
    seen = {("centre", "one"): (0.5, 0.7), ("centre", "two"): (0.2, 0.2), ("hold", "two"): (0.1, 0.3)}
    drawn = {
        f"{controller}+{tracker}": [
            {"controller": controller, "tracker": tracker, "metric": "time_seen", "value": share, "weight": 1.0}
            | {"seed": seed, "event": None}
            for seed, share in enumerate(shares)
        ]
        for (controller, tracker), shares in seen.items()
    }
    (chart,) = follow.charts(drawn)
    means = {tracker: {name: value.mean for name, value in values.items()} for tracker, values in chart.values.items()}
    assert means == {
        "one": {"centre": pytest.approx(0.6)},
        "two": {"centre": pytest.approx(0.2), "hold": pytest.approx(0.2)},
    }
    assert (chart.values["two"]["hold"].low, chart.values["two"]["hold"].high) == (0.1, 0.3)
    (nothing,) = follow.charts({})
    assert not nothing.values


def test_labels_have_the_score_and_its_interval_the_best_first_and_references_last() -> None:
    values = {"worse": [0.2, 0.2], "oracle": [0.9], "better": [0.25, 0.75], "single": [0.4], "none": []}
    row = {"metric": "success_auc", "weight": 1.0}
    drawn = {
        name: [
            row | {"value": value, "seed": seed, "role": "oracle" if name == "oracle" else "baseline"}
            for seed, value in enumerate(some)
        ]
        for name, some in values.items()
    }
    assert list(charts.scored(drawn, FRAME_OUT.metric("success_auc")).items()) == [
        ("better", "better 50.0 (25.0–75.0)"),
        ("single", "single 40.0"),
        ("worse", "worse 20.0 (20.0–20.0)"),
        ("oracle", "oracle 90.0"),
    ]


def test_success_and_precision_curves_stand_over_their_thresholds() -> None:
    rng = np.random.default_rng(4)
    rows: list[Row] = [
        {"metric": name, "value": rng.random(length).tolist(), "weight": 3.0, "seed": seed, "event": None}
        | {"role": "baseline"}
        for seed in range(4)
        for name, length in (("success_curve", 21), ("precision_plot", 51))
    ]
    for row in rows[::2]:
        rows.append({**row, "metric": "success_auc", "value": float(np.mean(row["value"]))})
    by_title = {chart.title: chart for chart in frame_out.charts({"one": rows})}
    success, near = by_title["How well do the boxes fit?"], by_title["How near are the centres?"]
    assert success.curves is not None
    np.testing.assert_allclose(success.curves["one"].x, THRESHOLDS)
    np.testing.assert_allclose(success.curves["one"].mean, np.mean([row["value"] for row in rows[:8:2]], axis=0))
    assert near.curves is not None
    np.testing.assert_allclose(near.curves["one"].x, CENTRE_ERRORS_PX)
    assert near.mark == (20.0, "20 px")
    # The area is the mean of the curve.
    area = f"{100 * success.curves['one'].mean.mean():.1f}"
    assert success.labels["one"].startswith(f"one {area} (")
    # Rows of an earlier version lack the plot in one episode: it is not drawn of the others alone.
    older = [row for row in rows if (row["metric"], row["seed"]) != ("precision_plot", 0)]
    assert frame_out.precision(older) is None


def test_the_length_of_the_target_is_that_of_the_scene() -> None:
    rows: list[Row] = [
        {"metric": name, "value": error_m / length_m, "weight": frames, "seed": seed}
        for seed, (error_m, frames) in enumerate([(12.0, 30.0), (3.0, 90.0)])
        for name, length_m in (("offscreen_error_m", 1.0), ("offscreen_error_car_lengths", 0.4))
    ]
    assert frame_out.target_length({"silent": [], "one": rows}) == (pytest.approx(0.4), "one length of the target")
    assert frame_out.target_length({"silent": []}) is None
