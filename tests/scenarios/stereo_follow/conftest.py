"""An episode of ``stereo-follow`` that is lived through once for all tests that look at it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from scenarios.catalog import scenario
from scenarios.scenario import Frame
from scenarios.stereo_follow.episode import StereoFollowEpisode

FRAMES = 60
SEED = 3
"""He walks through the hall to the door, and somebody crosses before him."""


@dataclass(frozen=True)
class Lived:
    """A whole episode, and its frames."""

    episode: StereoFollowEpisode
    frames: list[Frame]


@pytest.fixture(scope="session")
def lived() -> Iterator[Lived]:
    """A quick episode, all of it."""
    episode = scenario("stereo-follow").episode("quick", SEED)
    yield Lived(episode, [episode.step() for _ in range(FRAMES)])
    episode.close()
