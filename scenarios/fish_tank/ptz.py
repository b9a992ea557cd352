"""The scenario ``fish-tank-ptz-v1``: the tank through the zoom camera of a pan-tilt head that hangs above it.

Trackers get the pictures of the camera that is steered: a fish that leaves them is lost until the head finds it again.
Closely enough to count as in view, the camera sees a twentieth of the tank.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scenarios.fish_tank.fish import Fish
from scenarios.fish_tank.presets import FishTank
from scenarios.fish_tank.scenario import FishTankEpisode
from scenarios.fish_tank.truth import FishTruth
from scenarios.pan_tilt_zoom import Head, Mount
from scenarios.scenario import Scenario, Setup
from trackers.types import CameraModel, Carrier, CommandAxis, Observation

HEAD = Carrier(
    "tank-ptz",
    (CommandAxis("pan_rad_s", 2.0, 12.0), CommandAxis("tilt_rad_s", 2.0, 12.0), CommandAxis("zoom_per_s", 1.0, 5.0)),
    "around",
)
"""Two servos, slower than they are without a load (55 turns a minute), and a motor zoom."""
_WIDEST_RAD = float(np.deg2rad(30.0))
"""Width of the view at zoom 1: the whole tank."""
MOUNT = Mount(
    HEAD,
    CameraModel.from_field_of_view(320, 240, _WIDEST_RAD),
    place_m=(0.0, 0.0, 1.5),
    aim_m=(0.0, 0.0, 0.0),
    ahead=(0.0, 0.0, -1.0),
    left=(-1.0, 0.0, 0.0),
    widest_pan_rad=0.3,
    tilt_rad=(-0.25, 0.25),
    zoom=(1.0, 10.0),
    watches=True,
    step_rad=2.0 * np.pi / 4096,
)
"""Its encoders are those of a Robotis Dynamixel MX-28: 4,096 steps a turn."""
WIDEST_VIEW_M = 320 * 0.0056 / 12.8
"""Johnson's criterion of identification (Analysis of image forming systems, 1958): 6.4 pairs of lines, two pixels each,
across the target's least dimension. A zebrafish of middle size is 5.6 mm wide, the picture 320 pixels.
"""
_FIRST_VIEW = 0.8
"""Width of the first view, as a share of the widest one that counts."""

PRESETS = {
    "standard": FishTank(
        "half a minute with ten zebrafish", frame_count=600, rate_hz=20.0, width_px=320, height_px=240
    ),
    "quick": FishTank("five fish for ten seconds", frame_count=200, rate_hz=20.0, width_px=320, height_px=240, fish=5),
}


class FishTankPtzEpisode(FishTankEpisode):
    """See ``scenarios.scenario.Episode``. The first picture has the target in the middle."""

    def _head_over(self, setup: Setup, fish: Fish) -> Head:
        preset = setup.preset
        fish.move_to(0)
        target_m = fish.T_world_object[fish.names.index(setup.scenario.target), :3, 3]
        lens = CameraModel.from_field_of_view(preset.width_px, preset.height_px, _WIDEST_RAD)
        mount = replace(MOUNT, lens=lens, aim_m=tuple(target_m.tolist()))
        return Head(mount, preset.rate_hz, mount.zoom_for(_FIRST_VIEW * WIDEST_VIEW_M))

    def _empty_pictures(self) -> list[Observation]:
        return []


FISH_TANK_PTZ = Scenario(
    id="fish-tank-ptz-v1",
    summary="a fish of a shoal, through the zoom camera of a pan-tilt head that hangs above the tank",
    start="the box of one fish in the first picture, the camera's zoom and its pose by encoders",
    stage=FishTankPtzEpisode,
    presets=PRESETS,
    classes={"fish": "fish"},
    carrier=HEAD,
    truth=FishTruth,
    target="fish-0",
    widest_view_m=WIDEST_VIEW_M,
)
