"""Plane panels of rooms as data, and as bodies and bright areas of a world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenarios.stereo_follow.indoors import WHOLE, Window, panel, plain
from sim.mesh import Texture
from sim.shaders.lamps import BrightArea
from sim.world import Body, World

SHINING = plain((255, 255, 255))
"""Texture of panels that emit light."""

Opening = tuple[float, float, float]
"""Start and end along a wall, and height above the ground."""


@dataclass(frozen=True, eq=False)
class Panel:
    """A rectangle that faces ``side_a x side_b``.

    Attributes:
        name: of its body.
        corner_m, side_a_m, side_b_m: (3,) one corner and the two sides that begin there, world frame.
        texture: with the lower left corner of its ``window`` at ``corner_m``.
        luminance_nit: of its own light; 0 for none.
        temperature_k: colour temperature of that light.
        group: of lights that are switched together.
        window: part of the texture that covers the panel.
    """

    name: str
    corner_m: NDArray[np.float64]
    side_a_m: NDArray[np.float64]
    side_b_m: NDArray[np.float64]
    texture: Texture
    luminance_nit: float = 0.0
    temperature_k: float = 6500.0
    group: str = ""
    window: Window = WHOLE


def new_panel(
    name: str, corner_m: ArrayLike, side_a_m: ArrayLike, side_b_m: ArrayLike, texture: Texture, **light: float | str
) -> Panel:
    """Return a panel from plain numbers; ``light`` are the last three of its attributes."""
    corner, a, b = (np.asarray(each, dtype=float) for each in (corner_m, side_a_m, side_b_m))
    return Panel(name, corner, a, b, texture, **light)  # type: ignore[arg-type]


def add_panel(world: World, piece: Panel) -> Body:
    """Add a panel to a world as a static body."""
    mesh = panel(piece.corner_m, piece.side_a_m, piece.side_b_m, piece.texture, piece.window)
    return world.add(mesh, np.eye(4), name=piece.name, category="building")


def bright_area(instance_id: int, piece: Panel) -> BrightArea:
    """Return the light of a panel that stands in a world as the body ``instance_id``."""
    light = (piece.luminance_nit, piece.temperature_k)
    return BrightArea(instance_id, piece.corner_m, piece.side_a_m, piece.side_b_m, *light)


def wall(
    name: str,
    start_m: tuple[float, float],
    end_m: tuple[float, float],
    height_m: float,
    texture: Texture,
    opening: Opening | None = None,
    offset_m: float = 0.0,
) -> Iterator[Panel]:
    """Yield the panels of an upright wall that faces the right of the line from ``start_m`` to ``end_m``.

    The texture covers the whole wall once; each panel shows its part.

    Args:
        offset_m: distance of the wall before that line.
    """
    start, along = np.array([*start_m, 0.0]), np.array([end_m[0] - start_m[0], end_m[1] - start_m[1], 0.0])
    length_m = float(np.linalg.norm(along))
    along /= length_m
    up = np.array([0.0, 0.0, 1.0])
    start = start + offset_m * np.cross(along, up)
    pieces = [(0.0, length_m, 0.0, height_m)]
    if opening is not None:
        first_m, last_m, top_m = opening
        pieces = [(0.0, first_m, 0.0, height_m), (last_m, length_m, 0.0, height_m), (first_m, last_m, top_m, height_m)]
    for left_m, right_m, low_m, high_m in pieces:
        if right_m - left_m > 1e-6 and high_m - low_m > 1e-6:
            corner = start + left_m * along + low_m * up
            window = (left_m / length_m, low_m / height_m, right_m / length_m, high_m / height_m)
            yield Panel(name, corner, (right_m - left_m) * along, (high_m - low_m) * up, texture, window=window)


def box(
    name: str, middle_m: tuple[float, float], size_m: tuple[float, float, float], texture: Texture, low_m: float = 0.0
) -> Iterator[Panel]:
    """Yield the five visible panels of a box whose bottom is ``low_m`` above the ground: bench, machine, planter."""
    x, y = middle_m[0] - 0.5 * size_m[0], middle_m[1] - 0.5 * size_m[1]
    dx, dy, dz = size_m
    corners = ((x, y), (x + dx, y), (x + dx, y + dy), (x, y + dy))
    for here, there in zip(corners, (*corners[1:], corners[0]), strict=True):
        along = (there[0] - here[0], there[1] - here[1], 0.0)
        yield new_panel(name, (*here, low_m), along, (0.0, 0.0, dz), texture)
    yield new_panel(name, (x, y, low_m + dz), (dx, 0.0, 0.0), (0.0, dy, 0.0), texture)
