"""What a pictureless env needs of an episode of ``stereo-follow``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.plan import TARGET, make_plan
from scenarios.stereo_follow.presets import StereoFollow
from sim.meshes.person import person_size_m

STEREO_VERSION = 1
"""To be counted up with every change of what is below."""
_MOST_OTHERS = 24
_FAR_AWAY_M = 1e6


def stereo_arrays(preset: StereoFollow, seed: int) -> dict[str, NDArray[np.float64]]:
    """Return everybody's way, and where walls are.

    ``target_m`` (T, 2), ``target_rad`` (T,), ``size_m`` (3,) of the target; ``others_m`` (24, T, 2), far away for
    nobody; ``free_m`` (5, 4) rectangles x0, y0, x1, y1 where one can be; ``openings_m`` (2, 4) those of the gaps in
    the walls; ``path_m`` (T, 2) and ``yaw_rad`` (T,) of the robot driven by hand.
    """
    plan = make_plan(preset, seed, closed_loop=True)
    crowd, floor = plan.crowd, plan.building.plan
    others = np.full((_MOST_OTHERS, preset.frame_count, 2), _FAR_AWAY_M)
    for k, walk in enumerate(crowd.walks[1 : _MOST_OTHERS + 1]):
        others[k] = walk.place_m
    return {
        "target_m": crowd.walks[TARGET].place_m,
        "target_rad": crowd.walks[TARGET].heading_rad,
        "size_m": np.array(person_size_m(plan.looks[TARGET])),
        "others_m": others,
        "free_m": np.array([[a.x0, a.y0, a.x1, a.y1] for a in floor.free_parts]),
        "openings_m": np.array([[a.x0, a.y0, a.x1, a.y1] for a in floor.openings]),
        "path_m": crowd.robot_m,
        "yaw_rad": crowd.robot_heading_rad,
    }
