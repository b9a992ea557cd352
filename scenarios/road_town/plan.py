"""The plan of an episode, drawn before its first picture: town, traffic, air, swings of the view, sun.

It needs no rendering, so surveys over many seeds and searches over schedules are cheap.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.blocks import fill_blocks
from scenarios.road_town.canvas import draw_paint
from scenarios.road_town.fleet import CRUISES_AT, draw_car, draw_model, livery
from scenarios.road_town.flight import AirState, Pulse
from scenarios.road_town.furnishing import furnish
from scenarios.road_town.kept_apart import Room, simulate_apart
from scenarios.road_town.layout import Layout
from scenarios.road_town.overpasses import Way, with_overpasses
from scenarios.road_town.passers_by import PassersBy, draw_passers_by
from scenarios.road_town.patterns import make_streets
from scenarios.road_town.pilot import Drive, plan_flight
from scenarios.road_town.presets import RoadTown
from scenarios.road_town.route import Excursion, Route, random_route, with_excursion
from scenarios.road_town.street_lamps import place_lamps
from scenarios.road_town.traffic import Driver, Motion, simulate
from sim.meshes.vehicle import class_of, vehicle
from sim.rng import generator
from trackers.types import CameraModel

TARGET = 0
"""Index of the target among the cars."""
_NEAR_TARGET_M = 110.0
_SPAWN_GAP_M = 14.0
_MOST_DRAWS = 2000
"""Draws of a place for a car after which there is no room for another: the last of 60 takes about a hundred."""
EXCURSION_ASIDE_M, EXCURSION_ALONG_M = (7.0, 16.0), (34.0, 70.0)
"""Ranges of an excursion's sideways distance and length."""
STARTS_BEFORE_TURN_M = 6.0
"""Way to the crossing from the start of a target that starts at its first turn."""
_REACH_SHARE = 0.75
"""Share of the way at cruising speed that a car drives, with bends and stops."""
_LEAST_REACH_M = 90.0
"""Overpasses of short episodes may stand beyond what is driven."""
STOP_S = (0.8, 2.5)
"""Range of the time that a car halts at a crossing."""


@dataclass(frozen=True, slots=True)
class Look:
    """A car's look: a registered vehicle model and its paint (sRGB 0-255)."""

    model: str
    paint_rgb: tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Plan:
    """The plan of one episode. The target is car 0.

    Attributes:
        sizes_m: (N, 3) length, width, height of the cars.
        excursions: where the target's route is off the road.
        pulses: swings of the view. camera_poses: T_world_camera (T, 4, 4) of the set path.
        sun_azimuth_rad, sun_elevation_rad: direction of the sun.
        passers_by: people and cyclists; None in a town without.
    """

    preset: RoadTown
    seed: int
    closed_loop: bool
    camera: CameraModel
    layout: Layout
    looks: tuple[Look, ...]
    sizes_m: NDArray[np.float64]
    routes: tuple[Route, ...]
    motion: Motion
    excursions: tuple[Excursion, ...]
    air: AirState
    pulses: tuple[Pulse, ...]
    camera_poses: NDArray[np.float64]
    sun_azimuth_rad: float
    sun_elevation_rad: float
    passers_by: PassersBy | None = None

    def target_corners_m(self) -> NDArray[np.float64]:
        """Corners (T, 8, 3) of the target's bounding box."""
        return _corners(self.motion, self.sizes_m[TARGET])

    def turning(self, frame: int) -> bool:
        """Whether the target turns at a crossing in the given frame."""
        arc = self.motion.arc_m[frame, TARGET]
        return any(p.is_turn and p.enter_m <= arc <= p.leave_m for p in self.routes[TARGET].passages)


def camera_of(preset: RoadTown) -> CameraModel:
    """Return the camera of a configuration."""
    field_of_view_rad = float(np.deg2rad(preset.field_of_view_deg))
    return CameraModel.from_field_of_view(preset.width_px, preset.height_px, field_of_view_rad)


def draw_layout(preset: RoadTown, seed: int) -> Layout:
    """Draw the town of an episode."""
    rng = generator(seed, "streets")
    pattern = str(rng.choice(preset.street_patterns))
    graph = replace(make_streets(pattern, rng, preset.extent_m), traffic_side=preset.traffic_side)
    rng, own = generator(seed, "blocks"), generator(seed, "own buildings")
    layout = fill_blocks(graph, rng, preset.extent_m, preset.building_models, own)
    if preset.has_lamp_posts:
        layout = replace(layout, lamps=place_lamps(graph))
    return furnish(layout, preset, seed)


def draw_kept_layout(preset: RoadTown, seed: int) -> Layout:
    """Draw a town that other episodes share: its overpasses stand over any streets."""
    return with_overpasses(draw_layout(preset, seed), preset.overpasses, seed)


def make_plan(preset: RoadTown, seed: int, *, closed_loop: bool, kept: Layout | None = None) -> Plan:
    """Draw the plan of an episode. The same arguments always give the same plan.

    Args:
        kept: a town that other episodes share, so that excursions lead only where nothing stands; None: the seed's own,
            where excursions may remove obstacles.
    """
    streams = {name: generator(seed, name) for name in ("looks", "traffic", "sun")}
    layout = draw_layout(preset, seed) if kept is None else kept
    target, layout, excursions = _target_driver(preset, layout, streams["traffic"], clears=kept is None)
    if kept is None and preset.overpasses[1] > 0:
        reach_m = max(_REACH_SHARE * target.cruise_mps * preset.frame_count / preset.rate_hz, _LEAST_REACH_M)
        way = Way(target.route, (target.start_m, target.start_m + reach_m), excursions)
        layout = with_overpasses(layout, preset.overpasses, seed, way)
    if closed_loop and preset.starts_at_turn:
        target = _at_first_turn(target)
    if preset.keeps_apart:
        drivers, looks, motion = _moved_apart(preset, layout, target, excursions, streams)
    else:
        drivers = [target, *_traffic(preset, layout, target, streams["traffic"], _Spaced(target))]
        looks = _draw_looks(preset, len(drivers) - 1, streams["looks"])
        motion = simulate(drivers, preset.frame_count, preset.rate_hz, preset.driver)
    sizes = _sizes_m(looks)
    camera = camera_of(preset)
    events = _events(target.route, excursions, motion)
    drive = Drive(
        motion.position_m[:, TARGET],
        motion.heading_rad[:, TARGET],
        motion.speed_mps[:, TARGET],
        _corners(motion, sizes[TARGET]),
        sizes[TARGET],
    )
    flown = plan_flight(preset, camera, layout, drive, events, closed_loop, seed)
    return Plan(
        preset,
        seed,
        closed_loop,
        camera,
        layout,
        looks,
        sizes,
        tuple(driver.route for driver in drivers),
        motion,
        excursions,
        flown.air,
        tuple(flown.pulses),
        flown.camera_poses,
        float(streams["sun"].uniform(-np.pi, np.pi)),
        float(np.deg2rad(streams["sun"].uniform(*preset.sun_elevation_deg))),
        _passers_by(preset, layout, motion, sizes, seed),
    )


def _moved_apart(
    preset: RoadTown,
    layout: Layout,
    target: Driver,
    excursions: tuple[Excursion, ...],
    streams: dict[str, np.random.Generator],
) -> tuple[list[Driver], tuple[Look, ...], Motion]:
    """Return drivers, looks and motion of vehicles that never touch."""
    looks = _draw_looks(preset, preset.traffic_cars, streams["looks"])
    sizes = _sizes_m(looks)
    start = _Apart(looks, sizes)
    start.room.take(target, sizes[TARGET], excursions)
    drivers = [target, *_traffic(preset, layout, target, streams["traffic"], start)]
    motion, kept = simulate_apart(
        drivers, sizes[: len(drivers)], preset.frame_count, preset.rate_hz, preset.driver, excursions
    )
    return [drivers[car] for car in kept], tuple(looks[car] for car in kept), motion


def _passers_by(
    preset: RoadTown, layout: Layout, motion: Motion, sizes_m: NDArray[np.float64], seed: int
) -> PassersBy | None:
    numbers = {"person": preset.people, "cyclist": preset.cyclists}
    if not any(most for _, most in numbers.values()):
        return None
    path_m = motion.position_m[:, TARGET]
    return draw_passers_by(layout, motion, sizes_m, path_m, numbers, preset.rate_hz, generator(seed, "passers-by"))


def _draw_looks(preset: RoadTown, others: int, rng: np.random.Generator) -> tuple[Look, ...]:
    model, paint = draw_car(preset.vehicles, rng)
    if preset.target_vehicle not in ("any", model):
        model, paint = preset.target_vehicle, livery(preset.target_vehicle, paint, rng)
    target = Look(model, paint)
    looks = [target]
    for k in range(others):
        if preset.traffic_looks == "twins" and k % 2 == 0:
            looks.append(target)
            continue
        paint = draw_paint(rng)
        while paint == target.paint_rgb:
            paint = draw_paint(rng)
        model = draw_model(preset.vehicles, rng)
        looks.append(Look(model, livery(model, paint, rng, target.paint_rgb)))
    return tuple(looks)


def _sizes_m(looks: tuple[Look, ...]) -> NDArray[np.float64]:
    return np.array([vehicle(look.model, look.paint_rgb).size_m for look in looks], dtype=float)


def _target_driver(
    preset: RoadTown, layout: Layout, rng: np.random.Generator, *, clears: bool
) -> tuple[Driver, Layout, tuple[Excursion, ...]]:
    """Return the target's driver, the layout without obstacles on its route, and its excursions.

    Args:
        clears: whether obstacles may be removed for an excursion.
    """
    cruise = float(rng.uniform(*preset.cruise_mps))
    needed = 1.15 * cruise * preset.frame_count / preset.rate_hz
    route = random_route(
        layout.graph,
        rng,
        needed + (900.0 if preset.start_before_bend else 150.0),
        keep_within_m=0.33 * preset.extent_m,
        turn_preference=preset.turn_preference,
    )
    start = (
        _start_before_bend(preset, route, needed, cruise) if preset.start_before_bend else float(rng.uniform(5.0, 60.0))
    )
    excursions: list[Excursion] = []
    wanted = int(rng.integers(preset.excursions[0], preset.excursions[1] + 1))
    for k in range(wanted):
        # Bends and stops cost time: the car drives about two thirds of the distance at cruising speed.
        share = 0.65 * needed / wanted
        route, layout, excursion = with_excursion(
            route,
            layout,
            rng,
            between_m=(start + max(k * share, 3.0 * cruise), start + (k + 1) * share + 20.0),
            aside_m=EXCURSION_ASIDE_M,
            along_m=EXCURSION_ALONG_M,
            clears=clears,
        )
        if excursion is not None:
            excursions.append(excursion)
    return Driver(route, start, cruise, _stops(preset, route, start, rng)), layout, tuple(excursions)


def _at_first_turn(driver: Driver) -> Driver:
    """Return a driver who starts from rest before the first turn of the route, as after a halt at that crossing."""
    turns = [
        passage.enter_m
        for passage in driver.route.passages
        if passage.is_turn and passage.enter_m > STARTS_BEFORE_TURN_M
    ]
    start_m = turns[0] - STARTS_BEFORE_TURN_M if turns else driver.start_m
    later = tuple(stop for stop in driver.stops if stop[0] > start_m + STARTS_BEFORE_TURN_M)
    return replace(driver, start_m=start_m, stops=later, start_mps=0.0)


def _start_before_bend(preset: RoadTown, route: Route, needed_m: float, cruise_mps: float) -> float:
    """Return the start from which the car reaches the sharpest bend after a straight at its first frame-out."""
    lead_m = cruise_mps * (preset.frame_outs.start_frame or 0) / preset.rate_hz
    arcs = np.arange(lead_m, max(route.length_m - needed_m, lead_m + 1.0), 1.0)
    heading = route.at(arcs)[1]
    bend = np.abs(route.at(arcs + 32.0)[1] - heading)
    before = np.abs(heading - route.at(arcs - lead_m)[1])
    at_crossing = np.zeros(len(arcs), dtype=bool)
    for passage in route.passages:
        at_crossing |= (arcs > passage.enter_m - 45.0) & (arcs < passage.leave_m + 0.5 * lead_m)
    return float(arcs[np.argmax(bend - 1.5 * before - 10.0 * at_crossing)] - lead_m)


def _stops(preset: RoadTown, route: Route, start_m: float, rng: np.random.Generator) -> tuple[tuple[float, float], ...]:
    """Return halts (arc length, seconds) at the entries of some crossings."""
    return tuple(
        (passage.enter_m, float(rng.uniform(*STOP_S)))
        for passage in route.passages
        if rng.random() < preset.stop_share and passage.enter_m > start_m + 10.0
    )


class _Room(Protocol):
    """What decides where the next of the other cars may start."""

    def cruise_share(self, car: int) -> float:
        """Return the speed of a car on a free straight, as a share of that drawn."""
        ...

    def is_free(self, car: int, driver: Driver) -> bool:
        """Return whether a car may start where its driver does."""
        ...

    def take(self, car: int, driver: Driver) -> None:
        """Let it start there."""
        ...


class _Spaced:
    """Cars start so far apart that one of usual length stops behind another."""

    def __init__(self, target: Driver) -> None:
        self._places = [_start_m(target)]

    def cruise_share(self, car: int) -> float:
        return 1.0

    def is_free(self, car: int, driver: Driver) -> bool:
        return bool(np.linalg.norm(np.array(self._places) - _start_m(driver), axis=1).min() >= _SPAWN_GAP_M)

    def take(self, car: int, driver: Driver) -> None:
        self._places.append(_start_m(driver))


class _Apart:
    """Vehicles start so that none can touch another."""

    def __init__(self, looks: tuple[Look, ...], size_m: NDArray[np.float64]) -> None:
        self.room = Room()
        self._looks, self._size_m = looks, size_m

    def cruise_share(self, car: int) -> float:
        return CRUISES_AT[class_of(self._looks[car].model)]

    def is_free(self, car: int, driver: Driver) -> bool:
        return self.room.is_free(driver, self._size_m[car])

    def take(self, car: int, driver: Driver) -> None:
        self.room.take(driver, self._size_m[car])


def _start_m(driver: Driver) -> NDArray[np.float64]:
    return driver.route.at(np.array(driver.start_m))[0]


def _traffic(preset: RoadTown, layout: Layout, target: Driver, rng: np.random.Generator, room: _Room) -> list[Driver]:
    """Return the other cars' drivers, as many as there is room for; they start near the target's path."""
    span = np.linspace(target.start_m, target.route.length_m, 60)
    path = target.route.at(span)[0]
    drivers: list[Driver] = []
    draws = 0
    while len(drivers) < preset.traffic_cars and draws < _MOST_DRAWS:
        draws += 1
        cruise = float(rng.uniform(*preset.cruise_mps))
        length = 1.15 * cruise * preset.frame_count / preset.rate_hz
        route = random_route(
            layout.graph, rng, length + 120.0, keep_within_m=0.42 * preset.extent_m, turn_preference=1.0
        )
        start = float(rng.uniform(2.0, 110.0))
        car = TARGET + 1 + len(drivers)
        driver = Driver(route, start, cruise * room.cruise_share(car))
        if not room.is_free(car, driver):
            continue
        # The further from the target's path, the less likely a car is kept: cars outside the picture are useless.
        distance = np.linalg.norm(path - route.at(np.array(start))[0], axis=1).min()
        if rng.random() < min(1.0, distance / _NEAR_TARGET_M) ** 2:
            continue
        room.take(car, driver)
        drivers.append(replace(driver, stops=_stops(preset, route, start, rng)))
        draws = 0
    return drivers


def _events(route: Route, excursions: tuple[Excursion, ...], motion: Motion) -> dict[str, list[int]]:
    """Return the frames at which the target starts to turn at a crossing, or to leave the road."""
    arc = motion.arc_m[:, TARGET]

    def frame_at(place_m: float) -> list[int]:
        frame = int(np.searchsorted(arc, place_m))
        return [frame] if 0 < frame < len(arc) else []

    return {
        "turn": [f for p in route.passages if p.is_turn for f in frame_at(p.enter_m)],
        "excursion": [f for e in excursions for f in frame_at(e.leave_m + 4.0)],
    }


def _corners(motion: Motion, size_m: NDArray[np.float64]) -> NDArray[np.float64]:
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
    local = signs * size_m
    c, s = np.cos(motion.heading_rad[:, TARGET, None]), np.sin(motion.heading_rad[:, TARGET, None])
    x = motion.position_m[:, TARGET, 0, None] + c * local[:, 0] - s * local[:, 1]
    y = motion.position_m[:, TARGET, 1, None] + s * local[:, 0] + c * local[:, 1]
    return np.stack([x, y, np.broadcast_to(local[:, 2], x.shape)], axis=-1)
