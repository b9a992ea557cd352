"""The first edition of the road scene gives what it gave before there was a second one: flights and pictures.

The values were written by the code as it was before. Hashes are of places in millionths of a metre or radian, for the
last bits of sines depend on the processor.
"""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.road_town.flight import Helicopter
from scenarios.road_town.plan import Plan as RoadPlan
from scenarios.road_town.plan import make_plan as road_plan
from scenarios.road_town.presets import PRESETS_V1 as ROAD_PRESETS
from scenarios.road_town.scenario import ROAD_TOWN_V1
from sim.rng import episode_seed
from trackers.types import CameraCommand

SEED, EVERY_FRAMES = 3, 30
ROAD_HASHES = {
    "paper-a2": ("c719db9a367220f6", "15815d8f6f32f658"),
    "paper-a3": ("a6cadd2e44e888e1", "8e6954558ec13003"),
    "standard": ("b2b69c262d171611", "956661463f0ee8a9"),
    "hard": ("f2a8a5162887f76a", "dcb38ab3eaa2b04c"),
    "quick": ("1a098adb07e9c136", "415273424d3b071b"),
}
"""Of the set path and of a steered flight of each preset."""


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


@pytest.mark.parametrize("preset", ROAD_PRESETS)
def test_plans_and_steered_flights_of_road_town_v1(preset: str) -> None:
    seed = episode_seed(SEED, ROAD_TOWN_V1.id, 0)
    hashes = []
    for closed_loop in (False, True):
        plan = road_plan(ROAD_PRESETS[preset], seed, closed_loop=closed_loop)
        cars = plan.motion.position_m, plan.motion.heading_rad, plan.motion.speed_mps
        poses = _steered(plan) if closed_loop else plan.camera_poses
        sun = np.array([plan.sun_azimuth_rad, plan.sun_elevation_rad])
        hashes.append(_hash(*cars, plan.air.attitude_rad, poses, sun))
    assert tuple(hashes) == ROAD_HASHES[preset]


def _steered(plan: RoadPlan) -> NDArray[np.float64]:
    """Return the camera's poses (T, 4, 4) of a flight by fixed commands."""
    helicopter = Helicopter(plan.preset, plan.air, list(plan.pulses), plan.camera_poses[0, :2, 3])
    poses = np.empty((plan.preset.frame_count, 4, 4))
    for frame in range(plan.preset.frame_count):
        poses[frame] = helicopter.pose(frame)
        helicopter.obey(_command(frame), frame)
    return poses


def _command(frame: int) -> CameraCommand:
    return CameraCommand(
        12.0 * np.sin(frame / 9), 8.0 * np.cos(frame / 7), 2.0 * np.sin(frame / 5), 0.5 * np.cos(frame / 11)
    )


def _hash(*arrays: NDArray[np.float64]) -> str:
    """Return the first 16 digits of the hash of values rounded to millionths."""
    millionths = [np.round(1e6 * array).astype(np.int64) for array in arrays]
    return hashlib.sha256(b"".join(each.tobytes() for each in millionths)).hexdigest()[:16]
