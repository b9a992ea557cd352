from __future__ import annotations

import numpy as np
import pytest

from trackers.types import CameraModel, EgoPose, Observation


def test_an_observations_arrays_are_read_only_views_and_copies_of_them_are_not() -> None:
    left, right, pose = np.zeros((4, 6, 3), np.uint8), np.ones((4, 6, 3), np.uint8), np.eye(4)
    told = Observation(left, 0.0, CameraModel(6, 4, 5.0), ego=EgoPose(pose), right_rgb=right)
    assert told.right_rgb is not None
    assert told.ego is not None
    for given, shown in ((left, told.image_rgb), (right, told.right_rgb), (pose, told.ego.T_world_camera)):
        assert np.shares_memory(given, shown)
        assert given.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            shown[0] = 7
        shown.copy()[0] = 7
