"""The answer straight ahead, converted back to metres."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.blind.dead_reckoning import AheadParameters, StraightAhead
from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.types import CameraModel, Observation


def test_it_is_always_as_far_straight_ahead() -> None:
    camera = CameraModel(640, 480, 500.0, baseline_m=0.12)
    tracker = StraightAhead(AheadParameters(2.5), np.random.default_rng(0))
    estimate = tracker.update(Observation(np.empty((0, 0, 3), np.uint8), 0.0, camera))
    assert estimate.depth_m is not None
    assert Mounting.level(1.2).place_at(estimate.position_px, estimate.depth_m, camera) == pytest.approx(
        [2.5, 0.0, 1.2]
    )
