"""A short fuzz of every tracker; ``python -m tests.trackers.fuzz`` is the long one."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from tests.trackers.fuzz import SEQUENCE_FRAMES, answers, is_stereo, names
from tests.trackers.hostile import Sequence, hostile_sequence, tipping_sequence
from trackers.registry import entry

_SEEDS = (4, 6, 11, 14)


@lru_cache
def _sequence(seed: int, stereo: bool) -> Sequence:
    return hostile_sequence(seed, stereo=stereo, frames=SEQUENCE_FRAMES)


@pytest.mark.heavy
@pytest.mark.parametrize("name", names())
def test_no_picture_makes_a_tracker_raise(name):
    frames = 0
    for seed in _SEEDS:
        for stereo in is_stereo(entry(name)):
            sequence = _sequence(seed, stereo)
            for _ in answers(entry(name), sequence):
                pass
            frames += len(sequence.observations)
    assert frames >= 100


@pytest.mark.heavy
@pytest.mark.parametrize(("ego", "is_silent"), [("measured", True), ("never", False)])
def test_a_camera_that_tips_over_the_horizon_gives_nan_on_a_map_alone(ego, is_silent):
    finite = [
        np.isfinite(estimate.position_px).all() for estimate in answers(entry("mosaic_graph_pf"), tipping_sequence(ego))
    ]
    assert all(finite[:20])
    assert all(finite[40:50]) != is_silent
    assert finite[-1]
