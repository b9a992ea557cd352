"""Pictureless ``road-town``: the arrays of a plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.envs.pictureless.episode_state import LEAD_FRAMES
from scenarios.road_town.flight import Pulse, gust_attitude_rad
from scenarios.road_town.plan import TARGET, make_plan
from scenarios.road_town.presets import RoadTown
from scenarios.scenario import Pictureless, TrackerRuns
from sim.checks import check

_MOST_GUSTS = 8


class RoadPictureless(Pictureless):
    """See ``scenarios.scenario.Pictureless``."""

    version = 4
    world_place = "scenarios.road_town.pictureless.world:RoadWorld"
    fixed_fields = (*Pictureless.fixed_fields, "field_of_view_deg")
    runs = TrackerRuns(
        ("centre", "disturbed:centre", "centre", "disturbed:centre", "hold"), wrong_from_m=3.0, jump_m=4.0
    )

    def is_playable(self, preset: RoadTown) -> bool:
        """Return whether the helicopter has instruments, and no overpass hides the car from it."""
        return preset.ego is not None and preset.overpasses[1] == 0

    def check_playable(self, preset: RoadTown) -> None:
        """See ``Pictureless``."""
        wanted = "(0, 0) in play without pictures, which does not know when they hide the car"
        check("overpasses", preset.overpasses[1] == 0, wanted, preset.overpasses)
        super().check_playable(preset)

    def arrays(self, preset: RoadTown, seed: int) -> dict[str, NDArray[np.float64]]:
        """Return the target's path, and air and camera of the helicopter in closed loop.

        ``target_m`` (T, 2), ``target_rad`` (T,) and ``size_m`` (3,) of the car; ``attitude_rad`` (T, 3) of rough air
        and gusts; ``start_m`` (3,) and ``yaw_rad`` (1,) of the helicopter; ``path_m`` (T, 2) of a set path; ``onsets``
        (8,) frames on which gusts begin before which flights may start, -1 for none; ``mount_rad`` (1,) by which the
        camera is pitched forward.
        """
        plan = make_plan(preset, seed, closed_loop=True)
        poses = plan.camera_poses
        frames, air = preset.frame_count, plan.air
        gusts_rad = gust_attitude_rad(list(plan.pulses), air.altitude_m, frames, air.mount_rad)
        onsets = np.full(_MOST_GUSTS, -1.0)
        starts = _after_calm(plan.pulses)[:_MOST_GUSTS]
        onsets[: len(starts)] = starts
        return {
            "target_m": plan.motion.position_m[:, TARGET],
            "target_rad": plan.motion.heading_rad[:, TARGET],
            "size_m": plan.sizes_m[TARGET],
            "attitude_rad": air.attitude_rad + gusts_rad,
            "mount_rad": np.array([air.mount_rad]),
            "start_m": np.array([*poses[0, :2, 3], air.altitude_m]),
            "path_m": poses[:, :2, 3],
            "yaw_rad": np.array([air.yaw_rad]),
            "onsets": onsets,
        }


def _after_calm(gusts: tuple[Pulse, ...]) -> list[int]:
    """Return the first frames of the gusts before which a flight can start with no other gust blowing.

    In a gust the first picture would not tell how the camera is mounted, see ``mount_slope``.
    """
    calm_from, starts = 0, []
    for gust in gusts:
        if calm_from == 0 or gust.start_frame - calm_from >= LEAD_FRAMES[1]:
            starts.append(gust.start_frame)
        calm_from = gust.end_frame
    return starts
