"""Homographies of the ground against OpenCV's, and normal equations against numerical gradients."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from trackers.kernels.ground_camera import apply_homography, robust_normal_equations


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
