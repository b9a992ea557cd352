"""The motion of a picture is that of the warp that made it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from trackers.kernels.picture_motion import background_motion, moved_points, picture_motion

_SIZE = (320, 240)
_NOWHERE = np.array([-20.0, -20.0, -10.0, -10.0])


def grey(seed: int) -> NDArray[np.uint8]:
    """Return a smooth random grey picture."""
    coarse = np.random.default_rng(seed).integers(0, 256, (22, 28), dtype=np.uint8)
    return cv2.resize(cv2.resize(coarse, (80, 60), interpolation=cv2.INTER_CUBIC), _SIZE)


def shifted(picture: NDArray[np.uint8], right: float, down: float) -> NDArray[np.uint8]:
    return cv2.warpAffine(
        picture, np.array([[1.0, 0.0, right], [0.0, 1.0, down]]), picture.shape[::-1], borderMode=cv2.BORDER_REFLECT
    )


@given(st.floats(-0.05, 0.05), st.floats(0.95, 1.05), st.floats(-8, 8), st.floats(-8, 8))
@settings(max_examples=15, deadline=None)
def test_the_motion_of_a_picture_is_found(turn: float, scale: float, right: float, down: float) -> None:
    before = grey(4)
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    M = np.array([[c, -s, right], [s, c, down], [0.0, 0.0, 1.0]])
    now = cv2.warpPerspective(before, M, (320, 240), borderMode=cv2.BORDER_REFLECT)
    corners = np.array([[40.0, 40, 1], [280, 40, 1], [280, 200, 1], [40, 200, 1]])
    found = corners @ picture_motion(before, now).T
    # In OpenCV's warp, whole numbers are centres of pixels.
    expected = (corners - [0.5, 0.5, 0]) @ M.T
    np.testing.assert_allclose(found[:, :2] / found[:, 2:], expected[:, :2] + 0.5, atol=0.5)


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (5, 3), (120, 160)])
def test_pictures_without_corners_do_not_move(size: tuple[int, int]) -> None:
    blank = np.full(size, 90, np.uint8)
    np.testing.assert_array_equal(picture_motion(blank, blank), np.eye(3))


def test_the_target_s_own_motion_is_left_out() -> None:
    """It fills half of the picture and moves to the right; the background moves down."""
    before, now = grey(1), shifted(grey(1), 0.0, 6.0)
    before[40:200, 60:240] = grey(2)[:160, :180]
    now[40:200, 65:245] = grey(2)[:160, :180]
    H = background_motion(before, now, np.array([50.0, 30.0, 250.0, 210.0]))
    np.testing.assert_allclose(moved_points(H, np.array([[160.0, 120.0]])), [[160.0, 126.0]], atol=0.7)


def test_a_motion_with_which_few_agree_is_none() -> None:
    before, now = grey(3), grey(5)
    before[:, :70] = grey(6)[:, :70]
    now[:, :70] = shifted(grey(6), 0.0, 5.0)[:, :70]
    assert not np.array_equal(picture_motion(before, now), np.eye(3))
    np.testing.assert_array_equal(background_motion(before, now, _NOWHERE), np.eye(3))


def test_a_jerk_beyond_the_reach_of_following_is_found_by_looks() -> None:
    before = cv2.resize(np.random.default_rng(7).integers(0, 256, (60, 80), dtype=np.uint8), _SIZE)
    turn = cv2.getRotationMatrix2D((160.0, 120.0), 20.0, 1.0) + np.array([[0.0, 0.0, 60.0], [0.0, 0.0, 45.0]])
    now = cv2.warpAffine(before, turn, _SIZE)
    expected = turn @ [140.0, 100.0, 1.0]
    found = moved_points(background_motion(before, now, _NOWHERE), np.array([[140.5, 100.5]]))[0]
    assert np.linalg.norm(found - expected - 0.5) < 1.0
    assert np.linalg.norm(moved_points(picture_motion(before, now), np.array([[140.5, 100.5]]))[0] - expected) > 5.0


def test_points_beyond_the_horizon_are_moved_far_and_stay_finite() -> None:
    H = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -0.02, 1.0]])
    np.testing.assert_allclose(
        moved_points(H, np.array([[10.0, 20.0], [10.0, 60.0]])), [[10 / 0.6, 20 / 0.6], [20, 120]]
    )


def test_a_picture_of_another_size_is_the_same_view() -> None:
    before = grey(4)
    now = cv2.resize(shifted(before, 8.0, -4.0), (160, 120), interpolation=cv2.INTER_AREA)
    points_px = np.array([[80.0, 60.0], [240.0, 180.0]])
    for motion in (picture_motion(before, now), background_motion(before, now, np.array([100.0, 80.0, 130.0, 110.0]))):
        np.testing.assert_allclose(moved_points(motion, points_px), 0.5 * (points_px + np.array([8.0, -4.0])), atol=0.5)
    blank = np.full((120, 160), 90, np.uint8)
    np.testing.assert_allclose(picture_motion(before, blank), np.diag([0.5, 0.5, 1.0]))
    np.testing.assert_allclose(picture_motion(np.full((240, 320), 90, np.uint8), blank), np.diag([0.5, 0.5, 1.0]))
