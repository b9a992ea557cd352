"""Particles in the picture: the background carries them, matches weigh them, and leaps keep the books."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackers.mosaic_graph.picture_model import LOG_PRIOR, SPEED_X, VISIBLE, Glance, PictureModel
from trackers.particle_filter import ParticleFilter

_SIDE_PX = 20.0
_STILL = Glance(
    dt_s=0.05,
    unheld_s=0.05,
    motion=np.eye(3),
    picture_px=(400, 300),
    side_px=_SIDE_PX,
    reach_px=30.0,
    searched_px=np.array([[200.0, 150.0]]),
    found_px=np.array([[203.0, 148.0]]),
    log_ratios=np.array([3.0]),
)
_NOTHING = replace(_STILL, searched_px=np.empty((0, 2)), found_px=np.empty((0, 2)), log_ratios=np.empty(0))


def model(**changes: object) -> PictureModel:
    return PictureModel(**{"start_px": np.array([200.0, 150.0]), "side_px": _SIDE_PX, "miss_counts": True} | changes)


def states(count: int = 500, seed: int = 0) -> np.ndarray:
    return model().sample_initial(count, np.random.default_rng(seed))


@given(st.floats(-0.3, 0.3), st.floats(0.8, 1.25), st.floats(-40, 40), st.floats(-40, 40))
def test_the_background_carries_place_and_velocity(turn: float, zoom: float, x: float, y: float) -> None:
    c, s = zoom * np.cos(turn), zoom * np.sin(turn)
    motion = np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])
    before, still = states(20), model().carry(states(20), np.eye(3), 0.05)
    carried = model().carry(before, motion, 0.05)
    np.testing.assert_allclose(carried[:, :SPEED_X], still[:, :SPEED_X] @ motion[:2, :2].T + [x, y], atol=1e-8)
    # A similarity turns and stretches velocities as it does the picture.
    np.testing.assert_allclose(carried[:, SPEED_X:VISIBLE], still[:, SPEED_X:VISIBLE] @ motion[:2, :2].T, atol=1e-6)


def test_no_state_leaves_the_finite() -> None:
    motion = np.array([[1.4, 0.1, 300.0], [-0.1, 1.4, 200.0], [1e-3, 1e-3, 1.0]])
    now, rng = states(50), np.random.default_rng(0)
    for _ in range(200):
        now = model().predict(now, replace(_NOTHING, motion=motion), rng)
    assert np.isfinite(now).all()


def test_a_particle_at_a_match_weighs_more_and_a_searched_one_without_less() -> None:
    at, beside, out = (np.array([[x, y, 0.0, 0.0, 1.0, 0.0]]) for x, y in ((203, 148), (180, 170), (410, 150)))
    hidden = beside.copy()
    hidden[:, VISIBLE] = 0.0
    particles = np.vstack([states(), at, beside, out, hidden])
    logs = model().log_weights(particles, _STILL)[-4:]
    assert logs[0] > logs[2] > logs[1]
    np.testing.assert_allclose(logs[2:], 0.0)
    np.testing.assert_allclose(model(miss_counts=False).log_weights(particles, _STILL)[-3:], 0.0, atol=1e-3)


def test_a_leap_weighs_as_much_as_particles_that_are_spread_by_it() -> None:
    """Births stand for a share of the prior, a wide normal distribution, without a particle for each of its places."""
    found = replace(_STILL, found_px=np.array([[215.0, 140.0]]))
    count, rng = 20_000, np.random.default_rng(1)
    born = model().predict(states(count), found, rng)
    weights = np.exp(model().log_weights(born, found))
    leapt = born[:, LOG_PRIOR] != 0
    by_births = weights[leapt].sum() / count
    leap_px = _SIDE_PX * (1.0 + 3.0 * found.unheld_s)
    spread = np.zeros((400_000, born.shape[1]))
    spread[:, :SPEED_X] = born[~leapt, :SPEED_X].mean(axis=0) + rng.normal(0, leap_px, (len(spread), 2))
    spread[:, VISIBLE] = 1.0
    # The deviation of a match follows from the spacing of the particles: here from that of the others.
    brute = 0.0
    for part in np.array_split(spread, 20):
        both = np.vstack([born[~leapt], part])
        both[len(born[~leapt]) :, LOG_PRIOR] = 1e-9
        logs = model().log_weights(both, found)[len(born[~leapt]) :]
        brute += float(np.maximum(np.exp(logs) - 1.0, 0.0).sum()) / len(spread)
    assert by_births == pytest.approx(0.1 * brute, rel=0.35)


def test_a_camera_that_pans_with_the_target_teaches_its_velocity() -> None:
    """The target stands in the picture while the background runs by at a size of it a frame: so fast it moves."""
    motion = np.array([[1.0, 0.0, _SIDE_PX], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    particles = ParticleFilter(model(), 500, np.random.default_rng(0))
    seen = replace(_STILL, motion=motion, found_px=np.array([[200.0, 150.0]]))
    for _ in range(25):
        posterior = particles.step(seen)
    assert posterior.weights @ posterior.states[:, SPEED_X] == pytest.approx(-_SIDE_PX / _STILL.dt_s, rel=0.2)
    unseen = replace(_NOTHING, motion=motion)
    for _ in range(8):
        posterior = particles.step(unseen)
    middle = posterior.weights @ posterior.states[:, :SPEED_X]
    assert np.linalg.norm(middle - [200.0, 150.0]) < 2.0 * _SIDE_PX
