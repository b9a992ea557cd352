"""What is no intruder but moves or stands about: sea, moored boats and their ropes, gulls, cars that belong there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.conditions import DAYS_BEFORE, Conditions, Tide, float_poses
from scenarios.harbour.layout import FIXED, Site
from scenarios.harbour.moorings import SEGMENTS, Ride, buoy_mesh, draw_moored, mesh_of, ride, rope_lengths_m, rope_mesh
from scenarios.harbour.plan import Plan, draw_car
from scenarios.harbour.scenery import Surface
from scenarios.harbour.warmth import BOAT_VIEW, CAR_VIEW, boat_materials, car_materials
from scenarios.objects import AWAY, AWAY_M, Standing
from sim.meshes.boat import above_water
from sim.meshes.gull import gull
from sim.meshes.shed import level_plate
from sim.meshes.thermal_paint import parts_palette, thermal_car
from sim.pose import pose_on_ground
from sim.thermal.waves import SeaWaves
from sim.world import Body, World

FLYING, RESTING = 5, 6
"""Most at a time."""
_SPEED_MPS = (7.0, 11.0)
_FLIGHTS_PER_H, _RESTS_PER_H = 70.0, 22.0
_REST_S = (60.0, 1200.0)


class Birds(NamedTuple):
    """Poses of gulls at F times: (F, FLYING, 4, 4) and (F, RESTING, 4, 4)."""

    flying: NDArray[np.float64]
    resting: NDArray[np.float64]


def birds(time_s: NDArray[np.float64], tide: Tide, rng: np.random.Generator, site: Site = FIXED) -> Birds:
    """Draw the gulls at ascending times (F,)."""
    flying, resting = (np.tile(np.eye(4), (len(time_s), count, 1, 1)) for count in (FLYING, RESTING))
    flying[..., 2, 3] = resting[..., 2, 3] = AWAY_M
    span_h = (time_s[-1] - time_s[0]) / 3600.0
    for k, begin in enumerate(_moments(time_s, _FLIGHTS_PER_H * span_h, rng)):
        _fly(flying[:, k % FLYING], time_s, begin, rng, site)
    level_m = tide.level_m(time_s)
    for k, begin in enumerate(_moments(time_s, _RESTS_PER_H * span_h, rng, before_s=_REST_S[1])):
        _rest(resting[:, k % RESTING], time_s, begin, level_m, rng, site)
    return Birds(flying, resting)


def _moments(
    time_s: NDArray[np.float64], mean: float, rng: np.random.Generator, before_s: float = 0.0
) -> NDArray[np.float64]:
    span_s = time_s[-1] - time_s[0]
    count = rng.poisson(mean * (1.0 + before_s / span_s))
    return np.sort(rng.uniform(time_s[0] - before_s, time_s[-1], count))


def _fly(
    poses: NDArray[np.float64], time_s: NDArray[np.float64], begin_s: float, rng: np.random.Generator, site: Site
) -> None:
    """Write a straight flight across the picture, level or in a shallow dive."""
    x, height = rng.uniform(-50.0, 55.0), rng.uniform(1.5, 13.0)
    side = float(rng.choice([-1.0, 1.0]))
    heading = side * 0.5 * np.pi + rng.normal(0.0, 0.5)
    speed, half = rng.uniform(*_SPEED_MPS), 0.27 * (x + 100.0) + 4.0
    roll, dive = rng.normal(0.0, 0.35), rng.normal(0.0, 0.03)
    first, last = np.searchsorted(time_s, (begin_s, begin_s + 2.0 * half / speed))
    if first == last:
        return
    since = time_s[first:last] - begin_s
    along = speed * since - half
    # Across what the camera sees, wherever it looks.
    turned, (x, y) = heading + site.bearing_rad, x * site.volume_axes[0]
    place = np.column_stack([x + along * np.cos(turned), y + along * np.sin(turned), height - dive * along])
    zero = np.zeros(len(since))
    poses[first:last] = float_poses(place, zero + turned, zero + roll, zero)


def _rest(
    poses: NDArray[np.float64],
    time_s: NDArray[np.float64],
    begin_s: float,
    level_m: NDArray[np.float64],
    rng: np.random.Generator,
    site: Site,
) -> None:
    """Write a rest: on the water, where the gull drifts, on the edge of the quay, a bollard, the apron, or a roof."""
    first, last = np.searchsorted(time_s, (begin_s, begin_s + np.exp(rng.uniform(*np.log(_REST_S)))))
    since, heading = time_s[first:last] - begin_s, rng.uniform(-np.pi, np.pi)
    shed = site.sheds[int(rng.integers(len(site.sheds)))]
    ridge = (site.shed_x_m + 0.5 * shed.depth_m, shed.eaves_m + shed.rise_m + 0.15)
    y = rng.uniform(-22.0, 22.0)
    where = int(rng.choice(5, p=[0.4, 0.2, 0.15, 0.15, 0.1]))
    spots = (
        (rng.uniform(site.wall_x_m - 31.0, site.wall_x_m - 5.0), 0.6 * y, 0.0),
        (site.wall_x_m + 0.3, y, 0.0),
        (site.bollard_x_m, float(rng.choice(site.bollards_y_m[2:-2])), 0.6),
        (rng.uniform(site.wall_x_m + 3.0, site.apron_end_m - 2.0), y, 0.0),
        (ridge[0], shed.y_m + rng.uniform(-0.4, 0.4) * shed.length_m, ridge[1]),
    )
    place = np.tile(spots[where], (len(since), 1))
    if where == 0:
        drift = rng.normal(0.0, 0.03, 2)
        place[:, :2] += since[:, None] * drift
        place[:, 2] = level_m[first:last] - 0.05
    turns = 0.4 * np.sin(since / 37.0) if where == 0 else np.zeros(len(since))
    zero = np.zeros(len(since))
    poses[first:last] = float_poses(place, heading + turns, zero, zero)


CAR_PAINTS = ("dark paint", "painted steel", "white paint")
HULLS = ("fibreglass", "painted steel", "timber")
_SEA_REACH_M = (-99.0, 130.0)
"""The sea begins there before the camera, and reaches so far to either side."""
_FAR_SEA_REACH_M = (-700.0, 700.0)
"""Likewise where the picture shows the other shore."""


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

    def __init__(
        self,
        world: World,
        plan: Plan,
        conditions: Conditions,
        rng: np.random.Generator,
        site: Site = FIXED,
        waves: Sequence[SeaWaves] = (),
    ) -> None:
        """``waves``: of each day, on which boats float; none: they move by chance."""
        self._world, self._conditions, self._site, self._waves = world, conditions, site, waves
        self._gull_rng = rng.integers(2**31, size=2)
        (low_x, reach_y), cells = (_FAR_SEA_REACH_M, (24, 48)) if site.is_drawn else (_SEA_REACH_M, (8, 16))
        plate = level_plate((low_x, -reach_y), (site.wall_x_m, reach_y), 0.0, parts_palette(1), cells)
        self.sea = world.add(plate, np.eye(4), name="sea", category="sea", movable=True)
        self.surfaces: list[Surface] = []
        self.standing: list[Standing] = []
        self._moored = draw_moored(plan.buoys, rng, site)
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
            self._park(pose_on_ground(site.parking_x_m, y, _parked_heading(rng)), False, rng)
        # In the bays of cars that stood there before, other cars stood on the days before: on some of them.
        self._earlier: list[tuple[Body, NDArray[np.float64], NDArray[np.bool_]]] = []
        for y in plan.before_y_m:
            pose = pose_on_ground(site.parking_x_m + rng.normal(0.0, 0.2), y, _parked_heading(rng))
            stood = rng.permutation([True, True, False][:DAYS_BEFORE])
            self._earlier.append((self._park(AWAY, True, rng), pose, stood))

    def afloat(self, time_s: NDArray[np.float64], *, before: bool) -> Afloat:
        """Return all that floats or flies at ascending times (F,), of the days before or of the episode."""
        conditions = self._conditions
        which = [conditions.day_at(each) for each in time_s.tolist()]
        days = [conditions.days[k] for k in which]
        waves_m = np.array([day.waves.significant_m for day in days])
        wind_mps, wind_rad = np.array([(day.weather.wind_mps, day.weather.wind_rad) for day in days]).T
        weather = waves_m, wind_mps, wind_rad
        rides = tuple(ride(each, time_s, conditions.tide, *weather, self._waves, which) for each in self._moored)
        gulls = birds(time_s, conditions.tide, np.random.default_rng(int(self._gull_rng[int(before)])), self._site)
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
