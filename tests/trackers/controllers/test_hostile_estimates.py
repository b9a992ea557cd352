"""A controller gives finite commands for any estimate that passes ``check_estimate``, with any measured pose."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.hostile import hostile_sequence
from trackers.controllers.catalogue import controllers
from trackers.estimate_check import check_estimate
from trackers.types import Estimate

_SEQUENCES, _FRAMES = 12, 25


def hostile_estimate(rng: np.random.Generator, width: int, height: int) -> Estimate:
    """Return an estimate that keeps the contract but is often absurd."""

    def numbers(*shape: int) -> NDArray[np.float64]:
        return rng.normal(0.5, 1.0, shape) * rng.choice([0.0, 1e-9, width, height, 1e12, 1e300])

    def or_none(value: object) -> object:
        return value if rng.random() < 0.7 else None

    silent = rng.random() < 0.3
    position_px = np.full(2, np.nan) if silent else numbers(2)
    box = np.sort(numbers(4)[[0, 2, 1, 3]].reshape(2, 2), axis=0).ravel()
    count = int(rng.integers(1, 30))
    particles_px, weights = numbers(count, 2), rng.random(count)
    particles_px[rng.random(count) < 0.2] = rng.choice([np.nan, np.inf])
    weights *= rng.random(count) < rng.choice([0.1, 1.0])
    weights[0] += 1e-9
    root = numbers(2, 2)
    root = root if np.abs(root).max() < 1e140 else np.sqrt(np.abs(root))
    posterior = or_none(particles_px)
    return Estimate(
        position_px,
        or_none(np.full(4, np.nan) if silent else box),
        heading_rad=or_none(np.nan if silent else float(rng.uniform(-9, 9))),
        in_view_probability=or_none(float(rng.random())),
        particles_px=posterior,
        weights=None if posterior is None else or_none(weights / weights.sum()),
        covariance_px=or_none(root @ root.T),
        depth_m=or_none(float(rng.choice([1e-300, 0.01, 3.0, 1e300]))),
    )


def hostile_answers(seed: int) -> Iterator[tuple]:
    """Yield observations and estimates that keep the contract."""
    rng = np.random.default_rng(seed)
    for observation in hostile_sequence(seed, stereo=False, frames=_FRAMES).observations:
        estimate = hostile_estimate(rng, observation.camera.width_px, observation.camera.height_px)
        check_estimate(estimate)
        yield observation, estimate


@pytest.mark.heavy
@pytest.mark.parametrize(
    "entry",
    # An oracle does not look at estimates.
    [entry for carrier in ("helicopter", "robot") for entry in controllers(carrier).values() if entry.role != "oracle"],
    ids=lambda entry: f"{entry.carrier} {entry.name}",
)
def test_a_controller_steers_by_any_estimate(entry):
    for seed in range(_SEQUENCES):
        controller = entry.create()
        for observation, estimate in hostile_answers(seed):
            command = controller.command(observation, estimate)
            assert np.isfinite(dataclasses.astuple(command)).all(), (seed, observation.time_s, estimate, command)
