"""The extent of truth does not change its values."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.catalog import scenario
from tests.scenarios.stereo_follow.conftest import SEED, Recorded


@pytest.mark.heavy
def test_less_truth_is_the_same_where_it_is(recorded: Recorded):
    less = scenario("stereo-follow").episode("quick", SEED, truth="target")
    for whole in recorded.frames[:8]:
        frame = less.step()
        np.testing.assert_array_equal(frame.observation.image_rgb, whole.observation.image_rgb)
        np.testing.assert_array_equal(frame.observation.right_rgb, whole.observation.right_rgb)
        for name in ("box_xyxy", "position_px", "T_world_object", "instance_map", "illuminance_lx"):
            np.testing.assert_array_equal(getattr(frame.truth, name), getattr(whole.truth, name))
        for name in ("visible_fraction", "occluder", "state", "side", "frames_since_exit"):
            assert getattr(frame.truth, name)[0] == getattr(whole.truth, name)[0]
        for name in ("near_person", "light_event"):
            assert getattr(frame.truth, name) == getattr(whole.truth, name)
        assert np.isnan(frame.truth.visible_fraction[1:]).all()
    less.close()
