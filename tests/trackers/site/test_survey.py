"""Which pose a site's trackers take."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_harbour import CAMERA, VIEW, looking
from trackers.site.survey import survey
from trackers.site.volume import WatchedVolume
from trackers.types import EgoPose, Observation

SKYWARD = looking(np.array([0.0, 0, 20]), np.array([50.0, 0, 60]))


def picture(pose: NDArray[np.float64] | None) -> Observation:
    return Observation(np.zeros((2, 2, 3), np.uint8), 0.0, CAMERA, ego=None if pose is None else EgoPose(pose))


def test_the_first_pose_that_can_be_used_is_taken() -> None:
    poses = [None, np.full((4, 4), np.nan), SKYWARD, VIEW.T_world_camera, looking(np.array([0.0, 0, 9]), np.ones(3))]
    site = survey(WatchedVolume(), CAMERA, [picture(pose) for pose in poses])
    assert site is not None
    np.testing.assert_array_equal(site.view.T_world_camera, VIEW.T_world_camera)
    np.testing.assert_allclose(site.volume.centre_m, [0.0, 0.0, 0.5], atol=1e-9)


@pytest.mark.parametrize("poses", [[], [None], [SKYWARD]])
def test_without_a_pose_there_is_no_site(poses: list[NDArray[np.float64] | None]) -> None:
    assert survey(WatchedVolume(), CAMERA, [picture(pose) for pose in poses]) is None
