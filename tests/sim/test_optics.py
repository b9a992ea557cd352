"""Projection against OpenCV's, and rays, planes and poses against each other."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sim.optics import (
    Intrinsics,
    intersect_plane,
    intrinsic_matrix,
    invert_pose,
    look_down_pose,
    may_show,
    project,
    rays,
)
from trackers.types import CameraModel

CAMERA = CameraModel.from_field_of_view(640, 480, np.deg2rad(50.0))
angles = st.floats(-0.6, 0.6)


@settings(max_examples=50, deadline=None)
@given(angles, angles, st.floats(-4, 4), st.integers(0, 2**31))
def test_projection_is_opencvs(pitch, roll, yaw, seed):
    T = look_down_pose(np.array([3.0, -7.0, 60.0]), yaw, pitch, roll)
    points = np.random.default_rng(seed).uniform([-30, -30, 0], [30, 30, 15], (20, 3))
    pixels, depth = project(CAMERA, T, points)
    T_camera_world = invert_pose(T)
    # OpenCV counts pixel centres as whole numbers; here they are at halves.
    K = intrinsic_matrix(CAMERA)
    # Looking down is a half turn; near it OpenCV's rotation vector of a matrix loses digits, SciPy's does not.
    turn = Rotation.from_matrix(T_camera_world[:3, :3]).as_rotvec()
    expected, _ = cv2.projectPoints(points, turn, T_camera_world[:3, 3], K, None)
    np.testing.assert_allclose(pixels[depth > 0.1], expected[depth > 0.1, 0], atol=1e-6)
    np.testing.assert_allclose(T_camera_world @ T, np.eye(4), atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(angles, angles, st.floats(-4, 4), st.floats(-200, 800), st.floats(-200, 600))
def test_plane_intersection_inverts_projection(pitch, roll, yaw, u, v):
    T = look_down_pose(np.array([3.0, -7.0, 60.0]), yaw, pitch, roll)
    pixel = np.array([u, v])
    ground = intersect_plane(CAMERA, T, pixel, 0.75)
    if rays(CAMERA, T, pixel)[2] > -0.02:
        return
    back, _ = project(CAMERA, T, np.array([*ground, 0.75]))
    np.testing.assert_allclose(back, pixel, atol=1e-5)


def test_horizon_and_points_behind_are_nan():
    level = look_down_pose(np.array([0.0, 0.0, 60.0]), 0.0, np.pi / 2, 0.0)
    assert np.isnan(intersect_plane(CAMERA, level, np.array([320.0, 100.0]), 0.0)).all()
    assert np.isfinite(intersect_plane(CAMERA, level, np.array([320.0, 300.0]), 0.0)).all()
    pixels, depth = project(CAMERA, level, np.array([[-10.0, 0.0, 60.0]]))
    assert depth[0] < 0
    assert np.isnan(pixels).all()


@pytest.mark.parametrize(
    ("attitude", "expected"),
    [((0, 0, 0), (0, 0)), ((0, 0.1, 0), (1, 0)), ((0, 0, 0.1), (0, 1)), ((np.pi / 2, 0.1, 0), (0, 1))],
)
def test_attitude_swings_the_view_where_its_docstring_says(attitude, expected):
    T = look_down_pose(np.array([0.0, 0.0, 50.0]), *attitude)
    aim = intersect_plane(CAMERA, T, CAMERA.centre_px, 0.0)
    np.testing.assert_allclose(aim, 50.0 * np.tan(0.1) * np.array(expected), atol=1e-9)


def test_top_of_the_picture_is_the_heading():
    T = look_down_pose(np.array([0.0, 0.0, 50.0]), 0.0, 0.0, 0.0)
    ahead, _ = project(CAMERA, T, np.array([5.0, 0.0, 0.0]))
    left, _ = project(CAMERA, T, np.array([0.0, 5.0, 0.0]))
    assert ahead[1] < 240
    assert ahead[0] == pytest.approx(320)
    assert left[0] < 320


def test_a_sphere_that_a_picture_shows_may_be_shown():
    camera = Intrinsics(64, 48, 60.0)
    T_world_camera = look_down_pose(np.array([3.0, -2.0, 50.0]), 0.4, 0.3, 0.1)
    rng = np.random.default_rng(0)
    centres_m = rng.uniform(-90.0, 90.0, (400, 3))
    nearby = centres_m[:, None] + 8.0 * _directions(rng, 200)
    pixels, depth_m = project(camera, T_world_camera, nearby)
    inside = (depth_m > 0) & (pixels >= 0).all(axis=-1) & (pixels < (64, 48)).all(axis=-1)
    shown = may_show(camera, T_world_camera, centres_m, 8.0)
    assert shown[inside.any(axis=1)].all()
    assert 0.05 < shown.mean() < 0.5


def _directions(rng: np.random.Generator, count: int) -> np.ndarray:
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
