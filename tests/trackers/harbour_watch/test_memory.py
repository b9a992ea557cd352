"""The memory of a pixel beside a Kalman filter written out, and what it does while an object hides it."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.harbour_watch.memory import PixelMemory


def memory(first, noise, **changes):
    times = {"remembered_frames": 50.0, "noise_frames": 1e9, "hidden_frames": 100.0} | changes
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


def test_a_claimed_pixel_keeps_its_residual_and_doubt_returns_when_it_is_seen_again():
    watch, nobody, all_ = memory(64.0, 4.0), np.zeros(3, np.uint8), np.ones(3, np.uint8)
    for _ in range(60):
        watch.learn(np.full(3, 6.0, np.float32), nobody)
    before = watch.deviation(np.full(3, 26.0, np.float32)).copy()
    for _ in range(100):
        watch.learn(np.full(3, 26.0, np.float32), all_)
    np.testing.assert_allclose(watch.slow, 6.0, atol=0.3)
    after = watch.deviation(np.full(3, 26.0, np.float32))
    expected = 20.0 / np.sqrt(4.0 + 64.0 * (1.0 - np.exp(-1.0)))
    np.testing.assert_allclose(after, expected, rtol=0.05)
    assert (after < before).all()
    watch.learn(np.full(3, 12.0, np.float32), nobody)
    assert (watch.slow > 10.0).all()
