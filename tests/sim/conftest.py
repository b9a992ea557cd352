"""Fixtures of several tests of the simulator."""

from __future__ import annotations

import numpy as np
import pytest

from sim.world import World
from tests.sim.demo_scene import build_town


@pytest.fixture(scope="module")
def town() -> World:
    """Return a town of 30 houses; a module's tests share it."""
    return build_town(np.random.default_rng(5), extent_m=200, houses=30, cars=12, trees=20)
