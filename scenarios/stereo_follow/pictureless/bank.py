"""Pictureless ``stereo-follow``: the arrays of a plan."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.scenario import Pictureless, TrackerRuns
from scenarios.stereo_follow.carried import laden_size_m
from scenarios.stereo_follow.plan import TARGET, make_plan
from scenarios.stereo_follow.presets import StereoFollow

_MOST_OTHERS = 16
_FAR_AWAY_M = 1e6
_MOST_LOSSES = 16
_LOST_RAD, _BEFORE_M = np.deg2rad(28.0), 0.35
"""A loss is likely if the target's bearing exceeds the first, or a person is nearer to the line of sight than the
second."""


class StereoPictureless(Pictureless):
    """See ``scenarios.scenario.Pictureless``."""

    version = 2
    world_place = "scenarios.stereo_follow.pictureless.world:StereoWorld"
    runs = TrackerRuns(
        ("reentry", "disturbed:reentry", "centre", "disturbed:reentry", "search", "hold"), wrong_from_m=0.8, jump_m=0.8
    )

    def is_playable(self, preset: Any) -> bool:
        """Return whether the preset has a robot with odometry."""
        return isinstance(preset, StereoFollow) and preset.odometry

    def arrays(self, preset: StereoFollow, seed: int) -> dict[str, NDArray[np.float64]]:
        """Return all paths, and the walls.

        ``target_m`` (T, 2), ``target_rad`` (T,), ``size_m`` (3,) of the target; ``others_m`` (T, 16, 2), unused places
        far away; ``free_m`` (5, 4), in furnished rooms (8, 4), rectangles x0, y0, x1, y1 where the robot can be;
        ``openings_m`` (2, 4) those of the gaps in the walls; ``path_m`` (T, 2) and ``yaw_rad`` (T,) of the robot driven
        by hand; ``onsets`` (16,) frames on which a loss becomes likely there, -1 for none.
        """
        plan = make_plan(preset, seed, closed_loop=True)
        crowd, floor = plan.crowd, plan.building.plan
        others = np.full((preset.frame_count, _MOST_OTHERS, 2), _FAR_AWAY_M)
        for k, walk in enumerate(crowd.walks[1 : _MOST_OTHERS + 1]):
            others[:, k] = walk.place_m
        return {
            "target_m": crowd.walks[TARGET].place_m,
            "target_rad": crowd.walks[TARGET].heading_rad,
            "size_m": laden_size_m(plan.looks[TARGET], plan.loads[TARGET]),
            "others_m": others,
            "free_m": floor.free_m,
            "openings_m": floor.openings_m,
            "path_m": crowd.robot_m,
            "yaw_rad": crowd.robot_heading_rad,
            "onsets": _onsets(crowd.walks[TARGET].place_m, others, crowd.robot_m, crowd.robot_heading_rad),
        }


def _onsets(
    target_m: NDArray[np.float64],
    others_m: NDArray[np.float64],
    robot_m: NDArray[np.float64],
    heading_rad: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the frames (16,) on which the target moves far aside, or behind a person, -1 for none."""
    sight_m = target_m - robot_m
    to_m = others_m - robot_m[:, None]
    bearing_rad = np.arctan2(sight_m[:, 1], sight_m[:, 0]) - heading_rad
    aside = np.abs((bearing_rad + np.pi) % (2 * np.pi) - np.pi) > _LOST_RAD
    share = (to_m * sight_m[:, None]).sum(axis=-1) / np.maximum((sight_m**2).sum(axis=-1), 1e-6)[:, None]
    off_m = np.linalg.norm(to_m - share[..., None] * sight_m[:, None], axis=-1)
    behind = ((share > 0.02) & (share < 0.95) & (off_m < _BEFORE_M)).any(axis=1)
    # A start near the end would leave too short an episode.
    begins = np.flatnonzero(np.diff((aside | behind).astype(int)) > 0)
    begins = begins[begins < 0.85 * len(target_m)][:_MOST_LOSSES]
    onsets = np.full(_MOST_LOSSES, -1.0)
    onsets[: len(begins)] = begins
    return onsets
