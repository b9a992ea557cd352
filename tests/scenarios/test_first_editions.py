"""The first edition of a scene gives what it gave before there was a second one: drives and pictures.

The values were written by the code as it was before. Hashes are of places in millionths of a metre or radian, for the
last bits of sines depend on the processor.
"""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.plan import make_plan as stereo_plan
from scenarios.stereo_follow.presets import PRESETS_V1 as STEREO_PRESETS
from scenarios.stereo_follow.robot import Robot
from scenarios.stereo_follow.scenario import STEREO_FOLLOW_V1
from sim.rng import episode_seed
from trackers.types import CameraCommand

SEED, EVERY_FRAMES = 3, 30
STEREO_HASH = "631c3af9fad8f9d1"


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


def test_plan_and_steered_drive_of_stereo_follow_v1() -> None:
    preset = STEREO_PRESETS["quick"]
    plan = stereo_plan(preset, episode_seed(SEED, STEREO_FOLLOW_V1.id, 0), closed_loop=True)
    crowd = plan.crowd
    robot = Robot(plan.building.plan, crowd.robot_m[0], crowd.robot_heading_rad[0], preset.rate_hz)
    driven = np.empty((preset.frame_count, 3))
    for frame in range(preset.frame_count):
        driven[frame] = *robot.place_m, robot.heading_rad
        robot.drive(_command(frame))
    walks = [np.column_stack([walk.place_m, walk.heading_rad]) for walk in crowd.walks]
    assert _hash(*walks, crowd.robot_m, plan.phase_rad, driven) == STEREO_HASH


def _command(frame: int) -> CameraCommand:
    return CameraCommand(
        12.0 * np.sin(frame / 9), 8.0 * np.cos(frame / 7), 2.0 * np.sin(frame / 5), 0.5 * np.cos(frame / 11)
    )


def _hash(*arrays: NDArray[np.float64]) -> str:
    """Return the first 16 digits of the hash of values rounded to millionths."""
    millionths = [np.round(1e6 * array).astype(np.int64) for array in arrays]
    return hashlib.sha256(b"".join(each.tobytes() for each in millionths)).hexdigest()[:16]
