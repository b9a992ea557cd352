"""What a pictureless env needs of an episode of ``road-town``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.flight import gust_attitude_rad
from scenarios.road_town.plan import TARGET, make_plan
from scenarios.road_town.presets import RoadTown

ROAD_VERSION = 1
"""To be counted up with every change of what is below."""
_MOST_GUSTS = 8


def road_arrays(preset: RoadTown, seed: int) -> dict[str, NDArray[np.float64]]:
    """Return the target's way and the helicopter's air, all in closed loop.

    ``target_m`` (T, 2), ``target_rad`` (T,) and ``size_m`` (3,) of the car; ``attitude_rad`` (T, 3) of rough air and
    gusts; ``start_m`` (3,) of the helicopter, ``yaw_rad`` (T,) of a set path; ``path_m`` (T, 2) of that;
    ``onsets`` (8,) frames on which gusts begin, -1 for none.
    """
    plan = make_plan(preset, seed, closed_loop=True)
    poses = plan.camera_poses
    frames = preset.frame_count
    onsets = np.full(_MOST_GUSTS, -1.0)
    starts = [float(pulse.start_frame) for pulse in plan.pulses][:_MOST_GUSTS]
    onsets[: len(starts)] = starts
    return {
        "target_m": plan.motion.position_m[:, TARGET],
        "target_rad": plan.motion.heading_rad[:, TARGET],
        "size_m": plan.sizes_m[TARGET],
        "attitude_rad": plan.air.attitude_rad + gust_attitude_rad(list(plan.pulses), plan.air.altitude_m, frames),
        "start_m": np.array([*poses[0, :2, 3], plan.air.altitude_m]),
        "path_m": poses[:, :2, 3],
        "yaw_rad": plan.air.yaw_rad,
        "onsets": onsets,
    }
