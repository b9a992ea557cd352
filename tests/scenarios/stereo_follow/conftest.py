"""An episode of ``stereo-follow``, recorded once for all tests that use it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from scenarios.catalog import scenario
from scenarios.scenario import Frame
from scenarios.stereo_follow.scenario import StereoFollowEpisode

FRAMES = 60
SEED = 163
"""The target goes round a corner in the hall, and another person crosses in front of it."""


@dataclass(frozen=True)
class Recorded:
    """A whole episode and its frames."""

    episode: StereoFollowEpisode
    frames: list[Frame]


@pytest.fixture(scope="session")
def recorded() -> Iterator[Recorded]:
    """Yield a whole quick episode."""
    episode = scenario("stereo-follow").episode("quick", SEED)
    yield Recorded(episode, [episode.step() for _ in range(FRAMES)])
    episode.close()
