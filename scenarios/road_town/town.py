"""The world of a town, built from its layout."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from scenarios.objects import Standing
from scenarios.road_town.canvas import rings_of
from scenarios.road_town.countryside import add_countryside
from scenarios.road_town.ground import paint_ground
from scenarios.road_town.layout import Layout
from scenarios.road_town.palette import KERB, Rgb, draw_paint
from scenarios.road_town.road_map import road_area
from sim.mesh import Texture, TexturedMesh
from sim.meshes.ground import ground, kerb
from sim.meshes.house import house
from sim.meshes.tree import tree
from sim.meshes.vehicle import VEHICLES, vehicle
from sim.pose import pose_on_ground
from sim.rng import generator
from sim.world import Body, World

_KERB_SIZE_M = (0.3, 0.04)
_KERB_BEVEL_M = 0.1
"""Upright sides and the shadows of a higher kerb are a fraction of a pixel wide, and break up into dark dots."""
_KERB_TOLERANCE_M = 0.06
_KERB_PIECE_M = 25.0
_KERB_PIECE_CORNERS = 12
_KINDS_OF_TREES = 12

_latest: tuple[tuple[object, ...], list[tuple[Body, NDArray[np.float64]]]] | None = None
"""What the latest town was drawn from, and its static objects with poses. Threads share it: each reads it once."""


def town_of(seed: int, layout: Layout) -> World:
    """Return a new world of an episode's town.

    Drawing it takes two thirds of the time before the first picture, so the latest town is kept: the same seed often
    comes again at once, with another controller or preset, or for the report.

    Args:
        seed: of the episode. layout: its streets, buildings and trees.
    """
    global _latest
    # The bytes stand for the content: layouts hold arrays, which have no hash.
    key, latest = (pickle.dumps(layout), seed, tuple(VEHICLES)), _latest
    if latest is None or latest[0] != key:
        # Let go before drawing, so that two towns need not be held at a time.
        latest = _latest = None
        world = build_town(layout, generator(seed, "town"))
        _latest = key, list(zip(world.bodies, world.poses, strict=True))
        return world
    world = World()
    for body, T_world_body in latest[1]:
        world.add(body.mesh, T_world_body, name=body.name, category=body.category, kind=body.kind)
    return world


def forget_town() -> None:
    """Draw the next town anew, also if it is the latest one."""
    global _latest
    _latest = None


def build_town(layout: Layout, rng: np.random.Generator) -> World:
    """Return the world of a town with all its static objects."""
    world = World()
    town = Texture(paint_ground(layout, rng), smooth=True)
    world.add(ground(layout.extent_m, town), np.eye(4), name="ground", category="ground")
    add_countryside(world, layout.extent_m, rng)
    add_kerbs(world, layout)
    for k, building in enumerate(layout.buildings):
        mesh = house(building.size_m, building.roof, building.wall_rgb, building.roof_rgb, rng)
        pose = pose_on_ground(*building.centre_m, building.yaw_rad)
        world.add(mesh, pose, name=f"building-{k}", category="building")
    # Building a tree takes milliseconds, so a dozen are reused, scaled and turned.
    grown = [tree(1.0, float(rng.uniform(2.3, 3.2)), rng) for _ in range(_KINDS_OF_TREES)]
    for k, planted in enumerate(layout.trees):
        mesh = _scaled(grown[int(rng.integers(len(grown)))], planted.radius_m)
        pose = pose_on_ground(*planted.centre_m, float(rng.uniform(-np.pi, np.pi)))
        world.add(mesh, pose, name=f"tree-{k}", category="tree")
    _park_cars(world, layout, rng)
    return world


def add_vehicle(world: World, name: str, model: str, paint_rgb: Rgb) -> Body:
    """Add a movable car at the origin."""
    return world.add(vehicle(model, paint_rgb), np.eye(4), name=name, category="vehicle", movable=True)


def _park_cars(world: World, layout: Layout, rng: np.random.Generator) -> None:
    """Put cars into the taken bays, slightly askew, some backwards."""
    models = list(VEHICLES)
    bays = [bay for park in layout.car_parks for bay, taken in zip(park.bays, park.taken, strict=True) if taken]
    for k, (x, y, facing) in enumerate(bays):
        model = models[int(rng.integers(len(models)))]
        mesh = vehicle(model, draw_paint(rng))
        yaw = facing + np.pi * float(rng.random() < 0.3) + float(rng.normal(0.0, 0.02))
        place = np.array([x, y]) + rng.normal(0.0, (0.1, 0.1))
        pose = pose_on_ground(place[0], place[1], yaw)
        world.add(mesh, pose, name=f"parked-{k}", category="vehicle", kind=model)


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
