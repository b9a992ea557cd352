from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from benchmarks.judges.frame_out.metrics.posterior import (
    _densities,
    calibration,
    coverage,
    gaussian_calibration,
    level_histogram,
    particle_calibration,
)
from tests.fakes_scenario import CAMERA, FakeEpisode, FakeTown
from trackers.types import Estimate

TRIALS = 600


def mixture(rng: np.random.Generator, count: int) -> np.ndarray:
    """Draw from two lanes a hundred metres apart, one three times as likely, as after a crossing."""
    left = rng.random(count) < 0.25
    return np.where(left[:, None], [-50.0, 0.0], [50.0, 10.0]) + rng.normal(0, [1.0, 6.0], (count, 2))


def test_regions_of_a_true_posterior_hold_the_truth_as_often_as_they_say() -> None:
    """Monte Carlo: truth and particles are drawn alike; 3.5 standard errors of the share are allowed."""
    rng = np.random.default_rng(1)
    levels = []
    for _ in range(TRIALS):
        weights = rng.dirichlet(np.full(200, 5.0))
        levels.append(particle_calibration(mixture(rng, 200), weights, mixture(rng, 1)[0]).credible_level)
    for region in (0.5, 0.9, 0.95):
        allowed = 3.5 * np.sqrt(region * (1 - region) / TRIALS)
        assert coverage(np.array(levels), region) == pytest.approx(region, abs=allowed)
    assert stats.kstest(levels, "uniform").pvalue > 1e-3


@pytest.mark.parametrize(("spread", "sign"), [(0.5, -1), (2.0, 1)])
def test_a_posterior_too_narrow_or_too_wide_shows(spread: float, sign: int) -> None:
    rng = np.random.default_rng(2)
    levels = [
        particle_calibration(
            spread * rng.normal(size=(150, 2)), np.full(150, 1 / 150), rng.normal(size=2)
        ).credible_level
        for _ in range(200)
    ]
    assert sign * (coverage(np.array(levels), 0.9) - 0.9) > 0.05


def test_levels_of_a_gaussian_are_uniform_and_its_nees_is_two() -> None:
    rng = np.random.default_rng(3)
    covariance = np.array([[4.0, 1.5], [1.5, 2.0]])
    truths = rng.multivariate_normal([1.0, -2.0], covariance, TRIALS)
    judged = [gaussian_calibration(np.array([1.0, -2.0]), covariance, truth) for truth in truths]
    assert stats.kstest([each.credible_level for each in judged], "uniform").pvalue > 1e-3
    assert np.mean([each.nees for each in judged]) == pytest.approx(2.0, abs=3.5 * 2 / np.sqrt(TRIALS))


def test_nees_of_particles_is_that_of_their_moments() -> None:
    rng = np.random.default_rng(4)
    points, weights = rng.normal(size=(80, 2)), rng.dirichlet(np.ones(80))
    mean = weights @ points
    covariance = np.cov(points.T, aweights=weights, ddof=0)
    truth = np.array([0.7, -1.2])
    expected = (truth - mean) @ np.linalg.inv(covariance) @ (truth - mean)
    assert particle_calibration(points, weights, truth).nees == pytest.approx(expected, rel=1e-6)


def test_densities_are_those_of_the_formula() -> None:
    rng = np.random.default_rng(5)
    points, weights, query = rng.normal(size=(30, 2)), rng.dirichlet(np.ones(30)), rng.normal(size=2)
    kernels = np.exp(-0.5 * ((points[:, None] - points[None]) ** 2).sum(axis=2))
    to_query = weights * np.exp(-0.5 * ((points - query) ** 2).sum(axis=1))
    expected = kernels @ weights - weights + to_query
    density, at_query = _densities(points, weights, query)
    np.testing.assert_allclose(density, expected, rtol=1e-9)
    assert at_query == pytest.approx(to_query.sum(), rel=1e-9)


@pytest.mark.parametrize("count", [1, 2, 50])
def test_near_the_degenerate_point_there_is_still_an_answer(count: int) -> None:
    """One particle, two, or fifty at one place: the truth on them is inside, far from them outside."""
    points = np.tile([3.0, 4.0], (count, 1))
    weights = np.full(count, 1 / count)
    assert particle_calibration(points, weights, np.array([300.0, 4.0])).credible_level == 1.0
    assert 0.0 <= particle_calibration(points, weights, np.array([3.0, 4.0])).credible_level <= 1.0


def test_particles_nowhere_keep_their_weight() -> None:
    """Half of the weight lies behind the camera: the other half, all of it nearer than the truth, is half a region."""
    ring = np.column_stack([np.cos(np.arange(50)), np.sin(np.arange(50))])
    points = np.vstack([ring, np.full((50, 2), np.nan)])
    level = particle_calibration(points, np.full(100, 0.01), np.array([3.0, 0.0])).credible_level
    assert level == pytest.approx(0.5)


def test_nothing_usable_holds_no_truth() -> None:
    level = particle_calibration(np.full((5, 2), np.nan), np.full(5, 0.2), np.zeros(2)).credible_level
    assert level == 1.0
    assert gaussian_calibration(np.zeros(2), np.zeros((2, 2)), np.ones(2)).credible_level == 1.0
    assert gaussian_calibration(np.full(2, np.nan), np.eye(2), np.ones(2)).credible_level == 1.0


def test_particles_are_judged_on_the_ground_through_the_true_camera() -> None:
    frame = FakeEpisode(FakeTown("x"), closed_loop=False, phase_s=0.0).step()
    rng = np.random.default_rng(6)
    metres = frame.truth.T_world_object[0, :2, 3] + rng.normal(0, 2.0, (300, 2))
    offset = (metres - frame.truth.T_world_camera[:2, 3]) * CAMERA.focal_px / (60.0 - 0.75)
    pixels = CAMERA.centre_px + np.column_stack([-offset[:, 1], -offset[:, 0]])
    said = Estimate(pixels.mean(axis=0), particles_px=pixels)
    expected = particle_calibration(metres, np.full(300, 1 / 300), frame.truth.T_world_object[0, :2, 3])
    found = calibration(said, frame.truth, 0, CAMERA)
    assert found.credible_level == pytest.approx(expected.credible_level)
    assert found.nees == pytest.approx(expected.nees, rel=1e-6)
    assert np.isnan(calibration(Estimate(np.zeros(2)), frame.truth, 0, CAMERA).credible_level)


def test_histogram_of_levels() -> None:
    levels = np.array([0.01, 0.03, 0.5, 1.0, np.nan])
    histogram = level_histogram(levels)
    assert histogram.sum() == pytest.approx(1.0)
    # A frame without posterior counts as a truth outside every region.
    assert histogram[0] == histogram[-1] == 0.4
