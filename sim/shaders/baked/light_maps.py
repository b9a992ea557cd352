"""Maps of light on rectangles: a lattice of samples from edge to edge, with bilinear interpolation.

Samples lie on the edges and not half a step inside, so that there is no seam between adjacent rectangles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.shaders.baked.rays import OFF_SURFACE_M, Rectangles, count_backs, sphere_directions

_INSET_M = 0.02
"""Distance inside the rectangle of samples on its edge: objects on the edge do not block their light."""
_DIRECTIONS = sphere_directions(32)
_MOST_BACKS = 0.25


class Geometry(NamedTuple):
    """R rectangles in the world: corner, the two sides from it, unit normal; (R, 3) each."""

    corner_m: NDArray[np.float64]
    side_a_m: NDArray[np.float64]
    side_b_m: NDArray[np.float64]
    normal: NDArray[np.float64]


class Lattice(NamedTuple):
    """Places of the samples of R rectangles in one list.

    Attributes:
        first: (R,) int32, of each rectangle; its samples follow row by row, along side a within a row.
        columns, rows: (R,) int32, >= 2.
        total: number of samples T.
    """

    first: NDArray[np.int32]
    columns: NDArray[np.int32]
    rows: NDArray[np.int32]
    total: int


def lattice(geometry: Geometry, step_m: float) -> Lattice:
    """Return lattices with samples at most ``step_m`` apart."""
    columns, rows = (
        np.maximum(np.ceil(np.linalg.norm(side, axis=1) / step_m - 1e-9).astype(np.int32) + 1, 2)
        for side in (geometry.side_a_m, geometry.side_b_m)
    )
    ends = np.cumsum(columns * rows)
    return Lattice((ends - columns * rows).astype(np.int32), columns, rows, int(ends[-1]) if len(ends) else 0)


def sample_points(geometry: Geometry, r: int, columns: int, rows: int) -> NDArray[np.float64]:
    """Return the places (rows * columns, 3) of a rectangle's samples, slightly before its surface."""
    side_a_m, side_b_m = geometry.side_a_m[r], geometry.side_b_m[r]
    u, v = (
        np.clip(np.linspace(0.0, 1.0, count), inset, 1.0 - inset)
        for count, inset in ((columns, _inset(side_a_m)), (rows, _inset(side_b_m)))
    )
    across = v[:, None, None] * side_b_m + u[None, :, None] * side_a_m
    points_m: NDArray[np.float64] = geometry.corner_m[r] + OFF_SURFACE_M * geometry.normal[r] + across
    return points_m.reshape(-1, 3)


def samples(geometry: Geometry, where: Lattice) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return the places (T, 3) of all samples and the rectangle (T,) of each."""
    points_m, owner = np.empty((where.total, 3)), np.empty(where.total, np.int32)
    for r, first in enumerate(where.first):
        count = int(where.columns[r] * where.rows[r])
        points_m[first : first + count] = sample_points(geometry, r, int(where.columns[r]), int(where.rows[r]))
        owner[first : first + count] = r
    return points_m, owner


def in_the_open(
    obstacles: Rectangles, points_m: NDArray[np.float64], normals: NDArray[np.float64], owner: NDArray[np.int32]
) -> NDArray[np.bool_]:
    """Return whether each sample (T,) is open: not inside a wall or behind an object on it."""
    return count_backs(obstacles, points_m, normals, owner, _DIRECTIONS) <= _MOST_BACKS


def _inset(side_m: NDArray[np.float64]) -> float:
    length_m = float(np.linalg.norm(side_m))
    return min(_INSET_M / length_m, 0.25)


@njit(cache=True)
def fill_hidden(where: Lattice, is_open: NDArray[np.bool_], values: NDArray[np.float32]) -> None:
    """Set samples that are not open to the mean of their open neighbours, outwards from these.

    Args:
        values: (T, C), changed.
    """
    channels = values.shape[1]
    total = np.empty(channels)
    for r in range(where.first.shape[0]):
        first, columns, rows = where.first[r], where.columns[r], where.rows[r]
        known = is_open[first : first + columns * rows].copy()
        if not known.any():
            continue
        while not known.all():
            before = known.copy()
            for i in range(rows):
                for j in range(columns):
                    if before[i * columns + j]:
                        continue
                    count = 0
                    total[:] = 0.0
                    for row in range(max(i - 1, 0), min(i + 2, rows)):
                        for column in range(max(j - 1, 0), min(j + 2, columns)):
                            if before[row * columns + column]:
                                count += 1
                                for c in range(channels):
                                    total[c] += values[first + row * columns + column, c]
                    if count > 0:
                        known[i * columns + j] = True
                        for c in range(channels):
                            values[first + i * columns + j, c] = total[c] / count


@njit(cache=True)
def add_between(
    where: Lattice, r: int, u: float, v: float, weight: float, values: NDArray[np.float32], result: NDArray[np.float64]
) -> None:
    """Add to ``result`` (C,) ``weight`` times the samples (T, C) of rectangle r, interpolated at (u, v)."""
    columns, rows = where.columns[r], where.rows[r]
    x, y = u * (columns - 1), v * (rows - 1)
    j, i = min(int(x), columns - 2), min(int(y), rows - 2)
    x, y = x - j, y - i
    at = where.first[r] + i * columns + j
    w_11, w_01, w_10 = weight * x * y, weight * x * (1 - y), weight * (1 - x) * y
    w_00 = weight * (1 - x) * (1 - y)
    for c in range(result.shape[0]):
        result[c] += w_00 * values[at, c] + w_01 * values[at + 1, c]
        result[c] += w_10 * values[at + columns, c] + w_11 * values[at + columns + 1, c]
