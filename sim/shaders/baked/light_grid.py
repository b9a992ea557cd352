"""Light for moving bodies: a grid of ambient cubes over the ground that people walk on.

An ambient cube is the illuminance of surfaces that face the six ways along the axes; what falls on any other surface is
``sum of n_k² E_side(k)`` over the three sides that it faces (McTaggart, "Half-Life 2 / Valve Source shading", 2004).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.shaders.baked.direct import reaches
from sim.shaders.baked.light_maps import Geometry, Lattice, add_between
from sim.shaders.baked.rays import Rectangles, blocked, nearest, sphere_directions
from sim.shaders.lamps import Sources, arriving_per_m2

SPACING_M = 0.7
HEIGHTS_M = (0.3, 1.0, 1.7)
"""Above the ground."""
SIDES = np.concatenate([np.eye(3), -np.eye(3)])
"""Outward normals (6, 3) of a cube's sides."""
_LEVEL = 0.9
_GROUND_RANGE_M = 0.5
_RAYS = sphere_directions(160)


class Grid(NamedTuple):
    """Places of X * Y * Z ambient cubes.

    Attributes:
        first_m: (2,) x and y of the first. steps_m: (2,) along x and y.
        heights_m: (Z,) in the world. columns, rows: X, Y.
        is_open: (Y * X,) bool, with ground below and no wall around. Cube (i, j, k) is number ``(i X + j) Z + k``.
    """

    first_m: NDArray[np.float64]
    steps_m: NDArray[np.float64]
    heights_m: NDArray[np.float64]
    columns: int
    rows: int
    is_open: NDArray[np.bool_]


class Reflecting(NamedTuple):
    """Radiances that the rays of cubes see.

    Attributes:
        where: lattice of ``leaving``, on the first rectangles; the others reflect nothing.
        leaving: (T, C) radiances of samples.
        sky: (2, 3), see ``sky_levels``; sky_channel: first of its three, -1 for none.
    """

    where: Lattice
    leaving: NDArray[np.float32]
    sky: NDArray[np.float64]
    sky_channel: int


def grid_over_ground(geometry: Geometry) -> Grid:
    """Return a grid over the level rectangles near the lowest one's height, open above these."""
    level = np.flatnonzero(geometry.normal[:, 2] > _LEVEL)
    ground_m = float(geometry.corner_m[level, 2].min(initial=np.inf)) if len(level) else 0.0
    level = level[geometry.corner_m[level, 2] < ground_m + _GROUND_RANGE_M]
    corners_m = np.concatenate(
        [
            geometry.corner_m[level] + a * geometry.side_a_m[level] + b * geometry.side_b_m[level]
            for a in (0, 1)
            for b in (0, 1)
        ]
    ).reshape(-1, 3)
    low_m, high_m = (corners_m.min(axis=0), corners_m.max(axis=0)) if len(level) else (np.zeros(3), np.ones(3))
    counts = np.maximum(np.ceil((high_m - low_m)[:2] / SPACING_M).astype(int), 1)
    steps_m = (high_m - low_m)[:2] / counts
    first_m = low_m[:2] + 0.5 * steps_m
    columns, rows = int(counts[0]), int(counts[1])
    heights_m = ground_m + np.array(HEIGHTS_M)
    grid = Grid(first_m, steps_m, heights_m, columns, rows, np.ones(columns * rows, bool))
    across_m = cube_places(grid)[:: len(HEIGHTS_M), :2]
    above = np.zeros(len(across_m), bool)
    for r in level:
        side_a, side_b = geometry.side_a_m[r], geometry.side_b_m[r]
        from_corner = across_m - geometry.corner_m[r, :2]
        u, v = from_corner @ side_a[:2] / (side_a @ side_a), from_corner @ side_b[:2] / (side_b @ side_b)
        above |= (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
    return grid._replace(is_open=above)


def cube_places(grid: Grid) -> NDArray[np.float64]:
    """Return the places (Y * X * Z, 3) of all cubes."""
    y = grid.first_m[1] + grid.steps_m[1] * np.arange(grid.rows)
    x = grid.first_m[0] + grid.steps_m[0] * np.arange(grid.columns)
    y, x, z = (axis.ravel() for axis in np.meshgrid(y, x, grid.heights_m, indexing="ij"))
    return np.column_stack([x, y, z])


def gather(
    obstacles: Rectangles,
    sources: Sources,
    group: NDArray[np.int64],
    seen: Reflecting,
    places_m: NDArray[np.float64],
    is_open: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """Return the cubes (P, 6, C) in lux at open places (P, 3), 0 elsewhere."""
    weights = np.maximum(_RAYS @ SIDES.T, 0.0)
    # Uniform light must give E = pi L on every side.
    weights *= np.pi / weights.sum(axis=0)
    cubes = np.zeros((len(places_m), 6, seen.leaving.shape[1]), np.float32)
    _gather(obstacles, sources, group, seen, places_m, is_open, _RAYS, weights, SIDES, cubes)
    return cubes


@njit(cache=True)
def _gather(
    obstacles: Rectangles,
    sources: Sources,
    group: NDArray[np.int64],
    seen: Reflecting,
    places_m: NDArray[np.float64],
    is_open: NDArray[np.bool_],
    directions: NDArray[np.float64],
    weights: NDArray[np.float64],
    sides: NDArray[np.float64],
    cubes: NDArray[np.float32],
) -> None:
    """``gather``, with the weights (K, 6) of directions (K, 3) on each side."""
    channels = cubes.shape[2]
    radiance, distances = np.empty(channels), np.empty(obstacles.offset.shape[0], np.float32)
    for p in range(places_m.shape[0]):
        if not is_open[p]:
            continue
        x, y, z = places_m[p, 0], places_m[p, 1], places_m[p, 2]
        for d in range(directions.shape[0]):
            dx, dy, dz = directions[d, 0], directions[d, 1], directions[d, 2]
            found, u, v, front = nearest(obstacles, x, y, z, dx, dy, dz, distances)
            radiance[:] = 0.0
            if found < 0 and dz > 0.0 and seen.sky_channel >= 0:
                for k in range(3):
                    radiance[seen.sky_channel + k] = seen.sky[0, k] + seen.sky[1, k] * (1 - dz)
            elif 0 <= found < seen.where.first.shape[0] and front:
                add_between(seen.where, found, u, v, 1.0, seen.leaving, radiance)
            else:
                continue
            for side in range(6):
                if weights[d, side] > 0.0:
                    for c in range(channels):
                        cubes[p, side, c] += weights[d, side] * radiance[c]
        for s in range(sources.positions_m.shape[0]):
            if not reaches(obstacles, places_m[p], sources.positions_m[s]):
                continue
            for side in range(6):
                arriving = arriving_per_m2(places_m[p], sides[side], sources, s)
                for k in range(3):
                    cubes[p, side, 3 * group[s] + k] += sources.intensity_cd[s, k] * arriving


@njit(cache=True)
def light_up_places(
    obstacles: Rectangles,
    grid: Grid,
    cubes: NDArray[np.float32],
    places_m: NDArray[np.float64],
    result: NDArray[np.float32],
) -> None:
    """Write the cubes (N, 6, 3) at places (N, 3), interpolated between their neighbours except behind walls.

    Args:
        cubes: (P, 6, 3).
    """
    heights = grid.heights_m.shape[0]
    for n in range(places_m.shape[0]):
        result[n] = 0.0
        x = (places_m[n, 0] - grid.first_m[0]) / grid.steps_m[0]
        y = (places_m[n, 1] - grid.first_m[1]) / grid.steps_m[1]
        x, y = min(max(x, 0.0), grid.columns - 1.0), min(max(y, 0.0), grid.rows - 1.0)
        j, i = int(x), int(y)
        k = 0
        while k < heights - 2 and places_m[n, 2] > grid.heights_m[k + 1]:
            k += 1
        z = (places_m[n, 2] - grid.heights_m[k]) / (grid.heights_m[k + 1] - grid.heights_m[k])
        z = min(max(z, 0.0), 1.0)
        for hidden_too in range(2):
            total = 0.0
            for corner in range(4):
                column, row = min(j + corner % 2, grid.columns - 1), min(i + corner // 2, grid.rows - 1)
                weight = (x - j if corner % 2 else 1 - x + j) * (y - i if corner // 2 else 1 - y + i) + 1e-6
                at = row * grid.columns + column
                if not hidden_too and (not grid.is_open[at] or _apart(obstacles, grid, places_m[n], column, row)):
                    continue
                total += weight
                for side in range(6):
                    for c in range(3):
                        lower, upper = cubes[at * heights + k, side, c], cubes[at * heights + k + 1, side, c]
                        result[n, side, c] += weight * (lower + z * (upper - lower))
            if total > 0.0:
                result[n] *= np.float32(1.0 / total)
                break


@njit(cache=True)
def _apart(obstacles: Rectangles, grid: Grid, place_m: NDArray[np.float64], column: int, row: int) -> bool:
    """Return whether a wall stands between a place and a column of cubes."""
    along_x = grid.first_m[0] + column * grid.steps_m[0] - place_m[0]
    along_y = grid.first_m[1] + row * grid.steps_m[1] - place_m[1]
    return blocked(obstacles, place_m[0], place_m[1], place_m[2], along_x, along_y, 0.0, 1.0)
