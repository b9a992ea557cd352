"""The first editions of two scenes give what they gave before there were second ones: flights, drives and pictures.

The values were written by the code as it was before.
"""

from __future__ import annotations

import hashlib

import numpy as np

from scenarios.road_town.scenario import ROAD_TOWN_V1
from scenarios.stereo_follow.scenario import STEREO_FOLLOW_V1

SEED, EVERY_FRAMES = 3, 30


def test_flight_and_first_picture_of_road_town_v1() -> None:
    episode = ROAD_TOWN_V1.episode("quick", SEED)
    poses = episode.plan.camera_poses[::EVERY_FRAMES]
    expected = (
        (-32.437843, -2.33717, 79.635117, 0.021567, -0.002998, -0.999763),
        (-36.5196, 9.179105, 79.635117, -0.116215, 0.412695, -0.903425),
        (-39.590837, 12.26032, 79.635117, 0.040306, 0.000692, -0.999187),
        (-45.22619, 10.1548, 79.635117, 0.043403, 0.030504, -0.998592),
    )
    np.testing.assert_allclose(np.column_stack([poses[:, :3, 3], poses[:, :3, 2]]), expected, rtol=0, atol=1e-6)
    picture = episode.step().observation.image_rgb
    episode.close()
    assert hashlib.sha256(picture.tobytes()).hexdigest() == (
        "9cbd4ca09b7ca86f4a9170958d3f1a0af59b79d469926967a7a666a3ba785548"
    )


def test_drive_and_first_picture_of_stereo_follow_v1() -> None:
    episode = STEREO_FOLLOW_V1.episode("quick", SEED)
    crowd = episode.plan.crowd
    path = np.column_stack([crowd.robot_m, crowd.robot_heading_rad])[::EVERY_FRAMES]
    expected = (
        (5.897145, 5.809835, -0.146125),
        (7.319104, 5.616327, -0.107406),
    )
    np.testing.assert_allclose(path, expected, rtol=0, atol=1e-6)
    picture = episode.step().observation.image_rgb
    episode.close()
    assert hashlib.sha256(picture.tobytes()).hexdigest() == (
        "cb8255f4f0890cc59c907e9c4f75d9cfa4e9e5487f133391a8c18032da37b7eb"
    )
