"""The watched volume before a camera."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA, SURVEY, looking
from trackers.site.volume import place

AIM_M = np.array([3.0, -2.0, 0.0])
T_WORLD_CAMERA = looking(np.array([-80.0, 20.0, 20.0]), AIM_M)


def test_it_is_centred_where_the_axis_meets_the_ground_and_lies_along_the_view() -> None:
    placed = place(SURVEY, CAMERA, T_WORLD_CAMERA)
    np.testing.assert_allclose(placed.centre_m, [3.0, -2.0, 0.5], atol=1e-9)
    np.testing.assert_allclose(placed.axes @ placed.axes.T, np.eye(3), atol=1e-12)
    ahead = AIM_M[:2] - T_WORLD_CAMERA[:2, 3]
    np.testing.assert_allclose(placed.axes[0], [*ahead / np.linalg.norm(ahead), 0.0], atol=1e-12)
    # To the left of the view, as seen in the picture.
    assert placed.axes[1] @ T_WORLD_CAMERA[:3, 0] < 0


def test_the_nearest_and_the_farthest_corner_are_inside_and_what_is_beyond_is_not() -> None:
    placed = place(SURVEY, CAMERA, T_WORLD_CAMERA)
    corner_m = placed.centre_m + 0.5 * np.array([90.0, 33.0, 6.0]) @ placed.axes
    middle_m = placed.centre_m
    points_m = np.stack([middle_m + 0.999 * (corner_m - middle_m), middle_m + 1.001 * (corner_m - middle_m)])
    np.testing.assert_array_equal(placed.contains(points_m), [True, False])
    assert not placed.contains(np.full((1, 3), np.nan)).any()


def test_scattered_points_are_uniform_over_it() -> None:
    placed = place(SURVEY, CAMERA, T_WORLD_CAMERA)
    points_m = placed.scatter(np.random.default_rng(0), 20_000)
    assert placed.contains(points_m).all()
    shares = (points_m - placed.centre_m) @ placed.axes.T / [90.0, 33.0, 6.0] + 0.5
    counts, _ = np.histogramdd(shares, bins=4, range=[(0, 1)] * 3)
    expected = 20_000 / 4**3
    # Chi-square over 64 cells has mean 63 and standard deviation 11.
    assert ((counts - expected) ** 2 / expected).sum() < 63 + 5 * 11


@pytest.mark.parametrize(
    ("target_m", "message"), [((100.0, 0.0, 20.0), "meets the ground"), ((100.0, 0.0, 60.0), "meets the ground")]
)
def test_an_axis_that_does_not_meet_the_ground_is_refused(target_m: tuple[float, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        place(SURVEY, CAMERA, looking(np.array([0.0, 0.0, 20.0]), np.array(target_m)))


def test_a_camera_that_looks_straight_down_is_refused() -> None:
    T = np.eye(4)
    T[:3, :3], T[2, 3] = np.diag([1.0, -1.0, -1.0]), 20.0
    with pytest.raises(ValueError, match="straight down"):
        place(SURVEY, CAMERA, T)
