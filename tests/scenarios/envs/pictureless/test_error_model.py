"""Drawn answers of a tracker have the distribution of its model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from scenarios import catalog
from scenarios.envs.pictureless.episode_state import ACROSS, ALONG, EPISODE_STATE
from scenarios.envs.pictureless.error_kernel import error_record, start_tracker, track
from scenarios.envs.pictureless.error_model import LOST, TRACKING, WRONG, error_model, model_from_json
from scenarios.envs.pictureless.poses import turn_down
from tests.scenarios.envs.pictureless.hand_made import model

CAMERA = np.array([500.0, 320.0, 240.0])
SIZE_M = np.array([4.6, 1.9, 1.5])


@njit
def track_all(states: Any, errors: Any, size_m: Any, camera: Any, rng: Any) -> None:
    for k in range(len(states)):
        track(states[k], errors[0], size_m, 0.5, camera, rng)


@njit
def start_all(states: Any, rng: Any) -> None:
    for k in range(len(states)):
        start_tracker(states[k], rng)
        states[k].camera_m[2] = 60.0
        turn_down(states[k].R, 0.0, 0.0, 0.0)


def said_m(states: np.ndarray) -> np.ndarray:
    """Return the places (B, 2) of the answers for a camera straight above the origin."""
    offset_px = states["estimate_px"] - CAMERA[1:]
    return np.column_stack([-offset_px[:, 1], -offset_px[:, 0]]) * (60.0 - 0.75) / CAMERA[0]


@pytest.mark.heavy
def test_errors_have_the_model_s_mean_variance_and_memory() -> None:
    rng, states = np.random.default_rng(2), np.zeros(20_000, EPISODE_STATE)
    errors = error_record(model())
    start_all(states, rng)
    states["visible"] = 1.0
    track_all(states, errors, SIZE_M, CAMERA, rng)
    before = states["latent"].copy()
    track_all(states, errors, SIZE_M, CAMERA, rng)
    assert (states["mode"] == TRACKING).all()
    places_m = said_m(states)
    np.testing.assert_allclose(places_m.mean(axis=0), 0.0, atol=0.01)
    # Quantiles beyond 2.4 deviations are cut.
    np.testing.assert_allclose(places_m.std(axis=0), 0.3, rtol=0.02)
    for latent in (ALONG, ACROSS):
        assert np.corrcoef(before[:, latent], states["latent"][:, latent])[0, 1] == pytest.approx(0.5, abs=0.02)
    states["visible"] = 0.0
    for _ in range(40):
        track_all(states, errors, SIZE_M, CAMERA, rng)
    assert (states["mode"] == LOST).all()
    assert (states["unsure_frames"] == 40).all()
    np.testing.assert_allclose(said_m(states).std(axis=0), 4.0, rtol=0.03)
    assert (states["probability"] == 0.1).all()


@pytest.mark.heavy
def test_modes_follow_their_rates() -> None:
    rates = model().rates.copy()
    rates[0, :, :, TRACKING] = [0.9, 0.08, 0.02]
    rng, states = np.random.default_rng(2), np.zeros(40_000, EPISODE_STATE)
    start_all(states, rng)
    states["visible"] = 1.0
    track_all(states, error_record(model(rates=rates)), SIZE_M, CAMERA, rng)
    shares = np.bincount(states["mode"], minlength=3) / len(states)
    np.testing.assert_allclose(shares, [0.9, 0.08, 0.02], atol=0.005)
    wrong = states["mode"] == WRONG
    np.testing.assert_allclose(np.linalg.norm(said_m(states[wrong]), axis=1).mean(), 10 * np.sqrt(2), rtol=0.03)


def test_what_is_not_known_is_not_said() -> None:
    known_share = model().known_share.copy()
    known_share[LOST] = 0.3
    rng, states = np.random.default_rng(2), np.zeros(20_000, EPISODE_STATE)
    start_all(states, rng)
    track_all(states, error_record(model(known_share=known_share)), SIZE_M, CAMERA, rng)
    assert states["known"].mean() == pytest.approx(0.3, abs=0.015)


def test_text_and_back() -> None:
    made = model(made={"runs": 3})
    read = model_from_json(made.to_json())
    assert read.made == {"runs": 3}
    np.testing.assert_allclose(read.error_m, made.error_m, rtol=1e-4)
    np.testing.assert_array_equal(read.rates, made.rates)


PICTURELESS = [each for each in catalog.envs().values() if catalog.scenario(each[0]).pictureless]


@pytest.mark.parametrize(("scenario", "tracker"), PICTURELESS)
def test_every_env_s_tracker_has_a_model(scenario: str, tracker: str) -> None:
    shipped = error_model(scenario, tracker)
    assert (shipped.scenario, shipped.tracker) == (scenario, tracker)
    np.testing.assert_allclose(shipped.rates.sum(axis=-1), 1.0, atol=1e-3)
    assert (np.diff(shipped.error_m, axis=-1) >= 0).all()
    assert (np.abs(shipped.kept) < 1.0).all()
    assert shipped.made["runs"]


def test_unfit_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="kept: expected finite numbers"):
        model(kept=np.zeros((2, 8)))
    with pytest.raises(ValueError, match=r"tracker: expected one with a model of its errors in .*got 'hold'"):
        error_model(next(iter(catalog.envs().values()))[0], "hold")
