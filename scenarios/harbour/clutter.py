"""What is no intruder but moves or stands about: sea, moored boats and their ropes, gulls, cars that belong there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.birds import AWAY_M, FLYING, RESTING, Birds, birds
from scenarios.harbour.conditions import DAYS_BEFORE, Conditions
from scenarios.harbour.layout import PARKING_X_M, WALL_X_M
from scenarios.harbour.moorings import SEGMENTS, Ride, buoy_mesh, draw_moored, mesh_of, ride, rope_lengths_m, rope_mesh
from scenarios.harbour.plan import Plan, draw_car
from scenarios.harbour.scenery import Surface
from scenarios.harbour.warmth import BOAT_VIEW, CAR_VIEW, boat_materials, car_materials
from scenarios.objects import Standing
from sim.meshes.boat import above_water
from sim.meshes.gull import gull
from sim.meshes.shed import level_plate
from sim.meshes.thermal_paint import parts_palette, thermal_car
from sim.pose import pose_on_ground
from sim.world import Body, World

CAR_PAINTS = ("dark paint", "painted steel", "white paint")
HULLS = ("fibreglass", "painted steel", "timber")
_SEA_REACH_M = (-99.0, 130.0)
"""The sea begins there before the camera, and reaches so far to either side."""
AWAY = np.diag([1.0, 1.0, 1.0, 1.0])
AWAY[2, 3] = AWAY_M
AWAY.setflags(write=False)


@dataclass(frozen=True, slots=True)
class Afloat:
    """All that the tide moves, and the gulls, at F times.

    Attributes:
        level_m: (F,) of the sea. rides: of each moored boat.
    """

    level_m: NDArray[np.float64]
    rides: tuple[Ride, ...]
    gulls: Birds


class Clutter:
    """Bodies that are no intruders.

    Attributes:
        sea: the body of the sea.
        surfaces: bodies with materials. gulls: bodies of flying and of resting ones.
        standing: moored boats and parked cars.
    """

    def __init__(self, world: World, plan: Plan, conditions: Conditions, rng: np.random.Generator) -> None:
        self._world, self._conditions = world, conditions
        self._gull_rng = rng.integers(2**31, size=2)
        low_x, reach_y = _SEA_REACH_M
        plate = level_plate((low_x, -reach_y), (WALL_X_M, reach_y), 0.0, parts_palette(1), (8, 16))
        self.sea = world.add(plate, np.eye(4), name="sea", category="sea", movable=True)
        self.surfaces: list[Surface] = []
        self.standing: list[Standing] = []
        self._moored = draw_moored(plan.buoys, rng)
        self._boats: list[Body] = []
        self._ropes: list[list[Body]] = []
        self._buoys: list[Body] = []
        for k, moored in enumerate(self._moored):
            hull = str(rng.choice(HULLS))
            boat = world.add(mesh_of(moored), AWAY, name=f"moored-{k}", category="moored", movable=True)
            self._boats.append(boat)
            self.standing.append(Standing(boat, boat.name, "boat", above_water(boat.mesh)))
            self.surfaces.append(Surface(boat, boat_materials(hull), BOAT_VIEW))
            ropes = []
            for length_m in rope_lengths_m(moored):
                mesh = rope_mesh(float(length_m))
                ropes += [world.add(mesh, AWAY, name="rope", category="rope", movable=True) for _ in range(SEGMENTS)]
            self._ropes.append(ropes)
            self.surfaces += [Surface(rope, ("rope",), BOAT_VIEW) for rope in ropes]
            if moored.swings:
                buoy = world.add(buoy_mesh(), AWAY, name="buoy", category="moored", movable=True)
                self._buoys.append(buoy)
                self.surfaces.append(Surface(buoy, ("fibreglass",), BOAT_VIEW))
        self._flying = [world.add(gull(True), AWAY, name="gull", category="bird", movable=True) for _ in range(FLYING)]
        self._resting = [
            world.add(gull(False), AWAY, name="gull", category="bird", movable=True) for _ in range(RESTING)
        ]
        self.gulls = [*self._flying, *self._resting]
        for y in plan.usual_y_m:
            self._park(pose_on_ground(PARKING_X_M, y, _parked_heading(rng)), False, rng)
        # In the bays of cars that stood there before, other cars stood on the days before: on some of them.
        self._earlier: list[tuple[Body, NDArray[np.float64], NDArray[np.bool_]]] = []
        for y in plan.before_y_m:
            pose = pose_on_ground(PARKING_X_M + rng.normal(0.0, 0.2), y, _parked_heading(rng))
            stood = rng.permutation([True, True, False][:DAYS_BEFORE])
            self._earlier.append((self._park(AWAY, True, rng), pose, stood))

    def afloat(self, time_s: NDArray[np.float64], *, before: bool) -> Afloat:
        """Return all that floats or flies at ascending times (F,), of the days before or of the episode."""
        conditions = self._conditions
        days = [conditions.days[conditions.day_at(each)] for each in time_s.tolist()]
        waves_m = np.array([day.waves.significant_m for day in days])
        wind_mps, wind_rad = np.array([(day.weather.wind_mps, day.weather.wind_rad) for day in days]).T
        rides = tuple(ride(each, time_s, conditions.tide, waves_m, wind_mps, wind_rad) for each in self._moored)
        gulls = birds(time_s, conditions.tide, np.random.default_rng(int(self._gull_rng[int(before)])))
        return Afloat(conditions.tide.level_m(time_s), rides, gulls)

    def _park(self, pose: NDArray[np.float64], movable: bool, rng: np.random.Generator) -> Body:
        """Add a parked car; return its body."""
        look = draw_car(rng)
        mesh = thermal_car(look.model, look.factors)
        name = f"parked-{sum(each.kind == 'car' for each in self.standing)}"
        body = self._world.add(mesh, pose, name=name, category="parked", movable=movable)
        self.standing.append(Standing(body, name, "car", mesh))
        self.surfaces.append(Surface(body, car_materials(str(rng.choice(CAR_PAINTS))), CAR_VIEW))
        return body

    def move_to(self, afloat: Afloat, k: int, day: int) -> None:
        """Move all to their k-th time, on a day of ``Conditions.days``."""
        move = self._world.move_all
        level = np.eye(4)
        level[2, 3] = afloat.level_m[k]
        self._world.move(self.sea, level)
        move(self._boats, np.stack([each.T_world_boat[k] for each in afloat.rides]))
        for ropes, one in zip(self._ropes, afloat.rides, strict=True):
            move(ropes, one.T_world_rope[k])
        swinging = [each for each in self._moored if each.swings]
        for buoy, moored in zip(self._buoys, swinging, strict=True):
            at_buoy = pose_on_ground(*moored.anchor_m, 0.0)
            at_buoy[2, 3] = afloat.level_m[k]
            self._world.move(buoy, at_buoy)
        move(self._flying, afloat.gulls.flying[k])
        move(self._resting, afloat.gulls.resting[k])
        for body, pose, stood in self._earlier:
            self._world.move(body, pose if day < DAYS_BEFORE and stood[day] else AWAY)


def _parked_heading(rng: np.random.Generator) -> float:
    return float(rng.choice([0.0, np.pi]) + rng.normal(0.0, 0.03))
