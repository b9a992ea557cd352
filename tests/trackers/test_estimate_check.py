from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from trackers.estimate_check import check_estimate
from trackers.types import Estimate

HERE = np.array([3.0, 4.0])
BOX = np.array([1.0, 2.0, 5.0, 6.0])
POINTS = np.zeros((3, 2))


@pytest.mark.parametrize(
    "estimate",
    [
        Estimate(HERE),
        Estimate(np.array([-1e5, 4])),
        Estimate(np.full(2, np.nan)),
        Estimate(np.full(2, np.nan), box_xyxy=np.full(4, np.nan), heading_rad=float("nan")),
        Estimate(HERE, BOX, 0.3, 0.0, POINTS, np.array([0.2, 0.3, 0.5]), np.eye(2)),
        Estimate(HERE, particles_px=np.array([[np.nan, 0.0], [1.0, 2.0]])),
        Estimate(HERE, covariance_px=np.zeros((2, 2))),
        Estimate(HERE, in_view_probability=1),
        Estimate(HERE, depth_m=2.5),
        Estimate(np.full(2, np.nan), depth_m=float("nan")),
    ],
)
def test_what_the_contract_allows_passes(estimate: Estimate) -> None:
    check_estimate(estimate)


@pytest.mark.parametrize(
    ("estimate", "message"),
    [
        (None, "update: expected an Estimate, got NoneType"),
        ((3.0, 4.0), "update: expected an Estimate, got tuple"),
        (Estimate(np.zeros(3)), r"position_px: expected the shape \(2,\), got \(3,\)"),
        (Estimate(np.array([np.nan, 1.0])), r"position_px: expected finite numbers, got \[nan, 1.0\]"),
        (Estimate(np.array([np.inf, 1.0])), "position_px: expected finite numbers"),
        (Estimate("here"), r"position_px: expected numbers of shape \(2,\), got 'here'"),  # type: ignore[arg-type]
        (Estimate(HERE, np.zeros((2, 2))), r"box_xyxy: expected the shape \(4,\), got \(2, 2\)"),
        (Estimate(HERE, np.full(4, np.nan)), "box_xyxy: expected finite numbers"),
        (Estimate(HERE, np.array([5.0, 2.0, 1.0, 6.0])), "box_xyxy: expected x_min <= x_max"),
        (Estimate(HERE, depth_m=0.0), r"depth_m: expected a finite number > 0, got 0.0"),
        (Estimate(HERE, depth_m=float("inf")), r"depth_m: expected a finite number > 0, got inf"),
        (Estimate(HERE, depth_m=float("nan")), r"depth_m: expected a finite number > 0, got nan"),
        (Estimate(HERE, heading_rad=float("nan")), "heading_rad: expected finite numbers"),
        (Estimate(np.full(2, np.nan), heading_rad=np.full(1, np.nan)), "heading_rad: expected the shape"),
        (Estimate(np.full(2, np.nan), covariance_px=np.full(2, np.nan)), "covariance_px: expected the shape"),
        (Estimate(HERE, centre_line_px=np.zeros((3, 3))), "centre_line_px: expected the shape"),
        (Estimate(HERE, in_view_probability=1.2), "in_view_probability: expected a number from 0 to 1, got 1.2"),
        (Estimate(HERE, in_view_probability=float("nan")), "in_view_probability: expected a number from 0 to 1"),
        (Estimate(HERE, particles_px=np.zeros((0, 2))), "particles_px: expected at least one particle, got none"),
        (Estimate(HERE, particles_px=np.zeros((3, 3))), r"particles_px: expected the shape \(3, 2\), got \(3, 3\)"),
        (
            Estimate(HERE, particles_px=POINTS, weights=np.ones(2) / 2),
            r"weights: expected the shape \(3,\), got \(2,\)",
        ),
        (Estimate(HERE, particles_px=POINTS, weights=np.ones(3)), "weights: expected .* the sum 1, got .* the sum 3"),
        (Estimate(HERE, particles_px=POINTS, weights=np.array([1.5, -0.5, 0.0])), "weights: .* got the least -0.5"),
        (Estimate(HERE, particles_px=POINTS, weights=np.full(3, np.nan)), "weights: expected non-negative numbers"),
        (Estimate(HERE, weights=np.ones(1)), "weights: expected None without particles_px"),
        (
            Estimate(HERE, covariance_px=np.array([[1.0, 2.0], [2.0, 1.0]])),
            "covariance_px: expected a symmetric matrix",
        ),
        (
            Estimate(HERE, covariance_px=np.array([[1.0, 0.5], [0.0, 1.0]])),
            "covariance_px: expected a symmetric matrix",
        ),
        (Estimate(HERE, covariance_px=np.full((2, 2), np.nan)), "covariance_px: expected finite numbers"),
    ],
)
def test_what_breaks_it_is_named(estimate: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check_estimate(estimate)
