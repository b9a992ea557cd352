"""The kernels of the particle filter beside plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW
from trackers.eigen_swarm.swarm import cloud, count_inside, likelihoods, move
from trackers.eigen_swarm.tracker import blocks_from_metres
from trackers.site import place

VOLUME = place(SURVEY, CAMERA, VIEW.T_world_camera)


def test_motion_is_linear_with_gaussian_noise() -> None:
    rng = np.random.default_rng(0)
    states, noise = rng.normal(size=(50, 6)), rng.standard_normal((50, 6))
    F = np.eye(6) + 2.0 * np.eye(6, k=3)
    expected = states @ F.T + noise * [0.7, 0.7, 0.7, 0.2, 0.2, 0.2]
    move(states, noise, 2.0, 0.7, 0.2)
    np.testing.assert_allclose(states, expected)


def test_a_particle_has_the_likelihood_of_the_block_that_it_falls_in() -> None:
    rng = np.random.default_rng(1)
    f = rng.random((CAMERA.height_px // 4, CAMERA.width_px // 4))
    # Some lie outside the volume, some outside the picture, some behind the camera.
    places_m = np.concatenate([VOLUME.scatter(rng, 3000), rng.uniform(-130, 130, (3000, 3))])
    px, _ = VIEW.project(places_m)
    seen = VOLUME.contains(places_m) & (px >= 0).all(axis=1) & (px < [CAMERA.width_px, CAMERA.height_px]).all(axis=1)
    column, row = np.floor(px[seen] / 4.0).astype(int).T
    expected = np.zeros(len(places_m))
    expected[seen] = f[row, column]
    assert 500 < seen.sum() < 3100
    states = np.hstack([places_m, np.zeros_like(places_m)])
    got = likelihoods(states, blocks_from_metres(VIEW), f, VOLUME.centre_m, VOLUME.axes, 0.5 * VOLUME.size_m)
    np.testing.assert_array_equal(got, expected)


def test_nothing_is_seen_by_a_camera_without_blocks() -> None:
    states = np.hstack([VOLUME.scatter(np.random.default_rng(2), 9), np.zeros((9, 3))])
    f = np.empty((0, 0))
    got = likelihoods(states, blocks_from_metres(VIEW), f, VOLUME.centre_m, VOLUME.axes, 0.5 * VOLUME.size_m)
    np.testing.assert_array_equal(got, 0.0)


@pytest.mark.parametrize("turned_rad", [0.0, 0.3, 1.2, -0.8])
def test_the_cloud_is_the_pca_about_the_weighted_mean(turned_rad: float) -> None:
    rng = np.random.default_rng(3)
    c, s = np.cos(turned_rad), np.sin(turned_rad)
    states = rng.normal(size=(4000, 6)) * [9.0, 0.7, 1.1, 1, 1, 1] + [10, 20, 3, 0, 0, 0]
    states[:, :2] = states[:, :2] @ np.array([[c, s], [-s, c]])
    weights = rng.random(4000)
    centre, a1, spread = cloud(states, weights)
    expected = weights @ states[:, :3] / weights.sum()
    np.testing.assert_allclose(centre, expected)
    offsets = states[:, :3] - expected
    values, vectors = np.linalg.eigh(offsets[:, :2].T @ offsets[:, :2] / 4000)
    np.testing.assert_allclose(spread, np.sqrt([values[1], values[0], (offsets[:, 2] ** 2).mean()]))
    assert abs(a1 @ vectors[:, 1]) == pytest.approx(1.0)


def test_the_particles_inside_a_region_are_counted() -> None:
    rng = np.random.default_rng(4)
    states, a1, half_m = rng.normal(size=(2000, 6)), np.array([np.cos(0.5), np.sin(0.5)]), np.array([0.3, 0.9, 1.1])
    along, across = states[:, :2] @ a1, states[:, :2] @ np.array([-a1[1], a1[0]])
    expected = (np.abs(np.column_stack([along, across, states[:, 2]])) <= half_m).all(axis=1).sum()
    assert 100 < expected < 1900
    assert count_inside(states, np.zeros(3), a1, half_m) == expected
