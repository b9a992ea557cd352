"""The report's curves against statsmodels, plain arithmetic and what must come out."""

from __future__ import annotations

import numpy as np
import pytest
from statsmodels.duration.survfunc import SurvfuncRight

from benchmarks.contract.rows import Row
from benchmarks.show import curves


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
    curve = curves.recovery(rows)
    assert curve is not None
    found = [row["value"] for row in rows if row["metric"] == "recovery_frames"]
    ends = [w["value"] if f is None else f for f, w in zip(found, rows[1::2], strict=True)]
    # statsmodels wants times > 0.
    theirs = SurvfuncRight(np.array(ends) + 1.0, np.array([f is not None for f in found]))
    ours = np.interp(theirs.surv_times - 1.0, curve.x, curve.y)
    within = theirs.surv_times - 1.0 <= curves.RECOVERY_FRAMES
    np.testing.assert_allclose(ours[within], 1.0 - theirs.surv_prob[within], atol=1e-12)
    assert (curve.low <= curve.y + 1e-12).all()
    assert (curve.y <= curve.high + 1e-12).all()


def test_offscreen_error_is_the_mean_over_frame_outs_that_last_so_long() -> None:
    series = [[1.0, 2.0, 3.0], [3.0, 4.0], [5.0, 6.0, None], [7.0, 8.0, 9.0]]
    rows: list[Row] = [
        {"metric": "offscreen_error_by_frame_m", "value": values, "weight": 1.0, "seed": seed}
        for seed, values in enumerate(series)
    ]
    curve = curves.offscreen_error(rows)
    assert curve is not None
    # Only two last until the third frame: fewer than are drawn.
    np.testing.assert_allclose(curve.y, [4.0, 5.0])
    np.testing.assert_allclose(curve.count, [4, 4])
    assert curves.offscreen_error(rows[:2]) is None


def test_calibration_of_an_honest_posterior_is_the_diagonal() -> None:
    rng = np.random.default_rng(0)
    rows: list[Row] = []
    for seed in range(40):
        levels = np.histogram(rng.random(200), 20, (0, 1))[0] / 200
        rows.append({"metric": "credible_level_histogram", "value": levels.tolist(), "weight": 200, "seed": seed})
    curve = curves.calibration(rows)
    assert curve is not None
    np.testing.assert_allclose(curve.y, curve.x, atol=0.03)
    inside = (curve.low <= curve.x + 1e-9) & (curve.x <= curve.high + 1e-9)
    assert inside.mean() > 0.7
    assert curve.y[0] == 0
    assert curve.y[-1] == pytest.approx(1)
