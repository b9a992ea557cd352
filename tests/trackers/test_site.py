"""Site: geometry of the camera beside OpenCV's, the watched volume, the quay, and readings of pictures."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW, looking
from trackers.site import SiteView, noise_of, place, reading_of, shows_water, stood_on
from trackers.types import CameraModel, Estimate, Observation

LARGE_CAMERA = CameraModel(384, 288, 770.0, band="thermal")


def a_view(rng: np.random.Generator) -> SiteView:
    place_m = np.array([-100.0, 5.0, 20.0]) + rng.normal(0, 3, 3)
    return SiteView(LARGE_CAMERA, looking(place_m, rng.normal(0, 3, 3)))


def test_projection_is_that_of_opencv() -> None:
    rng = np.random.default_rng(0)
    view, points_m = a_view(rng), rng.uniform([-50, -20, -3], [50, 20, 4], (200, 3))
    R = view.T_world_camera[:3, :3].T
    K = np.array([[770.0, 0, 192.0], [0, 770.0, 144.0], [0, 0, 1]])
    expected, _ = cv2.projectPoints(points_m, cv2.Rodrigues(R)[0], -R @ view.place_m, K, None)
    px, depth_m = view.project(points_m)
    np.testing.assert_allclose(px, expected[:, 0], atol=1e-6)
    np.testing.assert_allclose(depth_m, (points_m - view.place_m) @ view.T_world_camera[:3, 2])


def test_a_point_behind_the_camera_is_nan() -> None:
    view = a_view(np.random.default_rng(1))
    px, depth_m = view.project(np.stack([view.place_m - view.T_world_camera[:3, 2], view.place_m]))
    assert np.isnan(px).all()
    assert np.isnan(depth_m).all()


@pytest.mark.parametrize("z_m", [-1.8, 0.0, 3.0])
def test_pixels_return_to_their_plane(z_m: float) -> None:
    rng = np.random.default_rng(2)
    view, points_m = a_view(rng), rng.uniform([-50, -20, z_m], [50, 20, z_m], (50, 3))
    np.testing.assert_allclose(view.on_plane(view.project(points_m)[0], z_m), points_m, atol=1e-9)


def test_a_pixel_above_the_horizon_meets_no_ground() -> None:
    view = SiteView(LARGE_CAMERA, looking(np.array([0.0, 0, 20]), np.array([100.0, 0, 20])))
    ground_m = view.on_plane(np.array([[192.0, 100.0], [192.0, 144.0], [192.0, 200.0]]), 0.0)
    np.testing.assert_array_equal(np.isfinite(ground_m).all(axis=1), [False, False, True])


def test_an_estimate_has_the_place_of_its_box() -> None:
    rng = np.random.default_rng(3)
    view, centre_m = a_view(rng), np.array([10.0, 4.0, 0.8])
    estimate = view.estimate_of(centre_m, np.array([4.0, 1.7, 1.6]), 0.4)
    assert estimate is not None
    np.testing.assert_allclose(view.place_of(estimate), centre_m, atol=1e-9)
    # The region holds the points of the box, and the farthest of them lie on its sides.
    c, s = np.cos(0.4), np.sin(0.4)
    local_m = rng.uniform(-0.5, 0.5, (20_000, 3)) * [4.0, 1.7, 1.6]
    inside_m = centre_m + local_m @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    px, _ = view.project(inside_m)
    box_xyxy = estimate.box_xyxy
    assert box_xyxy is not None
    assert (px >= box_xyxy[:2]).all()
    assert (px <= box_xyxy[2:]).all()
    np.testing.assert_allclose(np.concatenate([px.min(axis=0), px.max(axis=0)]), box_xyxy, atol=1.5)


def test_a_place_without_depth_is_nan_and_a_box_behind_is_none() -> None:
    view = a_view(np.random.default_rng(4))
    assert np.isnan(view.place_of(Estimate(np.zeros(2)))).all()
    assert view.estimate_of(view.place_m, np.ones(3), 0.0) is None


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.full((4, 4), np.nan), r"expected a \(4, 4\) matrix of finite numbers"),
        (np.eye(3), r"expected a \(4, 4\) matrix"),
        (np.diag([1.0, 1.0, 2.0, 1.0]), "expected a rotation"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "expected a rotation"),
    ],
)
def test_what_is_no_pose_is_refused(pose: NDArray[np.float64], message: str) -> None:
    with pytest.raises(ValueError, match=f"T_world_camera: {message}"):
        SiteView(LARGE_CAMERA, pose)


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


QUAY = replace(SURVEY, edge_m=(-15.0, 3.0))


@pytest.mark.parametrize(
    "point_m",
    [
        (0.0, 4.0, 0.0),
        (-14.9, -4.0, 0.0),
        (-15.0, 2.0, -0.5),
        (-15.0, 2.0, -1.7),
        (-15.1, 0.0, -1.8),
        (-40.0, 1.0, -1.8),
    ],
)
def test_points_of_quay_wall_and_water_are_found_where_they_are_seen(point_m: tuple[float, float, float]) -> None:
    px, _ = VIEW.project(np.array([point_m]))
    np.testing.assert_allclose(stood_on(QUAY, VIEW, px), [point_m], atol=1e-6)


def test_the_water_beyond_the_edge_is_seen_from_the_land() -> None:
    view = SiteView(CAMERA, looking(np.array([60.0, 0.0, 20.0]), np.array([-20.0, 0.0, 0.0])))
    for point_m in ((-10.0, 1.0, 0.0), (-60.0, 1.0, -1.8)):
        px, _ = view.project(np.array([point_m]))
        np.testing.assert_allclose(stood_on(QUAY, view, px), [point_m], atol=1e-6)


def test_water_is_shown_where_its_mean_level_is_seen_beyond_the_edge() -> None:
    water = shows_water(QUAY, VIEW)
    assert water.shape == (CAMERA.height_px, CAMERA.width_px)
    for x_m, z_m, expected in ((-15.3, -1.8, True), (-18.0, -1.8, True), (-15.0, -1.5, False), (0.0, 0.0, False)):
        (px,), _ = VIEW.project(np.array([[x_m, 1.0, z_m]]))
        assert water[int(px[1]), int(px[0])] == expected, (x_m, z_m)
    assert not shows_water(QUAY, SiteView(CAMERA, looking(np.array([0.0, 0.0, 9.0]), np.array([9.0, 0.0, 20.0])))).any()


def test_above_the_horizon_there_is_nothing_to_stand_on() -> None:
    assert np.isnan(stood_on(QUAY, VIEW, np.array([[96.0, -200.0]]))).all()


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"mean_water_m": 0.0}, "mean_water_m: expected a finite number of metres < 0, got 0.0"),
        ({"mean_water_m": float("nan")}, "mean_water_m"),
        ({"seaward": (1.0, 1.0)}, "seaward: expected a vector of length 1"),
        ({"edge_m": (float("inf"), 0.0)}, "edge_m: expected finite numbers"),
        ({"watched_m": (90.0, 0.0, 6.0)}, "watched_m: expected three numbers of metres > 0"),
        ({"watched_bottom_m": float("nan")}, "watched_bottom_m: expected a finite number"),
    ],
)
def test_no_survey_is_refused_by_name(changes: dict, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        replace(SURVEY, **changes)


GREY = np.arange(12, dtype=np.uint8).reshape(3, 4)
COUNTS = 100 + GREY.astype(np.uint16)


def observed(counts) -> Observation:
    return Observation(np.broadcast_to(GREY[..., None], (3, 4, 3)), 0.0, CAMERA, counts=counts)


@pytest.mark.parametrize(
    ("counts", "wanted", "expected"),
    [(COUNTS, True, COUNTS), (COUNTS, False, GREY), (None, True, GREY), (COUNTS[:2], True, GREY)],
)
def test_counts_are_read_where_there_are_any(counts, wanted, expected):
    np.testing.assert_array_equal(reading_of(observed(counts), wanted), expected)


def test_the_noise_is_that_of_each_place_without_common_steps_and_outliers():
    rng = np.random.default_rng(0)
    sigma = np.where(np.arange(60) < 30, 4.0, 9.0)
    pictures = rng.normal(0.0, sigma, (300, 40, 60)) + 50.0 * rng.normal(size=(300, 1, 1))
    pictures[rng.random(pictures.shape) < 0.02] += 500.0
    noise = noise_of(pictures.astype(np.float32))
    assert noise[:, :28].mean() == pytest.approx(4.0, rel=0.1)
    assert noise[:, 32:].mean() == pytest.approx(9.0, rel=0.1)
    assert noise_of(np.zeros((5, 6, 7), np.float32)).max() == 0.5


def test_one_picture_has_the_noise_of_its_fine_structure():
    picture = np.random.default_rng(1).normal(200.0, 6.0, (1, 80, 90)).astype(np.float32)
    noise = noise_of(picture)
    assert noise.shape == (80, 90)
    np.testing.assert_allclose(noise, 6.0, rtol=0.35)
