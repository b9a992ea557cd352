"""An episode that several tests look at."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.toy_scene.scenario import TOY_YARD, YardEpisode


@pytest.fixture
def episode() -> Iterator[YardEpisode]:
    """Yield an episode of two crates on a set path."""
    made = TOY_YARD.episode("quick", 1)
    yield made
    made.close()
