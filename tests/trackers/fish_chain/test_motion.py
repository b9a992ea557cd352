"""Densities of places and headings after gaps, against a library's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from tests.trackers.fish_chain.steady import Steady
from tests.trackers.fish_chain.swum import swum
from trackers.fish_chain.linking import MotionModel, MotionParameters, Starts
from trackers.gaps import Surroundings

BOUNDS = np.array([0.0, 0.0, 400.0, 300.0])


def model(**changes: float | bool) -> MotionModel:
    new = MotionModel(MotionParameters(**changes), Steady())
    new.length_px = 30.0
    new.around = Surroundings(BOUNDS)
    return new


def test_a_place_is_weighed_by_the_region_of_the_gap_method() -> None:
    tail = swum(0, frames=20, velocity_px=(3.0, 0.0))
    start = swum(29, frames=10, velocity_px=(3.0, 0.0), first_px=(170.0, 110.0))
    new = model(use_posture=False, outliers=0.02, inflation=1.0, followed=0.03)
    bridge = Steady().extrapolate(tail.piece(1 / 30), 10, Surroundings())
    covariance = bridge.covariance_px[9] + (0.03 * 30.0) ** 2 * np.eye(2)
    inside = multivariate_normal(bridge.position_px[9], covariance).pdf([170.0, 110.0])
    area = 400.0 * 300.0
    expected = np.log(0.98 * inside + 0.02 / area) - np.log(1 / area)
    assert new.log_ratios(tail, Starts.of([start]))[0] == pytest.approx(expected, rel=1e-6)


def test_headings_are_a_density_that_widens_with_time() -> None:
    new = model()
    rng = np.random.default_rng(0)
    turning = [swum(0, frames=120, velocity_px=(2.0, 1.0), turns_rad=rng.normal(0, 0.08, 120)) for _ in range(8)]
    new.learn([each.piece(1 / 30) for each in turning])
    angles = np.linspace(-np.pi, np.pi, 4001)[:-1]
    peaks = []
    for age in (1, 10, 60, 200):
        ratios = new._heading_ratios(angles, np.full(len(angles), age))
        assert np.exp(ratios).mean() == pytest.approx(1.0, rel=1e-3)
        peaks.append(float(ratios.max()))
    assert peaks == sorted(peaks, reverse=True)
    assert peaks[0] > 1.0


def test_a_fish_that_was_followed_inside_a_blob_is_expected_there() -> None:
    tail = swum(0, frames=20, velocity_px=(3.0, 0.0))
    for frame in range(20, 30):
        tail.haunt(frame, np.array([160.0 - 5 * (frame - 20), 200.0, np.pi, 0.0]))
    there = swum(30, frames=5, velocity_px=(-5.0, 0.0), first_px=(110.0, 200.0))
    ahead = swum(30, frames=5, velocity_px=(3.0, 0.0), first_px=(187.0, 100.0))
    followed, place = (model(use_posture=use).log_ratios(tail, Starts.of([there, ahead])) for use in (True, False))
    assert followed[0] > followed[1] + 5
    assert place[1] > place[0]
