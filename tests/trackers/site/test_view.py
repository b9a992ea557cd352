"""Geometry of a site's camera beside OpenCV's, and there and back."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_harbour import looking
from trackers.site.view import SiteView
from trackers.types import CameraModel, Estimate

CAMERA = CameraModel(384, 288, 770.0, band="thermal")


def a_view(rng: np.random.Generator) -> SiteView:
    place_m = np.array([-100.0, 5.0, 20.0]) + rng.normal(0, 3, 3)
    return SiteView(CAMERA, looking(place_m, rng.normal(0, 3, 3)))


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
    view = SiteView(CAMERA, looking(np.array([0.0, 0, 20]), np.array([100.0, 0, 20])))
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
        SiteView(CAMERA, pose)
