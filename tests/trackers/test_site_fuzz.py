"""Hostile pictures before trackers of a site, with a background and poses as hostile as they."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.trackers.drawn_harbour import VIEW
from tests.trackers.hostile import hostile_sequence
from trackers.estimate_check import check_tracks
from trackers.registry import entry
from trackers.types import EgoPose, Observation

FRAMES = 24
NAMES = ("eigen_swarm", "harbour_mog2", "harbour_knn", "harbour_median", "harbour_blind")


def sequence(seed: int, posed: bool) -> list[Observation]:
    """Return observations, each with the pose of a camera over a harbour if ``posed``."""
    made = hostile_sequence(seed, stereo=False, frames=2 * FRAMES).observations
    return [replace(each, ego=EgoPose(VIEW.T_world_camera)) for each in made] if posed else made


@pytest.mark.parametrize("posed", [True, False])
@pytest.mark.parametrize("seed", [1, 11])
@pytest.mark.parametrize("name", NAMES)
def test_no_picture_and_no_background_makes_a_tracker_raise(name: str, seed: int, posed: bool) -> None:
    observations = sequence(seed, posed)
    tracker = entry(name).create(np.random.default_rng(seed))
    tracker.start(observations[:FRAMES], observations[0].camera)
    for observation in observations[FRAMES:]:
        check_tracks(tracker.update(observation))
