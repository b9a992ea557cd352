"""The flight of one episode: its air, its swings, and its set path, of either edition."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.flight import AirState, Pulse, draw_air, set_path
from scenarios.road_town.frame_outs import draw_pulses
from scenarios.road_town.layout import Layout
from scenarios.road_town.line_of_sight import LineOfSight
from scenarios.road_town.piloted_flight import Drive, fly_after
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.swings import draw_swings
from sim.optics import PinholeCamera
from sim.rng import generator


@dataclass(frozen=True, eq=False)
class FlightPlan:
    """Attributes are those of ``Plan``."""

    air: AirState
    pulses: list[Pulse]
    camera_poses: NDArray[np.float64]


def plan_flight(
    preset: RoadTown,
    camera: PinholeCamera,
    layout: Layout,
    drive: Drive,
    events: dict[str, list[int]],
    closed_loop: bool,
    seed: int,
) -> FlightPlan:
    """Draw air and swings, and fly the set path.

    In edition 1 the set path is centred on the car and the swings are fitted to it. In edition 2 a pilot flies it; in
    closed loop the swings are those scheduled, and the pilot's path only says where pictureless flights may begin.

    Args:
        events: frames at which the car starts a ``turn`` or an ``excursion``.
    """
    rng = generator(seed, "air")
    air = draw_air(preset, drive.position_m, drive.heading_rad, rng)
    if preset.edition == 1:
        pulses = draw_pulses(preset, camera, air, drive.position_m, drive.corners_m, events, closed_loop, rng)
        return FlightPlan(air, pulses, set_path(preset, air, drive.position_m, pulses))
    swings = draw_swings(preset, camera, air, events, closed_loop, rng)
    poses, begun = fly_after(preset, camera, air, swings, drive, LineOfSight(layout), generator(seed, "pilot"))
    return FlightPlan(air, swings if closed_loop else begun, poses)
