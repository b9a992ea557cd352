"""What is learnt of the swings of a helicopter's camera."""

from __future__ import annotations

import json

import numpy as np
import pytest
from numpy.typing import NDArray

from tools.learn import swings
from tools.learn.swings import AHEAD, FORECAST_PATH, forecast_errors, learn_swings, lessons
from trackers.controllers.swing_forecast import HISTORY, read_forecast, swing_forecast


def flights(count: int, frames: int = 90) -> NDArray[np.float64]:
    """Return tilts (E, T, 2) that swing to and fro, each flight in a direction of its own."""
    rng = np.random.default_rng(0)
    phase, period = rng.uniform(0, 6, (count, 1)), rng.uniform(50, 70, (count, 1))
    size, direction = rng.uniform(0.3, 0.8, (count, 1)), rng.uniform(-np.pi, np.pi, (count, 1))
    along = size * np.sin(phase + 2 * np.pi * np.arange(frames) / period)
    return np.stack([along * np.cos(direction), along * np.sin(direction)], axis=-1)


def test_lessons_are_in_the_axes_of_the_latest_tilt() -> None:
    tilts = flights(1)
    seen, follows = lessons(tilts)
    latest = tilts[0, HISTORY : HISTORY + len(seen)]
    far = np.hypot(*latest.T)
    np.testing.assert_allclose(seen[:, 0], far)
    ahead = latest / far[:, None]
    changes = tilts[0, np.arange(len(seen))[:, None] + HISTORY + AHEAD[:3]] - latest[:, None]
    np.testing.assert_allclose(follows[:, :3, 0], (changes * ahead[:, None]).sum(axis=-1), atol=1e-12)
    # The swing is along a line, so nothing goes across.
    np.testing.assert_allclose(follows[..., 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(seen[:, 2::2], 0.0, atol=1e-12)


@pytest.mark.heavy
def test_what_is_learnt_foresees_swings_better_than_that_they_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(swings, "_ROUNDS", 300)
    learnt = learn_swings(flights(12), 8)
    errors = forecast_errors(learnt, flights(20)[12:])
    assert (errors["forecast"][:8] < 0.5 * errors["stays"][:8]).all()


def test_the_shipped_network_is_the_one_in_the_tool_s_file() -> None:
    content = json.loads(FORECAST_PATH.read_text())
    shipped = swing_forecast()
    for name, numbers in zip(shipped._fields, read_forecast(content), strict=True):
        np.testing.assert_array_equal(getattr(shipped, name), numbers)
    np.testing.assert_allclose(shipped.at_s, AHEAD * shipped.step_s, rtol=1e-4)
    assert content["command"].startswith("python -m tools learn-swings --seeds 0:256")
