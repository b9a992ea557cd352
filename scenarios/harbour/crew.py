"""The people aboard boats that come to a drawn harbour.

They are people in their own right: each has a mask, a box and the class ``person`` among what stands about
(``Truth.standing_names``), as moored boats and parked cars have. So who trains a detector of people finds them
labelled, and a boat's size and box stay those of the boat. They are no intruders beside their boat, which they never
leave.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.intruders import Intruders
from scenarios.harbour.plan import draw_person
from scenarios.harbour.warmth import Clothes, DayWarmth, Kelvins, draw_clothes, person_kelvins
from scenarios.objects import AWAY, Standing, add_parts
from sim.meshes.boat import Place
from sim.meshes.thermal_paint import thermal_person
from sim.motion.gait import part_poses
from sim.motion.sitting import seated_poses
from sim.motion.skeleton import Skeleton, skeleton
from sim.thermal.weather import Weather
from sim.world import Body, World


@dataclass(frozen=True, slots=True)
class _Member:
    """One of a crew: the boat's number among the intruders, bodies, bones and clothes, and place aboard."""

    boat: int
    bodies: list[Body]
    bones: Skeleton
    clothes: Clothes
    place: Place


class Crews:
    """The crews of all boats among the intruders.

    Attributes:
        standing: all of them.
    """

    def __init__(self, world: World, intruders: Intruders, weather: Weather, rng: np.random.Generator) -> None:
        """Put all in a world, one or more on each boat that has room."""
        self._world, self._intruders = world, intruders
        self._all: list[_Member] = []
        self.standing: list[Standing] = []
        for boat, places in intruders.aboard.items():
            for place in places[: int(rng.integers(1, len(places) + 1))]:
                look = draw_person(rng)
                meshes, name = thermal_person(look, rng), f"crew-{len(self._all)}"
                bodies = add_parts(world, name, "person", meshes, AWAY)
                bones, clothes = skeleton(look.stature_m, look.build), draw_clothes(weather, rng)
                self._all.append(_Member(boat, bodies, bones, clothes, place))
                self.standing.append(Standing(bodies[0], name, "person", bodies[0].mesh, tuple(bodies[1:])))

    def move_to(self, frame: int) -> None:
        """Move all with their boats; those of absent boats out of sight."""
        for one in self._all:
            here = bool(self._intruders.presence[frame, one.boat])
            self._move(one, self._intruders.course[frame, one.boat] if here else None)

    def take_out(self) -> None:
        """Move all out of sight."""
        for one in self._all:
            self._move(one, None)

    def kelvins(self, warmth: DayWarmth) -> list[tuple[list[Body], Kelvins]]:
        """Return the bodies of each, and the temperatures of their parts."""
        return [(one.bodies, person_kelvins(one.clothes, warmth)) for one in self._all]

    def _move(self, one: _Member, T_world_boat: NDArray[np.float64] | None) -> None:
        if T_world_boat is None:
            self._world.move_all(one.bodies, np.tile(AWAY, (len(one.bodies), 1, 1)))
            return
        floor = np.eye(4)
        floor[:3, 3] = one.place.floor_m
        T, seat_m = T_world_boat @ floor, one.place.seat_m
        poses = part_poses(one.bones, T, 0.0, 0.0) if seat_m is None else seated_poses(one.bones, T, seat_m)
        self._world.move_all(one.bodies, poses)
