"""Baselines and blind places that bridge gaps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline

from trackers.baselines.gap_methods import DampedParameters
from trackers.gaps import GapMethod, Piece, Surroundings, check_bridge
from trackers.protocols import BridgingTracker
from trackers.registry import entry

EXTRAPOLATING = ("fish_hold", "fish_constant_velocity", "fish_damped_velocity")
INTERPOLATING = ("fish_linear", "fish_hermite")
BLIND = ("fish_mean_place", "fish_middle", "fish_wall_ahead")
TAU = DampedParameters().decay_frames
DECAYED = TAU * (1 - np.exp(-10 / TAU))
AROUND = Surroundings(np.array([0.0, 0.0, 100.0, 60.0]))


def method(name: str) -> GapMethod:
    tracker = entry(name).create(np.random.default_rng(0))
    assert isinstance(tracker, BridgingTracker)
    return tracker.gap_method


def line(frames: int, step: tuple[float, float] = (1.0, 0.5), first_frame: int = 0) -> Piece:
    t = first_frame + np.arange(frames)[:, None]
    return Piece(first_frame, np.array([10.0, 20.0]) + t * np.array(step), 1 / 30)


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(EXTRAPOLATING + INTERPOLATING + BLIND), st.integers(1, 8), st.integers(1, 8), st.data())
def test_every_piece_with_a_measurement_is_answered(name: str, before: int, after: int, data: st.DataObject) -> None:
    past, future = line(before), line(after, first_frame=before + 6)
    for piece in (past, future):
        count = len(piece.position_px)
        kept = data.draw(st.sets(st.integers(0, count - 1), min_size=1))
        piece.position_px[[k for k in range(count) if k not in kept]] = np.nan
    ahead, between = method(name).extrapolate(past, 9, AROUND), method(name).interpolate(past, future, AROUND)
    assert (ahead is None) == (name in INTERPOLATING)
    assert (between is None) == (name not in INTERPOLATING)
    for bridge, count in ((ahead, 9), (between, 6)):
        if bridge is not None:
            check_bridge(bridge, count)


@pytest.mark.parametrize(
    ("name", "end"),
    [
        ("fish_hold", (29.0, 29.5)),
        ("fish_constant_velocity", (39.0, 34.5)),
        ("fish_damped_velocity", (29.0 + DECAYED, 29.5 + 0.5 * DECAYED)),
        ("fish_mean_place", (19.5, 24.75)),
        ("fish_middle", (50.0, 30.0)),
        ("fish_wall_ahead", (90.0, 60.0)),
    ],
)
def test_where_a_straight_way_leads(name: str, end: tuple[float, float]) -> None:
    bridge = method(name).extrapolate(line(20), 10, AROUND)
    assert bridge is not None
    np.testing.assert_allclose(bridge.position_px[-1], end)


def test_the_hermite_cubic_is_scipys() -> None:
    rng = np.random.default_rng(1)
    past, future = Piece(0, rng.normal(size=(5, 2)), 1.0), Piece(12, rng.normal(size=(5, 2)), 1.0)
    slopes = [(past.position_px[4] - past.position_px[1]) / 3, (future.position_px[3] - future.position_px[0]) / 3]
    spline = CubicHermiteSpline([4, 12], [past.position_px[4], future.position_px[0]], slopes)
    bridge = method("fish_hermite").interpolate(past, future, AROUND)
    assert bridge is not None
    np.testing.assert_allclose(bridge.position_px, spline(np.arange(5, 12)))


def test_a_line_goes_from_end_to_end() -> None:
    bridge = method("fish_linear").interpolate(line(5), line(5, first_frame=9), AROUND)
    assert bridge is not None
    np.testing.assert_allclose(bridge.position_px, line(9).position_px[5:])


def test_the_decay_is_learnt_and_forgotten() -> None:
    rng, tau = np.random.default_rng(2), 12.0
    velocity = np.zeros((6000, 2))
    for t in range(1, 6000):
        velocity[t] = np.exp(-1 / tau) * velocity[t - 1] + rng.normal(size=2)
    swim = Piece(0, np.cumsum(velocity, axis=0), 1.0)
    damped = method("fish_damped_velocity")
    before = damped.extrapolate(swim, 200, AROUND).position_px[-1]
    damped.learn([swim])
    learnt = damped.extrapolate(swim, 200, AROUND).position_px[-1]
    last, exit_velocity = swim.position_px[-1], (swim.position_px[-1] - swim.position_px[-4]) / 3
    # The velocity of the end is worth a little more than the mean of three frames.
    assert np.linalg.norm(learnt - last) / np.linalg.norm(exit_velocity) == pytest.approx(tau, rel=0.35)
    damped.learn([])
    np.testing.assert_array_equal(damped.extrapolate(swim, 200, AROUND).position_px[-1], before)


def test_the_covariance_of_damped_velocity_is_that_of_the_process() -> None:
    rng, tau, runs = np.random.default_rng(3), TAU, 4000
    kept = np.exp(-1 / tau)
    velocity = rng.normal(size=(runs, 2))
    place = np.zeros((runs, 2))
    first = velocity.copy()
    for _ in range(100):
        velocity = kept * velocity + np.sqrt(1 - kept**2) * rng.normal(size=(runs, 2))
        place += velocity
    spread = (place - first * tau * (1 - np.exp(-100 / tau))).var()
    # A past with steps of mean square 1 along each axis.
    past = Piece(0, np.cumsum(rng.choice([-1.0, 1.0], size=(500, 2)), axis=0), 1.0)
    bridge = method("fish_damped_velocity").extrapolate(past, 100, AROUND)
    assert bridge is not None
    assert bridge.covariance_px is not None
    assert bridge.covariance_px[-1, 0, 0] == pytest.approx(spread, rel=0.1)
