"""Errors of disparity: of a board before a wall whose depths, and what hides what, are worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from benchmarks.judges.stereo.disparity import DisparityMeasurement, disparity_error_px, error_sums, seen_by_both
from scenarios.scenario import Frame
from scenarios.stereo_follow.camera import StereoMount, draw_mount
from tests.benchmarks.judges.follow.fake_follow import CAMERA, POSE, FakeFollow, FakeFollowEpisode

WALL_M, BOARD_M = 6.0, 2.0
BOARD_X_M, BOARD_Y_M = (-0.4, 0.3), (-0.5, 0.35)
FOCAL_TIMES_BASELINE = CAMERA.focal_px * 0.12


def _on_board(points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    x, y = points_m[..., 0], points_m[..., 1]
    return (x > BOARD_X_M[0]) & (x < BOARD_X_M[1]) & (y > BOARD_Y_M[0]) & (y < BOARD_Y_M[1])


def _cast(T_left_eye: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points (H, W, 3) that a camera sees, in the left camera's frame, where board and wall are z = 2, 6."""
    v, u = np.indices((CAMERA.height_px, CAMERA.width_px)) + 0.5
    x, y = CAMERA.centre_px
    local = np.stack([(u - x) / CAMERA.focal_px, (v - y) / CAMERA.focal_px, np.ones_like(u)], axis=-1)
    direction, eye_m = local @ T_left_eye[:3, :3].T, T_left_eye[:3, 3]
    board, wall = (eye_m + direction * ((z - eye_m[2]) / direction[..., 2:]) for z in (BOARD_M, WALL_M))
    return np.where(_on_board(board)[..., None], board, wall)


def _depth_m(points_m: NDArray[np.float64], T_left_eye: NDArray[np.float64]) -> NDArray[np.float32]:
    return ((points_m - T_left_eye[:3, 3]) @ T_left_eye[:3, 2]).astype(np.float32)


MOUNT: StereoMount = draw_mount(np.random.default_rng(4))


@pytest.fixture(scope="module")
def frame() -> Frame:
    """The first frame of the drawn episode, with board and wall instead of people, seen by a mounted pair."""
    first = FakeFollowEpisode(FakeFollow("a fixed camera"), closed_loop=False).step()
    depths = [_depth_m(_cast(pose), pose) for pose in (np.eye(4), MOUNT.T_left_right)]
    truth = replace(first.truth, depth_m=depths[0], right_depth_m=depths[1], T_world_right=POSE @ MOUNT.T_left_right)
    return Frame(first.observation, truth)


def test_a_pixel_counts_if_nothing_is_between_its_point_and_the_right_camera(frame: Frame) -> None:
    points_m, eye_m = _cast(np.eye(4)), MOUNT.T_left_right[:3, 3]
    way = points_m - eye_m
    through = eye_m + way * ((BOARD_M - eye_m[2]) / way[..., 2:])
    hidden = _on_board(through) & (points_m[..., 2] > BOARD_M + 0.1)
    local = way @ MOUNT.T_left_right[:3, :3]
    right_px = CAMERA.focal_px * local[..., :2] / local[..., 2:] + CAMERA.centre_px
    beside = ((right_px < 0) | (right_px >= (CAMERA.width_px, CAMERA.height_px))).any(axis=-1)
    # At the board's edges in the right picture the nearest pixel decides.
    near_edge = maximum_filter(frame.truth.right_depth_m, 3) - minimum_filter(frame.truth.right_depth_m, 3) > 1.0
    column, row = np.clip(right_px.astype(int), 0, (CAMERA.width_px - 1, CAMERA.height_px - 1)).transpose(2, 0, 1)
    sure = ~near_edge[row, column]
    counts = seen_by_both(frame)
    np.testing.assert_array_equal(counts[sure], ~(hidden | beside)[sure])
    # Four columns beside a board of 50 rows, and two at the picture's border.
    assert (hidden & sure).sum() > 100
    assert (beside & sure).sum() > 100
    assert (counts & sure).mean() > 0.8


def test_the_sky_does_not_count_and_is_no_mistake_of_what_lies_before_it(frame: Frame) -> None:
    sky = replace(
        frame.truth,
        depth_m=np.where(frame.truth.depth_m > 4.0, np.inf, frame.truth.depth_m).astype(np.float32),
        right_depth_m=np.where(frame.truth.right_depth_m > 4.0, np.inf, frame.truth.right_depth_m).astype(np.float32),
    )
    counts = seen_by_both(Frame(frame.observation, sky))
    board = frame.truth.depth_m < 4.0
    assert not counts[~board].any()
    assert counts[board].mean() > 0.95


def test_a_perfect_disparity_has_no_error(frame: Frame) -> None:
    np.testing.assert_allclose(disparity_error_px(frame, frame.truth.depth_m), 0.0, atol=1e-5)


@pytest.mark.parametrize("shift_px", [-0.5, 1.5, 4.0])
def test_a_shifted_disparity_is_off_by_its_shift_at_full_size(frame: Frame, shift_px: float) -> None:
    disparity_px = FOCAL_TIMES_BASELINE / frame.truth.depth_m + shift_px
    half_size_m = (FOCAL_TIMES_BASELINE / disparity_px)[::2, ::2].astype(np.float32)
    half_size_m[:10] = np.nan
    error_px = disparity_error_px(frame, half_size_m)
    assert error_px.shape == frame.truth.depth_m.shape
    assert np.isnan(error_px[:20]).all()
    # A pixel of the smaller picture has one depth, though the board's edge may go through it.
    assert np.isclose(error_px[20:], abs(shift_px), atol=1e-4).mean() > 0.97


def test_shares_are_those_of_all_pixels_and_medians_those_of_pictures() -> None:
    rng = np.random.default_rng(0)
    pictures = [rng.exponential(2.0, count) for count in (50, 400, 7)]
    pictures[1][rng.random(400) < 0.3] = np.nan
    measurement = DisparityMeasurement("target")
    nothing = [np.full(20, np.nan), np.empty(0)]
    measurement._sums = {"all": sum(map(error_sums, [*pictures, *nothing])), "target": sum(map(error_sums, nothing))}
    found = {score.metric: (score.value, score.weight) for score in measurement.scores()}
    together = np.concatenate(pictures)
    known = together[~np.isnan(together)]
    medians = [np.nanmedian(each) for each in pictures]
    lengths = [np.isfinite(picture).sum() for picture in pictures]
    expected = {
        "error_px": (np.average(medians, weights=lengths), len(known)),
        "bad_1": (np.mean(known > 1.0), len(known)),
        "bad_3": (np.mean(known > 3.0), len(known)),
        "density": (len(known) / (len(together) + 20), len(together) + 20),
    }
    for name, value_and_weight in expected.items():
        assert found[f"disparity_{name}_all"] == pytest.approx(value_and_weight)
    assert found["disparity_error_px_target"] == (None, 0.0)
    assert found["disparity_density_target"] == (0.0, 20.0)
