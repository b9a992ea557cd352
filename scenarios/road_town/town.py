"""The world of a town, built from its layout."""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from scenarios.objects import Standing
from scenarios.road_town.blocks import BUILDING_SIDES_M
from scenarios.road_town.canvas import KERB, Canvas, Rgb, rings_of
from scenarios.road_town.fleet import draw_car
from scenarios.road_town.ground import TEXTURE_PX, paint_countryside, paint_ground
from scenarios.road_town.layout import Layout
from scenarios.road_town.overpasses import add_overpasses
from scenarios.road_town.passers_by import PassersBy
from scenarios.road_town.road_map import road_area
from scenarios.road_town.seasons import LOOKS, Season, strew_leaves, turn_ground
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets
from sim.meshes.file import mesh_of_file, names_mesh_file
from sim.meshes.ground import ground, kerb, surroundings
from sim.meshes.house import house
from sim.meshes.lamp_post import lamp_post
from sim.meshes.pedestrian import PEDESTRIAN_PARTS, cyclist, pedestrian, pedestrian_poses
from sim.meshes.street_props import add_prop, props_texture
from sim.meshes.tree import bare_tree, tree
from sim.meshes.varied_house import varied_house
from sim.meshes.vehicle import CARS, kind_of, vehicle
from sim.meshes.woodland import hedge, wood
from sim.pose import pose_on_ground
from sim.rng import generator
from sim.world import Body, World

LEAST_VALLEY_RADIUS_M, _BEYOND_CORNERS_M = 720.0, 20.0
"""Least radius of the valley, and its least way beyond the corners of the town's square."""
TO_CREST_M = 510.0
"""Distance from the valley's edge to the crest."""
_TO_END_M = 630.0
"""Distance from the valley's edge to the land's, where it is nearest."""
HILLS_M = (125.0, 175.0)
"""Lowest and highest crest above the town: a helicopter flies at most 100 m high."""
_WAVES = 5
_FIELDS_SHARE = 4
"""The town's ground has so many times as many texels along a side as a tile of land of the same size."""
_FIELDS_A_TILE = 30
_WOODS, _HEDGES = 34, 44
_WOODS_FROM_M, _HEDGES_FROM_M = 40.0, 12.0
"""Free ground between the town's square and the nearest wood or hedge."""


class Hills:
    """Height of the land around a town.

    Attributes:
        valley_radius_m: of the level land in the middle, which holds the town's square.
    """

    def __init__(self, extent_m: float, rng: np.random.Generator) -> None:
        """``extent_m``: side of the town's square."""
        self.valley_radius_m = max(LEAST_VALLEY_RADIUS_M, extent_m / math.sqrt(2.0) + _BEYOND_CORNERS_M)
        self._counts = rng.integers(2, 9, _WAVES)
        self._phases = rng.uniform(0.0, 2.0 * np.pi, _WAVES)

    def height_m(self, x_m: ArrayLike, y_m: ArrayLike) -> NDArray[np.float64]:
        """Return heights above the town at places; 0 in the valley."""
        x, y = np.asarray(x_m, dtype=float), np.asarray(y_m, dtype=float)
        share = np.clip((np.hypot(x, y) - self.valley_radius_m) / TO_CREST_M, 0.0, 1.0)
        angle = np.arctan2(y, x)[..., None]
        wave = 0.5 + 0.5 * np.sin(self._counts * angle + self._phases).mean(axis=-1)
        crest = HILLS_M[0] + (HILLS_M[1] - HILLS_M[0]) * wave
        return np.asarray(crest * share**2 * (3.0 - 2.0 * share))


def add_countryside(
    world: World,
    extent_m: float,
    rng: np.random.Generator,
    ground_px: int = TEXTURE_PX,
    season: Season = "summer",
) -> None:
    """Add the land around a town's square of side ``extent_m``, whose picture has ``ground_px`` x ``ground_px``."""
    hills, colours = Hills(extent_m, rng), LOOKS[season].foliage
    picture = paint_countryside(extent_m, rng, ground_px // _FIELDS_SHARE, _FIELDS_A_TILE)
    turn_ground(picture, season)
    fields = Texture(picture, smooth=True)
    land = surroundings(extent_m, 2.0 * (hills.valley_radius_m + _TO_END_M), fields, hills.height_m)
    world.add(land, np.eye(4), name="fields", category="ground")
    edge_m = 0.5 * extent_m
    for k in range(_WOODS):
        radius_m = float(rng.uniform(14.0, 46.0))
        centre_m = _place(edge_m + _WOODS_FROM_M + radius_m, 30.0 + 900.0 * (k / _WOODS) ** 1.5, rng)
        foliage = colours[int(rng.integers(len(colours)))]
        world.add(
            wood(centre_m, radius_m, float(rng.uniform(9.0, 16.0)), foliage, hills.height_m, rng),
            np.eye(4),
            name=f"wood-{k}",
            category="wood",
        )
    for k in range(_HEDGES):
        length_m = float(rng.uniform(40.0, 130.0))
        centre_m = _place(edge_m + _HEDGES_FROM_M + 0.5 * length_m, 400.0 * (k / _HEDGES), rng)
        # Along or across the fields.
        yaw_rad = 0.5 * np.pi * int(rng.integers(2)) + float(rng.normal(0.0, 0.15))
        half = 0.5 * length_m * np.array([np.cos(yaw_rad), np.sin(yaw_rad)])
        line_m = np.linspace(centre_m - half, centre_m + half, 2 + int(length_m / 30.0))
        line_m[1:-1] += rng.normal(0.0, 1.5, line_m[1:-1].shape)
        foliage = colours[int(rng.integers(len(colours)))]
        world.add(hedge(line_m, foliage, hills.height_m, rng), np.eye(4), name=f"hedge-{k}", category="hedge")


def _place(clear_m: float, beyond_m: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw a place (2,) on a square ring: ``clear_m`` from the middle on one axis, and up to ``beyond_m`` farther."""
    away_m = clear_m + float(rng.uniform(0.0, beyond_m))
    place = np.array([away_m, float(rng.uniform(-away_m, away_m))]) * rng.choice([-1.0, 1.0], 2)
    return place if rng.random() < 0.5 else place[::-1]


_KERB_SIZE_M = (0.3, 0.04)
_KERB_BEVEL_M = 0.1
"""Upright sides and the shadows of a higher kerb are a fraction of a pixel wide, and break up into dark dots."""
_KERB_TOLERANCE_M = 0.06
_KERB_PIECE_M = 25.0
_KERB_PIECE_CORNERS = 12
_KINDS_OF_TREES = 12
_LARGEST_PARKED_M = (5.4, 2.2)
_ANY_PAINT: Rgb = (128, 128, 128)
_BLOCK_M = 35.0

_latest: tuple[tuple[object, ...], World] | None = None
"""What the latest town was drawn from, and the town. Threads share it: each reads it once."""


def town_of(seed: int, layout: Layout, vehicles: Sequence[str] = CARS, season: Season = "summer") -> World:
    """Return a new world of an episode's town.

    Drawing it takes two thirds of the time before the first picture, so the latest town is kept: the same seed often
    comes again at once, with another controller or preset, or for the report.

    Args:
        seed: of the episode. layout: its streets, buildings and trees. vehicles: models of parked cars.
        season: see ``RoadTown``.
    """
    global _latest
    # The bytes stand for the content: layouts hold arrays, which have no hash.
    key, latest = (pickle.dumps(layout), seed, tuple(vehicles), season), _latest
    if latest is None or latest[0] != key:
        # Let go before drawing, so that two towns need not be held at a time.
        latest = _latest = None
        world = build_town(layout, generator(seed, "town"), vehicles=vehicles, season=season)
        latest = _latest = key, world
    return latest[1].copy()


def forget_town() -> None:
    """Draw the next town anew, also if it is the latest one."""
    global _latest
    _latest = None


def build_town(
    layout: Layout,
    rng: np.random.Generator,
    ground_px: int = TEXTURE_PX,
    vehicles: Sequence[str] = CARS,
    season: Season = "summer",
) -> World:
    """Return the world of a town with all its static objects.

    Args:
        ground_px: side of the picture of the ground.
        vehicles: models of parked cars; those that are too large for a bay stand in none.
        season: see ``RoadTown``; a town is the same one in all of them.
    """
    world, look = World(), LOOKS[season]
    picture = paint_ground(layout, rng, ground_px)
    turn_ground(picture, season)
    if season == "autumn":
        strew_leaves(Canvas(picture, layout.extent_m), layout, rng.spawn(1)[0])
    world.add(ground(layout.extent_m, Texture(picture, smooth=True)), np.eye(4), name="ground", category="ground")
    add_countryside(world, layout.extent_m, rng, ground_px, season)
    add_kerbs(world, layout)
    for k, building in enumerate(layout.buildings):
        if names_mesh_file(building.model):
            mesh = mesh_of_file(building.model, BUILDING_SIDES_M)
        elif building.style is None:
            mesh = house(building.size_m, building.roof, building.wall_rgb, building.roof_rgb, rng)
        else:
            mesh = varied_house(building.size_m, building.style, building.wall_rgb)
        pose = pose_on_ground(*building.centre_m, building.yaw_rad)
        world.add(mesh, pose, name=f"building-{k}", category="building")
    # Building a tree takes milliseconds, so a dozen are reused, scaled and turned.
    grown = [tree(1.0, float(rng.uniform(2.3, 3.2)), rng, look.foliage) for _ in range(_KINDS_OF_TREES)]
    if look.bare_share:
        bare = rng.spawn(1)[0]
        grown = [bare_tree(leafy, bare) if bare.random() < look.bare_share else leafy for leafy in grown]
    for k, planted in enumerate(layout.trees):
        mesh = _scaled(grown[int(rng.integers(len(grown)))], planted.radius_m)
        pose = pose_on_ground(*planted.centre_m, float(rng.uniform(-np.pi, np.pi)))
        world.add(mesh, pose, name=f"tree-{k}", category="tree")
    _park_cars(world, layout, vehicles, rng)
    for k, lamp in enumerate(layout.lamps):
        world.add(lamp_post(), pose_on_ground(*lamp.centre_m, lamp.yaw_rad), name=f"lamp-{k}", category="lamp")
    add_props(world, layout)
    add_overpasses(world, layout)
    return world


def add_props(world: World, layout: Layout) -> None:
    """Add hedges, signs and the like, all those of a square of ``_BLOCK_M`` as one body."""
    blocks: dict[tuple[int, int], Facets] = {}
    for prop in layout.props:
        x, y = (math.floor(place / _BLOCK_M) for place in prop.centre_m)
        facets = blocks.setdefault((x, y), Facets())
        add_prop(facets, prop.kind, prop.size_m, prop.centre_m, prop.yaw_rad, prop.variant)
    for (x, y), facets in blocks.items():
        world.add(facets.mesh(props_texture()), np.eye(4), name=f"props {x} {y}", category="props")


def add_vehicle(world: World, name: str, model: str, paint_rgb: Rgb) -> Body:
    """Add a movable car at the origin."""
    return world.add(vehicle(model, paint_rgb), np.eye(4), name=name, category="vehicle", movable=True)


class PassersByBodies:
    """The bodies of people and cyclists.

    Attributes:
        standing: of each what labels need.
    """

    def __init__(self, world: World, passers_by: PassersBy) -> None:
        """Add them to a world, at the origin."""
        self._world, self._passers_by = world, passers_by
        self.standing: list[Standing] = []
        for k, (kind, look) in enumerate(zip(passers_by.kinds, passers_by.looks, strict=True)):
            name = f"{kind}-{k}"
            parts = (cyclist(look),) if kind == "cyclist" else pedestrian(look)
            bodies = [
                world.add(mesh, np.eye(4), name=f"{name} {part}", category="passer-by", movable=True, kind=kind)
                for mesh, part in zip(parts, PEDESTRIAN_PARTS, strict=False)
            ]
            self.standing.append(Standing(bodies[0], name, kind, bodies[0].mesh, tuple(bodies[1:])))
        ride = np.array([kind == "cyclist" for kind in passers_by.kinds], np.bool_)
        self._walkers, self._riders = np.flatnonzero(~ride), np.flatnonzero(ride)
        self._stature_m = np.array([passers_by.looks[k].stature_m for k in self._walkers])
        order = (*self._walkers, *self._riders)
        self._bodies = [body for k in order for body in (self.standing[k].body, *self.standing[k].limbs)]

    def move(self, frame: int) -> None:
        """Move all to where they are on a frame."""
        passers_by, walkers = self._passers_by, self._walkers
        T_world, phase_rad = passers_by.T_world[frame], passers_by.phase_rad[frame, walkers]
        speed_mps = passers_by.speed_mps[frame, walkers]
        walking = pedestrian_poses(self._stature_m, T_world[walkers], phase_rad, speed_mps)
        self._world.move_all(self._bodies, np.concatenate([walking.reshape(-1, 4, 4), T_world[self._riders]]))


def _park_cars(world: World, layout: Layout, vehicles: Sequence[str], rng: np.random.Generator) -> None:
    """Put cars into the taken bays, slightly askew, some backwards."""
    models = [model for model in vehicles if (vehicle(model, _ANY_PAINT).size_m[:2] <= _LARGEST_PARKED_M).all()]
    bays = [bay for park in layout.car_parks for bay, taken in zip(park.bays, park.taken, strict=True) if taken]
    for k, (x, y, facing) in enumerate(bays if models else ()):
        model, paint = draw_car(models, rng)
        mesh = vehicle(model, paint)
        yaw = facing + np.pi * float(rng.random() < 0.3) + float(rng.normal(0.0, 0.02))
        place = np.array([x, y]) + rng.normal(0.0, (0.1, 0.1))
        pose = pose_on_ground(place[0], place[1], yaw)
        world.add(mesh, pose, name=f"parked-{k}", category="vehicle", kind=kind_of(model))


def parked_cars(world: World) -> list[Standing]:
    """Return the cars that stand in the bays of a town."""
    return [Standing(body, body.name, body.kind, body.mesh) for body in world.bodies if body.kind and not body.movable]


def _scaled(mesh: TexturedMesh, factor: float) -> TexturedMesh:
    return replace(mesh, vertices_m=(factor * mesh.vertices_m).astype(np.float32))


def add_kerbs(world: World, layout: Layout) -> None:
    """Add the kerbs around the carriageways, in pieces that renderers can cull."""
    pieces = 0
    for ring in rings_of(road_area(layout.graph).simplify(_KERB_TOLERANCE_M)):
        corners = shapely.get_coordinates(ring.segmentize(_KERB_PIECE_M))
        for start in range(0, len(corners) - 1, _KERB_PIECE_CORNERS):
            part = corners[start : start + _KERB_PIECE_CORNERS + 1]
            piece = kerb(part, *_KERB_SIZE_M, KERB, bevel_m=_KERB_BEVEL_M)
            world.add(piece, np.eye(4), name=f"kerb-{pieces}", category="kerb")
            pieces += 1
