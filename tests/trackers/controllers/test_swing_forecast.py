"""The forecast of a swing turns and is mirrored with the tilts, stays at rest in still air, and beats simple ones."""

from __future__ import annotations

import json
from importlib import resources

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from trackers.controllers.swing_forecast import (
    FORECAST_FILE,
    HISTORY,
    TILT_FIELDS,
    TILTS,
    foresee,
    keep_tilt,
    kept_tilts,
    swing_forecast,
)

SOON_S = np.linspace(0.05, 3.0, 25)


def foreseen(tilts: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return expected tilts and their deviations for tilts (HISTORY + 1, 2), the latest first."""
    out, spreads = np.zeros((len(SOON_S), 2)), np.zeros(len(SOON_S))
    foresee(np.ascontiguousarray(tilts), swing_forecast(), SOON_S, out, spreads)
    return out, spreads


def swing(rng: np.random.Generator) -> NDArray[np.float64]:
    """Return tilts of a swing that is under way, the latest first."""
    to, share = rng.normal(0.0, 0.7, 2), np.linspace(0.0, rng.uniform(0.1, 0.9), HISTORY + 1)
    return (share[:, None] ** 2 * to + rng.normal(0.0, 0.002, (HISTORY + 1, 2)))[::-1]


@given(seed=st.integers(0, 10_000), turn_rad=st.floats(-4.0, 4.0), mirrored=st.booleans())
def test_it_turns_and_is_mirrored_with_the_tilts(seed: int, turn_rad: float, mirrored: bool) -> None:
    tilts = swing(np.random.default_rng(seed))
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    moved = np.array([[c, -s], [s, c]]) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    expected, spreads = foreseen(tilts)
    got, got_spreads = foreseen(tilts @ moved.T)
    np.testing.assert_allclose(got, expected @ moved.T, atol=1e-9)
    np.testing.assert_allclose(got_spreads, spreads, atol=1e-9)


def test_a_level_camera_is_expected_to_stay_about_level_and_less_surely_later() -> None:
    expected, spreads = foreseen(np.zeros((HISTORY + 1, 2)))
    assert np.abs(expected).max() < 0.15
    assert spreads[0] < 0.1 * spreads[-1]


def test_a_swing_under_way_goes_on_and_ends() -> None:
    """A motion of the tilt to 0.9 in two seconds with the least jerk, seen for its first 0.8 s."""
    at_s = np.concatenate([12 / 15 - np.arange(HISTORY + 1) / 15, 12 / 15 + SOON_S])
    share = np.clip(at_s / 2.0, 0.0, 1.0)
    whole = 0.9 * (10 * share**3 - 15 * share**4 + 6 * share**5)
    seen, after = whole[: HISTORY + 1], whole[HISTORY + 1 :]
    expected, _ = foreseen(np.stack([seen, np.zeros_like(seen)], axis=1))
    soon = SOON_S <= 1.6
    assert np.abs(expected[soon, 0] - after[soon]).max() < 0.15
    straight = seen[0] + 15 * (seen[0] - seen[1]) * SOON_S
    assert np.abs(straight - after)[soon].max() > 0.3


def test_the_shipped_errors_are_below_those_of_a_tilt_that_stays() -> None:
    content = json.loads(resources.files("trackers.controllers").joinpath(FORECAST_FILE).read_text())
    assert (np.array(content["error"]) < 0.8 * np.array(content["error_if_it_stays"])).all()
    assert "--seeds 0:256 --fresh 1000:1128" in content["command"]


@pytest.mark.parametrize("rate_hz", [7.5, 15.0, 20.0, 30.0, 60.0])
def test_tilts_are_kept_on_the_network_s_own_clock(rate_hz: float) -> None:
    memory = np.zeros(1, np.dtype(TILT_FIELDS, align=True))
    count, step_s = 60, swing_forecast().step_s
    for k in range(count):
        keep_tilt(memory[0], 0.01 * k / rate_hz, -0.02 * k / rate_hz, 5.0 + k / rate_hz)
    out = np.zeros((HISTORY + 1, 2))
    kept_tilts(memory[0], step_s, out)
    oldest_s = (count - TILTS) / rate_hz
    at_s = np.maximum((count - 1) / rate_hz - step_s * np.arange(HISTORY + 1), oldest_s)
    np.testing.assert_allclose(out, at_s[:, None] * [0.01, -0.02], atol=1e-12)


def test_before_the_first_picture_the_first_tilt_stood() -> None:
    memory = np.zeros(1, np.dtype(TILT_FIELDS, align=True))
    for k in range(2):
        keep_tilt(memory[0], 0.1 + 0.1 * k, 0.3, k / 15)
    out = np.zeros((HISTORY + 1, 2))
    kept_tilts(memory[0], 1 / 15, out)
    np.testing.assert_allclose(out[:, 0], [0.2] + HISTORY * [0.1], atol=1e-12)
    np.testing.assert_allclose(out[:, 1], 0.3, atol=1e-12)
