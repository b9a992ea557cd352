"""The background: the low-rank model, and the memory of each pixel."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.harbour_watch.background import PixelMemory, learn


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


def memory(first, noise, **changes):
    times = {"remembered_frames": 50.0, "noise_frames": 1e9} | changes
    return PixelMemory(np.full(3, first, np.float32), np.full(3, noise, np.float32), **times)


def test_the_slow_residual_is_that_of_a_kalman_filter():
    watch, nobody = memory(100.0, 9.0), np.zeros(3, np.uint8)
    slow, p = 0.0, 100.0
    for left in (2.0, 4.0, 3.0, 5.0, 1.0):
        watch.learn(np.full(3, left, np.float32), nobody)
        p = min(p + 9.0 / 50.0**2, 100.0)
        gain = p / (p + 9.0)
        slow, p = slow + gain * (left - slow), p * (1.0 - gain)
    np.testing.assert_allclose(watch.slow, slow, rtol=1e-4)
    np.testing.assert_allclose(watch.doubt, p, rtol=1e-4)


def test_the_noise_is_learnt_and_outliers_hardly_count():
    rng, nobody = np.random.default_rng(0), np.zeros(3, np.uint8)
    watch = memory(1.0, 4.0, noise_frames=40.0)
    for k in range(800):
        left = rng.normal(0.0, 5.0, 3).astype(np.float32) + np.float32(300.0 * (k % 50 == 0))
        watch.learn(left, nobody)
    assert np.sqrt(watch.noise.mean()) == pytest.approx(5.0, rel=0.35)
    assert np.abs(watch.slow).max() < 5.0


def test_a_claimed_pixel_keeps_its_residual_and_doubt():
    watch, nobody, all_ = memory(64.0, 4.0), np.zeros(3, np.uint8), np.ones(3, np.uint8)
    for _ in range(60):
        watch.learn(np.full(3, 6.0, np.float32), nobody)
    before = watch.deviation(np.full(3, 26.0, np.float32)).copy()
    for _ in range(100):
        watch.learn(np.full(3, 26.0, np.float32), all_)
    np.testing.assert_array_equal(watch.deviation(np.full(3, 26.0, np.float32)), before)


def test_an_uncovered_pixel_takes_what_the_next_picture_shows_for_the_background():
    watch, nobody = memory(64.0, 4.0), np.zeros(3, np.uint8)
    for _ in range(60):
        watch.learn(np.full(3, 6.0, np.float32), nobody)
    shown = np.full(3, 46.0, np.float32)
    watch.uncover(np.array([0, 2]))
    assert (np.abs(watch.deviation(shown)) > 4.0).tolist() == [False, True, False]
    watch.learn(shown, nobody)
    np.testing.assert_allclose(watch.slow[[0, 2]], 46.0, atol=0.5)
    assert watch.slow[1] < 10.0
