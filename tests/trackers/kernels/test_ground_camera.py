"""Ground camera: homographies, their robust fit, and cars in boxes."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from sim.optics import PinholeCamera, look_down_pose, project
from trackers.kernels.ground_camera import GroundCamera, apply_homography, fit_pose, robust_normal_equations
from trackers.types import CameraModel

_MODEL = CameraModel(640, 480, 686.0)


def tilted(roll_rad: float = 0.1, pitch_rad: float = -0.15) -> GroundCamera:
    pose = look_down_pose(np.array([3.0, -5.0, 60.0]), 0.7, pitch_rad, roll_rad)
    return GroundCamera(_MODEL, pose, np.array([2e-4, -1e-4]))


def test_without_a_bend_a_camera_projects_as_the_simulators() -> None:
    camera = GroundCamera(_MODEL, tilted().T_world_camera, np.zeros(2))
    points = np.random.default_rng(0).uniform(-30, 30, (10, 2))
    pinhole = PinholeCamera(640, 480, 686.0)
    for height_m in (0.0, 0.7):
        world = np.column_stack([points, np.full(10, height_m)])
        expected = project(pinhole, camera.T_world_camera, world)[0]
        np.testing.assert_allclose(camera.to_picture(points, height_m), expected, atol=1e-8)


def test_picture_and_map_are_each_others_inverse() -> None:
    pixels = np.random.default_rng(1).uniform(-200, 800, (20, 2))
    camera = tilted()
    np.testing.assert_allclose(camera.to_picture(camera.to_map(pixels, 0.7), 0.7), pixels, atol=1e-6)


def test_derivatives_are_the_numerical_ones() -> None:
    camera = tilted()
    for k, derivative in enumerate(camera.derivatives()):
        step = np.zeros(8)
        step[k] = 1e-6
        numerical = (camera.moved(step).H_picture_map() - camera.moved(-step).H_picture_map()) / 2e-6
        np.testing.assert_allclose(derivative, numerical, rtol=1e-4, atol=1e-3)


def test_a_pose_is_found_again_in_spite_of_houses() -> None:
    rng = np.random.default_rng(2)
    camera = tilted()
    map_m = rng.uniform(-25, 25, (150, 2))
    pixels = camera.to_picture(map_m) + rng.normal(0, 0.2, (150, 2))
    pixels[:45] = camera.to_picture(map_m[:45], 8.0)
    start = camera.moved(np.array([0.02, -0.02, 0.03, 1.0, -1.0, 0.5, 0, 0]))
    weak = np.diag([25.0] * 3 + [0.04] * 3 + [1e8] * 2)
    fit = fit_pose(start, map_m, pixels, weak, (16.0, 8.0, 4.0, 3.0, 2.0))
    far = np.array([[60.0, 0.0], [0.0, -60.0], [10.0, 10.0]])
    assert np.linalg.norm(fit.camera.to_picture(far) - camera.to_picture(far), axis=1).max() < 4.0


def test_homography_is_opencvs() -> None:
    rng = np.random.default_rng(1)
    H = np.eye(3) + rng.normal(0, 0.05, (3, 3))
    points = rng.uniform(-1, 1, (20, 2))
    expected = cv2.perspectiveTransform(points[None], H)[0]
    np.testing.assert_allclose(apply_homography(H, points), expected, atol=1e-12)


def test_homography_has_no_answer_behind_the_camera() -> None:
    H = np.array([[1.0, 0, 0], [0, 1, 0], [1, 0, 0]])
    assert np.isnan(apply_homography(H, np.array([[-1.0, 0.0]]))).all()


def test_normal_equations_are_the_weighted_gradient() -> None:
    rng = np.random.default_rng(2)
    H, D = np.eye(3), rng.normal(0, 0.1, (4, 3, 3))
    points, scale = rng.uniform(-1, 1, (15, 2)), 0.3
    pixels = points + rng.normal(0, 0.05, (15, 2))

    def residual(p: np.ndarray) -> np.ndarray:
        return pixels - apply_homography(H + np.tensordot(p, D, 1), points)

    J = -np.stack([(residual(e) - residual(-e)) / 2e-6 for e in 1e-6 * np.eye(4)], axis=-1)
    r = residual(np.zeros(4))
    w = (1 + (r**2).sum(axis=1) / scale**2) ** -2
    A, b, total = robust_normal_equations(H, D, points, pixels, scale)
    np.testing.assert_allclose(A, np.einsum("n,ncp,ncq->pq", w, J, J) / scale**2, rtol=1e-4)
    np.testing.assert_allclose(b, np.einsum("n,ncp,nc->p", w, J, r) / scale**2, rtol=1e-4, atol=1e-4)
    assert total == pytest.approx(w.sum())
