"""The flight of one episode: its air, its swings, and its set path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.flight import AirState, Pulse, draw_air
from scenarios.road_town.layout import Layout
from scenarios.road_town.line_of_sight import LineOfSight
from scenarios.road_town.piloted_flight import Drive, fly_after
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.swings import draw_swings
from sim.rng import generator
from trackers.types import CameraModel


@dataclass(frozen=True, eq=False)
class FlightPlan:
    """Attributes are those of ``Plan``."""

    air: AirState
    pulses: list[Pulse]
    camera_poses: NDArray[np.float64]


def plan_flight(
    preset: RoadTown,
    camera: CameraModel,
    layout: Layout,
    drive: Drive,
    events: dict[str, list[int]],
    closed_loop: bool,
    seed: int,
) -> FlightPlan:
    """Draw air and swings, and fly the set path.

    A pilot flies the set path. In closed loop the swings are those scheduled, and the pilot's path only says where
    pictureless flights may begin.

    Args:
        events: frames at which the car starts a ``turn`` or an ``excursion``.
    """
    rng = generator(seed, "air")
    air = draw_air(preset, float(drive.heading_rad[0]), rng)
    swings = draw_swings(preset, camera, air, events, closed_loop, rng)
    poses, begun = fly_after(preset, camera, air, swings, drive, LineOfSight(layout), generator(seed, "pilot"))
    return FlightPlan(air, swings if closed_loop else begun, poses)
