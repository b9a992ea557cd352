"""The memory of a pixel beside a Kalman filter written out, while an object hides it, and when it comes to light."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.harbour_watch.background import PixelMemory


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
