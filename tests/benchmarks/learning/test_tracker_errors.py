"""A model fitted to runs of a known model equals it."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.learning.tracker_errors import RUN, errors_in, fit
from scenarios.envs.pictureless.episode_state import ACROSS, ALONG
from scenarios.envs.pictureless.error_model import CUT, LOST, PLAIN, TRACKING, UNSEEN, ErrorModel
from scenarios.envs.pictureless.poses import camera_numbers
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.road_town.flight import HELICOPTER
from tests.scenarios.envs.pictureless.hand_made import FRAMES, SETTINGS, bank, model


def runs_of(known: ErrorModel, count: int) -> list[np.ndarray]:
    """Return runs (T,) of a helicopter that hovers, as the rendered env would have logged them."""
    envs = PicturelessVectorEnv(count, **SETTINGS | {"bank": bank(), "model": known})
    envs.reset(seed=3)
    runs, camera = np.zeros((count, FRAMES - 1), RUN), camera_numbers(envs._world.cameras(envs.states[0])[0].camera)
    for frame in range(FRAMES - 1):
        if frame > 0:
            envs.step(np.zeros((count, 4)))
        states, row = envs.states, runs[:, frame]
        row["T_world_camera"] = np.concatenate([states["R"], states["camera_m"][:, :, None]], axis=2)
        row["place_m"], row["heading_rad"] = states["target_m"], states["target_rad"]
        row["camera"], row["size_m"] = camera, [4.6, 1.9, 1.5]
        row["estimate_px"] = np.where(states["known"][:, None] > 0, states["estimate_px"], np.nan)
        row["visible_fraction"], row["out"] = states["visible"], states["visible"] == 0.0
        row["in_view"], row["sighting"] = states["in_view"] > 0, envs.sightings
    return list(runs)


@pytest.fixture(scope="module")
def known() -> ErrorModel:
    """A tracker that is sometimes lost while its target is plain to see, and finds it again."""
    rates = model().rates.copy()
    rates[PLAIN, :, :, TRACKING], rates[PLAIN, :, :, LOST] = [0.95, 0.05, 0.0], [0.2, 0.8, 0.0]
    return model(rates=rates)


@pytest.fixture(scope="module")
def fitted(known: ErrorModel) -> ErrorModel:
    return fit("unknown", "road-town-v2", runs_of(known, 200), {"runs": ["a"]})


@pytest.mark.heavy
def test_rates_are_found_again(fitted: ErrorModel, known: ErrorModel) -> None:
    counted = fitted.rates[PLAIN, 4, 0]
    np.testing.assert_allclose(counted[TRACKING], [0.95, 0.05, 0.0], atol=0.02)
    np.testing.assert_allclose(counted[LOST], [0.2, 0.8, 0.0], atol=0.04)
    assert fitted.rates[UNSEEN, 2, 0, TRACKING, LOST] > 0.8
    np.testing.assert_allclose(fitted.rates.sum(axis=-1), 1.0)


def test_distributions_are_found_again(fitted: ErrorModel, known: ErrorModel) -> None:
    for axis in range(2):
        tracked, lost = fitted.error_m[axis, TRACKING, PLAIN], fitted.error_m[axis, LOST, 1]
        np.testing.assert_allclose(tracked, known.error_m[axis, TRACKING, PLAIN], atol=0.05)
        np.testing.assert_allclose(lost, known.error_m[axis, LOST, 1], atol=1.6)
        # Mean and variance, as the quantiles at even steps of a normal distribution's axis weigh them.
        assert tracked.mean() == pytest.approx(0.0, abs=0.03)
        assert tracked.std() == pytest.approx(known.error_m[axis, TRACKING, PLAIN].std(), rel=0.1)
    np.testing.assert_allclose(fitted.spread_m[TRACKING, PLAIN], known.spread_m[TRACKING, PLAIN], rtol=0.1)
    np.testing.assert_allclose(fitted.kept[:2, [ALONG, ACROSS]], known.kept[:2, [ALONG, ACROSS]], atol=0.1)
    assert fitted.known_share[LOST].min() == 1.0
    np.testing.assert_allclose(fitted.probability[TRACKING, 1], 0.95)
    np.testing.assert_allclose(fitted.probability[LOST, 1], 0.1)
    np.testing.assert_allclose(fitted.length[TRACKING], 1.0, atol=0.15)


def test_modes_and_conditions_are_what_was_lived(known: ErrorModel) -> None:
    [run] = runs_of(known, 1)
    found = errors_in(run, HELICOPTER, 3.0)
    assert len(found) == len(run) - 1
    tilted = found[30:48]
    assert (tilted["condition"] == UNSEEN).all()
    assert (tilted["mode"][1:] == LOST).all()
    assert set(found["condition"][:28]) <= {PLAIN, CUT}
    assert found["unsure_frames"][47] >= 17


def test_nothing_is_not_enough() -> None:
    with pytest.raises(ValueError, match="runs: expected at least one"):
        fit("unknown", "road-town-v2", [], {})
