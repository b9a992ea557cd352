from __future__ import annotations

import numpy as np
import pytest

from trackers.types import CameraModel, EgoPose, Observation


def test_an_observations_arrays_are_read_only_views_and_copies_of_them_are_not() -> None:
    left, right, pose = np.zeros((4, 6, 3), np.uint8), np.ones((4, 6, 3), np.uint8), np.eye(4)
    observation = Observation(left, 0.0, CameraModel(6, 4, 5.0), ego=EgoPose(pose), right_rgb=right)
    assert observation.right_rgb is not None
    assert observation.ego is not None
    for given, shown in (
        (left, observation.image_rgb),
        (right, observation.right_rgb),
        (pose, observation.ego.T_world_camera),
    ):
        assert np.shares_memory(given, shown)
        assert given.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            shown[0] = 7
        shown.copy()[0] = 7
