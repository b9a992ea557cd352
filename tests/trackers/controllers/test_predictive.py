"""``predictive``: its model, its solver, and what it does with a target at rest, in wind, and in a swing."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from trackers.belief.kernel import BELIEF
from trackers.controllers.predictive import (
    _KNOTS,
    _STEPS,
    PredictiveController,
    PredictiveParameters,
    responses,
    solve_symmetric,
)
from trackers.controllers.reentry import in_picture, tilted_axes

RATE_HZ, HEIGHT_M = 15.0, 42.0
HALF_AHEAD, HALF_RIGHT = 0.35, 0.466


class Flight:
    """A helicopter at a height with first-order lag and wind, over a target; it flies by what the kernel commands."""

    def __init__(self, lag_s: float = 0.5, wind_mps: Any = (0.0, 0.0), heading_rad: float = 0.0, **changes: Any):
        self.kernel = PredictiveController.KERNEL
        self.parameters = self.kernel.record(dataclasses.replace(PredictiveParameters(), **changes))
        self.memory = np.zeros(1, self.kernel.memory)
        self.follows, self.wind_mps, self.heading_rad = 1.0 - np.exp(-1.0 / RATE_HZ / lag_s), wind_mps, heading_rad
        self.place_m, self.velocity_mps, self.frame = np.zeros(2), np.zeros(2), 0

    def own(self, vector: Any) -> NDArray[np.float64]:
        """Return a vector of the world ahead and to the right; it is its own inverse."""
        c, s = np.cos(self.heading_rad), np.sin(self.heading_rad)
        return np.array([c * vector[0] + s * vector[1], s * vector[0] - c * vector[1]])

    def step(self, target_m: Any, target_mps: Any = (0.0, 0.0), tilt: Any = (0.0, 0.0)) -> NDArray[np.float64]:
        """Fly for a frame; return the command (4,)."""
        belief = np.zeros(1, BELIEF)
        ahead_m, goes_mps = self.own(np.subtract(target_m, self.place_m)), self.own(target_mps)
        given = {
            "frames": self.frame + 1.0, "known": 1.0, "spread_m": 0.5, "heading_rad": self.heading_rad,
            "carrier_x_m": self.place_m[0], "carrier_y_m": self.place_m[1], "height_m": HEIGHT_M,
            "half_ahead_m": HALF_AHEAD * HEIGHT_M, "half_right_m": HALF_RIGHT * HEIGHT_M,
            "axis_ahead_m": tilt[0] * HEIGHT_M, "axis_right_m": tilt[1] * HEIGHT_M,
            "ahead_m": ahead_m[0], "right_m": ahead_m[1],
            "velocity_ahead_mps": goes_mps[0], "velocity_right_mps": goes_mps[1],
        }  # fmt: skip
        for name, value in given.items():
            belief[name] = value
        out = np.full((1, 4), np.nan)
        self.kernel.steer(belief, self.parameters, self.memory, np.array([self.frame / RATE_HZ]), out)
        wanted_mps = self.own(out[0, :2]) + self.wind_mps
        self.velocity_mps = self.velocity_mps + self.follows * (wanted_mps - self.velocity_mps)
        self.place_m = self.place_m + self.velocity_mps / RATE_HZ
        self.frame += 1
        return out[0]


def test_a_target_at_rest_is_centred() -> None:
    flight = Flight()
    for _ in range(150):
        flight.step((12.0, -9.0))
    np.testing.assert_allclose(flight.place_m, [12.0, -9.0], atol=0.2)
    assert np.abs(flight.velocity_mps).max() < 0.1


@pytest.mark.parametrize("heading_rad", [0.0, 2.0])
def test_a_constant_wind_leaves_no_steady_error(heading_rad: float) -> None:
    flight, wind_mps = Flight(wind_mps=np.array([6.0, -3.0]), heading_rad=heading_rad), np.array([6.0, -3.0])
    for _ in range(300):
        flight.step((12.0, -9.0))
    np.testing.assert_allclose(flight.place_m, [12.0, -9.0], atol=0.2)
    np.testing.assert_allclose(flight.memory["wind_mps"][0], wind_mps, atol=0.2)


def test_a_target_that_drives_on_is_flown_along_with() -> None:
    flight, target_mps = Flight(), np.array([9.0, -4.0])
    for frame in range(200):
        flight.step(target_mps * frame / RATE_HZ, target_mps)
    np.testing.assert_allclose(flight.velocity_mps, target_mps, atol=0.1)
    np.testing.assert_allclose(flight.place_m, target_mps * 200 / RATE_HZ, atol=1.0)


def test_another_lag_than_assumed_still_comes_to_rest() -> None:
    for lag_s in (0.25, 0.9):
        flight = Flight(lag_s=lag_s)
        for _ in range(300):
            flight.step((12.0, -9.0))
        np.testing.assert_allclose(flight.place_m, [12.0, -9.0], atol=0.5)


@given(seed=st.integers(0, 1000))
def test_mirrored_flights_have_mirrored_commands(seed: int) -> None:
    rng = np.random.default_rng(seed)
    target_m, target_mps, tilt = rng.normal(0, 15, 2), rng.normal(0, 8, 2), rng.normal(0, 0.4, 2)
    flights = Flight(), Flight()
    for frame in range(12):
        share = frame / 12
        left, right = (
            flight.step(mirror * target_m, mirror * target_mps, (share * tilt[0], -side * share * tilt[1]))
            for flight, mirror, side in zip(flights, ((1, 1), (1, -1)), (1, -1), strict=True)
        )
        np.testing.assert_allclose(right, left * [1, -1, 1, -1], atol=1e-6)
    assert np.abs(left[:2]).max() > 0.1


def test_in_a_swing_the_target_stays_in_a_picture_that_would_lose_it() -> None:
    """The optical axis swings ahead by more than half the picture in two seconds, stays, and swings back."""
    t = np.clip(np.arange(150) / RATE_HZ - 2.0, 0.0, None)
    smooth = [np.clip(each / 2.0, 0.0, 1.0) for each in (t, t - 4.0)]
    rise, fall = (10 * x**3 - 15 * x**4 + 6 * x**5 for x in smooth)
    tilts = 0.8 * (rise - fall)
    flight, places, hovering = Flight(), [], []
    for tilt in tilts:
        flight.step((0.0, 0.0), tilt=(tilt, 0.0))
        for kept, here_m in ((places, -flight.place_m[0]), (hovering, 0.0)):
            kept.append(abs(in_picture(here_m / HEIGHT_M, 0.0, *tilted_axes(tilt, 0.0))[1]) / HALF_AHEAD)
    assert np.mean(np.array(hovering) > 1.0) > 0.3
    assert np.mean(np.array(places) > 1.0) < 0.02


def test_commands_change_no_faster_than_it_says() -> None:
    flight = Flight(slew_mps2=20.0)
    commands = np.array([flight.step((200.0, -150.0))[:2] for _ in range(30)])
    assert np.linalg.norm(np.diff(commands, axis=0), axis=1).max() <= 20.0 / RATE_HZ + 1e-9
    assert np.linalg.norm(commands, axis=1).max() == pytest.approx(25.0, abs=0.5)


def test_the_response_is_that_of_the_differential_equation() -> None:
    rng, lag_s, step_s = np.random.default_rng(0), 0.6, 0.07
    knots_mps, own_mps = rng.normal(0, 5, _KNOTS + 1), 3.0
    knots_s = np.arange(_KNOTS + 1) * step_s * _STEPS / _KNOTS

    def rates(t: float, state: NDArray[np.float64]) -> list[float]:
        return [state[1], (np.interp(t, knots_s, knots_mps) - state[1]) / lag_s]

    times_s = step_s * np.arange(1, _STEPS + 1)
    true = solve_ivp(rates, (0.0, times_s[-1]), [0.0, own_mps], t_eval=times_s, max_step=0.005).y[0]
    np.testing.assert_allclose(responses(lag_s, step_s) @ [*knots_mps, own_mps], true, atol=0.02)


@given(seed=st.integers(0, 1000), count=st.integers(1, 12))
def test_the_solver_agrees_with_numpy(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    root, values = rng.normal(size=(count, count)), rng.normal(size=count)
    matrix = root @ root.T + 0.1 * np.eye(count)
    expected = np.linalg.solve(matrix, values)
    solve_symmetric(np.tril(matrix), values)
    np.testing.assert_allclose(values, expected, rtol=1e-6, atol=1e-9)
