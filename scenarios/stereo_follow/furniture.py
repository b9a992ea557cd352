"""Furniture: a group of desks in the middle of the hall, pieces along the walls, planters in the yard.

People and robot keep out of the group (``FloorPlan.island``); all else stands within the margins that they leave at
walls anyway. Pieces are bodies lit like people; their tops also stand in the way of baked light, so that lamps cast
soft shadows of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.building import Blocker, Building
from scenarios.stereo_follow.floor_plan import Area, FloorPlan
from scenarios.stereo_follow.panels import RGB, door_leaf, panel, poster
from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv
from sim.meshes.tree import tree
from sim.pose import pose_on_ground

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Two opposite corners."""

_KEPT_M = 0.45
"""Distance that people keep from furniture in the middle of a room."""
_STRIP_M = 1.0
"""Least width of the free strips around the group of desks."""
_PLANT_M, _PLANT_AT_M = 0.24, 0.16
"""Radius of a plant at an end of the desks, and its distance from them."""
_DESK_M, _CHAIR_M = (1.6, 0.8, 0.74), 0.62
_WOODS_RGB: tuple[RGB, ...] = ((176, 140, 98), (120, 84, 58), (206, 200, 190), (150, 118, 84))
_METAL_RGB, _DARK_RGB, _WHITE_RGB = (120, 124, 128), (40, 42, 46), (224, 224, 220)
_CLOTHS_RGB: tuple[RGB, ...] = ((52, 60, 84), (60, 62, 64), (140, 60, 52), (70, 96, 84))
_POTS_RGB: tuple[RGB, ...] = ((150, 92, 66), (70, 72, 76), (206, 202, 194))
_BOOKS_RGB: tuple[RGB, ...] = (
    (150, 44, 44),
    (48, 78, 120),
    (206, 180, 90),
    (60, 100, 70),
    (220, 214, 200),
    (60, 48, 60),
)


class Piece(NamedTuple):
    """A piece of furniture.

    Attributes:
        name: of its body.
        mesh: its front is the side towards +y, its back at y = 0 where it stands at a wall.
        size_m: length along x, depth along y, height. low_m: height above the ground.
        has_top: whether it has one that stands in the way of light.
    """

    name: str
    mesh: TexturedMesh
    size_m: tuple[float, float, float]
    low_m: float = 0.0
    has_top: bool = False


def furnished(building: Building, rng: np.random.Generator) -> Building:
    """Return a building with furniture."""
    plan = building.plan
    taken = [_bounds(piece) for piece in building.panels if not _is_shell(piece.name)]
    island, placed = _group_of_desks(plan, rng)
    for wall, way in _walls(plan):
        placed += _along_wall(wall, way, taken, rng)
    bodies: list[tuple[str, TexturedMesh, NDArray[np.float64]]] = []
    blockers: list[Blocker] = []
    for piece, pose in placed:
        bodies.append((piece.name, piece.mesh, pose))
        blockers += _blockers(piece, pose)
    return replace(building, plan=replace(plan, island=island), furniture=tuple(bodies), blockers=tuple(blockers))


Placed = tuple[Piece, NDArray[np.float64]]


def _group_of_desks(plan: FloorPlan, rng: np.random.Generator) -> tuple[Area, list[Placed]]:
    """Draw one or two pairs of desks face to face with their chairs; return the area that is kept free of people."""
    within = plan.free_area("hall").shrunk(_STRIP_M)
    beyond_m = _PLANT_AT_M + _PLANT_M if rng.random() < 0.7 else 0.0
    pairs = 2 if within.x1 - within.x0 > 2 * (_DESK_M[0] + beyond_m + _KEPT_M) + 0.1 and rng.random() < 0.6 else 1
    half_x = 0.5 * pairs * _DESK_M[0] + beyond_m + _KEPT_M
    half_y = _DESK_M[1] + _CHAIR_M + _KEPT_M
    low, high = np.array([within.x0 + half_x, within.y0 + half_y]), np.array([within.x1 - half_x, within.y1 - half_y])
    middle = 0.5 * (low + high) + rng.uniform(-0.5, 0.5, 2) * np.maximum(high - low, 0.0)
    half_y = min(half_y, 0.5 * (within.y1 - within.y0))
    x_m, y_m = middle.tolist()
    island = Area(x_m - half_x, y_m - half_y, x_m + half_x, y_m + half_y)
    wood, cloth = _one(_WOODS_RGB, rng), _one(_CLOTHS_RGB, rng)
    placed: list[Placed] = []
    for k in range(pairs):
        at_m = x_m + (k - 0.5 * (pairs - 1)) * _DESK_M[0]
        for side in (-1.0, 1.0):
            heading = 0.0 if side > 0 else np.pi
            placed.append((_desk(wood, rng), pose_on_ground(at_m, y_m, heading)))
            if rng.random() < 0.85:
                away = _DESK_M[1] - 0.1 + 0.5 * _CHAIR_M + rng.uniform(-0.1, 0.08)
                turn = heading + rng.normal(0.0, 0.35)
                placed.append(
                    (_chair(cloth), pose_on_ground(x_m + rng.normal(0.0, 0.1), middle[1] + side * away, turn))
                )
    if beyond_m:
        end = rng.choice([-1.0, 1.0]) * (0.5 * pairs * _DESK_M[0] + _PLANT_AT_M)
        placed.append((_plant(_PLANT_M, rng.uniform(0.8, 1.1), rng), pose_on_ground(x_m + end, y_m, 0.0)))
    return island, placed


class _Way(NamedTuple):
    """A wall's line: start, unit vector along it and into the room, both (2,), and its length."""

    start_m: NDArray[np.float64]
    along: NDArray[np.float64]
    inwards: NDArray[np.float64]
    length_m: float


def _walls(plan: FloorPlan) -> Iterator[tuple[str, _Way]]:
    """Yield the long walls of corridor and hall, and the sides of the yard but for the facade's door."""
    x, y = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    for room in ("corridor", "hall", "yard"):
        area = plan.rooms[room]
        long_m = area.x1 - area.x0
        yield room, _Way(np.array([area.x0, area.y0]), x, y, long_m)
        yield room, _Way(np.array([area.x1, area.y1]), -x, -y, long_m)
    yard = plan.yard
    yield "yard", _Way(np.array([yard.x1, yard.y0]), y, -x, yard.y1 - yard.y0)


def _along_wall(room: str, way: _Way, taken: list[Box], rng: np.random.Generator) -> list[Placed]:
    """Draw pieces along a wall, none in another one or in what hangs there."""
    placed: list[Placed] = []
    at_m = float(rng.uniform(0.5, 1.2))
    while at_m < way.length_m - 1.2:
        piece = _for_wall(room, rng)
        length_m, depth_m, height_m = piece.size_m
        place_m = way.start_m + (at_m + 0.5 * length_m) * way.along + 0.015 * way.inwards
        corners_m = place_m + np.outer([-0.5, 0.5], length_m * way.along) + np.outer([0.0, 1.0], depth_m * way.inwards)
        low, high = corners_m.min(axis=0) - 0.06, corners_m.max(axis=0) + 0.06
        box: Box = ((*low.tolist(), piece.low_m), (*high.tolist(), piece.low_m + height_m))
        fits = at_m + length_m < way.length_m - 0.5
        if fits and not any(_overlap(box, other) for other in taken):
            taken.append(box)
            x_m, y_m = place_m.tolist()
            T = pose_on_ground(x_m, y_m, float(np.arctan2(-way.inwards[0], way.inwards[1])))
            T[2, 3] = piece.low_m
            placed.append((piece, T))
            at_m += length_m
        at_m += float(rng.uniform(0.2, 0.9) if room == "hall" else rng.uniform(0.8, 2.6))
    return placed


def _for_wall(room: str, rng: np.random.Generator) -> Piece:
    """Draw a piece for a wall of a room; those of a corridor are flat."""
    kind = rng.random()
    if room == "yard":
        return _planter(rng)
    if room == "corridor":
        return _radiator(rng) if kind < 0.35 else _picture(rng)
    if kind < 0.2:
        return _cabinet(rng)
    if kind < 0.4:
        return _shelf(rng)
    if kind < 0.55:
        return _against_wall(_plant(0.3, rng.uniform(1.0, 1.7), rng))
    if kind < 0.7:
        return _radiator(rng)
    return _picture(rng) if kind < 0.9 else _closed_door(rng)


def _desk(wood: RGB, rng: np.random.Generator) -> Piece:
    x, y, z = _DESK_M
    colours = (wood, _METAL_RGB, _DARK_RGB, _WHITE_RGB)
    facets = Facets()
    facets.box((-0.5 * x + 0.01, 0.01, z - 0.03), (0.5 * x - 0.01, y, z), _uv(0, colours))
    for side in (-1.0, 1.0):
        post = side * (0.5 * x - 0.06)
        facets.box((post - 0.02, 0.06, 0.0), (post + 0.02, y - 0.08, z - 0.03), _uv(1, colours))
    facets.box((-0.5 * x + 0.08, 0.03, 0.3), (0.5 * x - 0.08, 0.05, z - 0.03), _uv(0, colours))
    screen = float(rng.uniform(-0.35, 0.35))
    facets.box((screen - 0.03, 0.14, z), (screen + 0.03, 0.18, z + 0.12), _uv(1, colours))
    facets.box((screen - 0.27, 0.13, z + 0.1), (screen + 0.27, 0.16, z + 0.43), _uv(2, colours))
    facets.box((screen - 0.22, 0.42, z), (screen + 0.22, 0.56, z + 0.02), _uv(2, colours))
    for _ in range(int(rng.integers(0, 4))):
        at, depth = rng.uniform(-0.6, 0.6), rng.uniform(0.2, 0.6)
        facets.box((at - 0.11, depth - 0.1, z), (at + 0.11, depth + 0.1, z + rng.uniform(0.01, 0.1)), _uv(3, colours))
    return Piece("desk", facets.mesh(palette(colours)), _DESK_M, has_top=True)


def _chair(cloth: RGB) -> Piece:
    """Return a chair whose back is towards +y."""
    colours = (cloth, _DARK_RGB)
    facets = Facets()
    facets.box((-0.23, -0.22, 0.43), (0.23, 0.22, 0.5), _uv(0, colours))
    facets.box((-0.21, 0.19, 0.55), (0.21, 0.25, 0.98), _uv(0, colours))
    facets.box((-0.03, 0.2, 0.45), (0.03, 0.23, 0.6), _uv(1, colours))
    for x in (-0.2, 0.2):
        for y in (-0.19, 0.19):
            facets.box((x - 0.018, y - 0.018, 0.0), (x + 0.018, y + 0.018, 0.43), _uv(1, colours))
    return Piece("chair", facets.mesh(palette(colours)), (0.46, 0.47, 0.98))


def _plant(radius_m: float, height_m: float, rng: np.random.Generator) -> Piece:
    """Return a plant in a pot, about its middle."""
    pot = _pot(0.6 * radius_m, 0.32, _one(_POTS_RGB, rng))
    leaves = tree(radius_m, max(height_m, radius_m + 0.1), rng)
    size_m = (2 * radius_m, 2 * radius_m, height_m)
    return Piece("plant", _together(pot, leaves), size_m)


def _pot(radius_m: float, height_m: float, rgb: RGB) -> TexturedMesh:
    angle = 2.0 * np.pi * np.arange(12) / 12
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = [np.column_stack([share * radius_m * circle, np.full(12, z)]) for share, z in ((0.8, 0.0), (1.0, height_m))]
    facets = Facets()
    uv = swatch_uv(0, 1)
    facets.loft(np.array(rings), lambda segment, side: uv, uv, uv)
    return facets.mesh(palette([rgb]))


def _together(one: TexturedMesh, other: TexturedMesh) -> TexturedMesh:
    """Return two meshes as one: their textures stand one above the other, the first one's in its mean colour."""
    rgb = other.texture.rgb
    strip = np.broadcast_to(one.texture.rgb.mean(axis=(0, 1)).astype(np.uint8), (8, rgb.shape[1], 3))
    texture = replace(other.texture, rgb=np.ascontiguousarray(np.concatenate([strip, rgb])))
    share = 8 / len(texture.rgb)
    below = other.uv * np.array([1.0, 1.0 - share], np.float32) + np.array([0.0, share], np.float32)
    above = np.broadcast_to(np.array([0.5, 0.5 * share], np.float32), one.uv.shape)
    return TexturedMesh(
        np.concatenate([one.vertices_m, other.vertices_m]),
        np.concatenate([one.normals, other.normals]),
        np.concatenate([above, below]).astype(np.float32),
        np.concatenate([one.faces, other.faces + len(one.vertices_m)]).astype(np.int32),
        texture,
    )


def _against_wall(piece: Piece) -> Piece:
    """Return a piece that was about its middle with its back at y = 0."""
    moved = piece.mesh.vertices_m + np.array([0.0, 0.5 * piece.size_m[1] + 0.05, 0.0], np.float32)
    length_m, depth_m, height_m = piece.size_m
    return piece._replace(mesh=replace(piece.mesh, vertices_m=moved), size_m=(length_m, depth_m + 0.1, height_m))


def _planter(rng: np.random.Generator) -> Piece:
    side_m = float(rng.uniform(0.5, 0.8))
    facets = Facets()
    facets.box((-0.5 * side_m, -0.5 * side_m, 0.0), (0.5 * side_m, 0.5 * side_m, 0.45), swatch_uv(0, 1))
    box = facets.mesh(palette([_one(_POTS_RGB, rng)]))
    mesh = _together(box, tree(0.5 * side_m, float(rng.uniform(0.9, 1.5)), rng))
    return _against_wall(Piece("planter", mesh, (side_m, side_m, 1.5)))


def _cabinet(rng: np.random.Generator) -> Piece:
    x, y, z = float(rng.uniform(0.8, 1.2)), 0.45, float(rng.choice((0.8, 1.3, 1.95)))
    colours = (_one((*_WOODS_RGB, _METAL_RGB), rng), _DARK_RGB)
    facets = Facets()
    facets.box((-0.5 * x, 0.0, 0.0), (0.5 * x, y, z), _uv(0, colours))
    facets.box((-0.004, y, 0.06), (0.004, y + 0.004, z - 0.03), _uv(1, colours))
    for side in (-1.0, 1.0):
        facets.box((side * 0.06 - 0.012, y, 0.5 * z), (side * 0.06 + 0.012, y + 0.02, 0.5 * z + 0.14), _uv(1, colours))
    return Piece("cabinet", facets.mesh(palette(colours)), (x, y + 0.02, z), has_top=True)


def _shelf(rng: np.random.Generator) -> Piece:
    x, y, z = float(rng.uniform(0.8, 1.1)), 0.3, float(rng.choice((1.2, 1.9)))
    colours = (_one(_WOODS_RGB, rng), *_BOOKS_RGB)
    facets = Facets()
    for side in (-1.0, 1.0):
        post = side * (0.5 * x - 0.012)
        facets.box((post - 0.012, 0.0, 0.0), (post + 0.012, y, z), _uv(0, colours))
    facets.box((-0.5 * x, 0.0, 0.0), (0.5 * x, 0.012, z), _uv(0, colours))
    for low in np.arange(0.05, z, 0.36).tolist():
        facets.box((-0.5 * x + 0.024, 0.012, low), (0.5 * x - 0.024, y, low + 0.02), _uv(0, colours))
        at = -0.5 * x + 0.04
        while at < 0.5 * x - 0.1 and low + 0.3 < z:
            wide = float(rng.uniform(0.04, 0.16))
            if rng.random() < 0.75:
                book = _uv(1 + int(rng.integers(len(_BOOKS_RGB))), colours)
                facets.box((at, 0.03, low + 0.02), (at + wide - 0.004, y - 0.05, low + rng.uniform(0.2, 0.32)), book)
            at += wide
    facets.box((-0.5 * x, 0.0, z), (0.5 * x, y, z + 0.02), _uv(0, colours))
    return Piece("shelf", facets.mesh(palette(colours)), (x, y, z + 0.02), has_top=True)


def _radiator(rng: np.random.Generator) -> Piece:
    x = float(rng.uniform(0.7, 1.3))
    colours = (_WHITE_RGB, (190, 190, 186))
    facets = Facets()
    facets.box((-0.5 * x, 0.03, 0.0), (0.5 * x, 0.09, 0.55), _uv(1, colours))
    for at in np.arange(-0.5 * x, 0.5 * x - 0.04, 0.075).tolist():
        facets.box((at, 0.09, 0.02), (at + 0.05, 0.105, 0.53), _uv(0, colours))
    return Piece("radiator", facets.mesh(palette(colours)), (x, 0.11, 0.55), low_m=0.15)


def _picture(rng: np.random.Generator) -> Piece:
    size_m = (float(rng.uniform(0.4, 1.1)), float(rng.uniform(0.4, 0.8)))
    return Piece("picture", _hanging(size_m, poster(size_m, rng)), (size_m[0], 0.03, size_m[1]), low_m=1.25)


def _closed_door(rng: np.random.Generator) -> Piece:
    return Piece("door", _hanging((0.9, 2.05), door_leaf(_one(_WOODS_RGB, rng), rng)), (0.9, 0.03, 2.05))


def _hanging(size_m: tuple[float, float], texture: object) -> TexturedMesh:
    """Return an upright rectangle that faces +y."""
    return panel((0.5 * size_m[0], 0.012, 0.0), (-size_m[0], 0.0, 0.0), (0.0, 0.0, size_m[1]), texture)  # type: ignore[arg-type]


def _blockers(piece: Piece, T: NDArray[np.float64]) -> Iterator[Blocker]:
    """Yield both faces of a piece's top, which stand in the way of light: between upright ones it would be dark."""
    if not piece.has_top:
        return
    x, y, z = piece.size_m
    along, ahead = np.array([x, 0.0, 0.0]), np.array([0.0, y, 0.0])
    for height_m, a, b in ((z, along, ahead), (z - 0.03, ahead, along)):
        corner = np.array([-0.5 * x, 0.0, height_m])
        yield T[:3, :3] @ corner + T[:3, 3], T[:3, :3] @ a, T[:3, :3] @ b


def _bounds(piece: object) -> Box:
    corner, a, b = (getattr(piece, name) for name in ("corner_m", "side_a_m", "side_b_m"))
    corners = np.stack([corner, corner + a, corner + b, corner + a + b])
    low, high = corners.min(axis=0), corners.max(axis=0)
    return tuple(low.tolist()), tuple(high.tolist())


def _is_shell(name: str) -> bool:
    return any(word in name for word in ("wall", "floor", "ceiling", "light", "paving", "hedge")) and not any(
        word in name for word in ("door", "poster")
    )


def _overlap(one: Box, other: Box) -> bool:
    return all(one[0][k] < other[1][k] and other[0][k] < one[1][k] for k in range(3))


def _uv(index: int, colours: tuple[RGB, ...]) -> tuple[float, float]:
    return swatch_uv(index, len(colours))


def _one(options: tuple[RGB, ...], rng: np.random.Generator) -> RGB:
    return options[int(rng.integers(len(options)))]
