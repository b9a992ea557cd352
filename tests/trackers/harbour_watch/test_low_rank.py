"""The low-rank background beside least squares, and intruders as outliers."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.harbour_watch.background import learn


@pytest.fixture
def site():
    """Pictures (T, N) of three latent causes, with noise."""
    rng = np.random.default_rng(3)
    causes, looks = rng.normal(size=(60, 3)), rng.normal(0.0, 20.0, (3, 4000))
    mean = 3000.0 + rng.normal(0.0, 50.0, 4000)
    pictures = (mean + causes @ looks + rng.normal(0.0, 2.0, (60, 4000))).astype(np.float32)
    return pictures, looks, mean, rng


def test_without_outliers_the_fit_is_that_of_least_squares(site):
    pictures, looks, mean, _ = site
    model = learn(pictures, 3, np.full(4000, 2.0, np.float32))
    new = (mean + np.array([0.7, -1.2, 0.4]) @ looks).astype(np.float32)
    wanted = np.linalg.lstsq(model.basis.T.astype(float), (new - model.mean).astype(float), rcond=None)[0]
    found = model.explained(model.coefficients(new, None))
    np.testing.assert_allclose(found, model.mean + wanted @ model.basis, atol=0.3)


def test_the_basis_spans_the_causes_and_not_the_noise(site):
    pictures, looks, mean, _ = site
    model = learn(pictures, 3, np.full(4000, 2.0, np.float32))
    new = (mean + np.array([-0.5, 0.9, 1.1]) @ looks).astype(np.float32)
    left = new - model.explained(model.coefficients(new, None))
    assert np.abs(left).mean() < 2.0
    assert np.median(model.spread) == pytest.approx(2.0, rel=0.15)


def test_an_intruder_over_a_tenth_of_the_picture_is_left_and_not_explained(site):
    pictures, looks, mean, rng = site
    model = learn(pictures, 3, np.full(4000, 2.0, np.float32))
    new = (mean + np.array([0.7, -1.2, 0.4]) @ looks + rng.normal(0.0, 2.0, 4000)).astype(np.float32)
    with_intruder = new.copy()
    with_intruder[1000:1400] += 200.0
    left = with_intruder - model.explained(model.coefficients(with_intruder, None))
    assert np.abs(np.delete(left, np.s_[1000:1400])).mean() < 2.5
    assert left[1000:1400].mean() == pytest.approx(200.0, abs=10.0)


def test_offset_and_gain_of_the_camera_are_taken_out(site):
    pictures, _, mean, _ = site
    model = learn(pictures, 3, np.full(4000, 2.0, np.float32))
    new = (1.1 * mean - 400.0).astype(np.float32)
    left = new - model.explained(model.coefficients(new, None))
    assert np.abs(left).mean() < 1.0


def test_one_picture_alone_is_its_own_mean():
    picture = np.random.default_rng(0).normal(3000.0, 40.0, (1, 500)).astype(np.float32)
    model = learn(picture, 4, np.full(500, 2.0, np.float32))
    np.testing.assert_allclose(model.explained(model.coefficients(picture[0], None)), picture[0], atol=1e-2)
