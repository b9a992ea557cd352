"""Edges without stairs: a pixel at an edge gets the shares of the surfaces on both sides.

A pixel is drawn at its centre, so that an edge between two surfaces runs in steps. The edges of the triangle in front
say where the edge crosses the way between the centres of two neighbours p and q, ``s`` pixels from p. By the areas
that it leaves to them, taken along the axis to which it is steeper,

    s < 1/2:  L'_p = L_p + (1/2 - s) (L_q - L_p)
    s > 1/2:  L'_q = L_q + (s - 1/2) (L_p - L_q)

in linear radiance. The area is exact for an edge along an axis, and for any straight edge that crosses two opposite
sides of the pixel. Ids, depth and all truth stay those of the centres; what is narrower than a pixel and lies between
centres stays unseen. (The idea of Persson's Geometric Post-process Anti-Aliasing, 2011.)
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.attributes import Visible

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
SEEN_FROM = np.float32(0.02)
"""Share of the sum of two radiances from which their difference is seen as a step (Weber: 1 to 2 % of either)."""
NO_EDGE = np.float32(2.0)
_WORD = 8
"""Pixels that are passed over at once where there is no edge."""


@njit(cache=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def smooth_edges(seen: Visible, radiance: NDArray[np.float32]) -> None:
    """Smooth the edges of a picture's radiance (H, C, W) in place."""
    triangle, nearness, sides = seen.triangle, seen.nearness, seen.table.sides
    height, channels, width = radiance.shape
    marks = np.zeros(-(-width // _WORD) * _WORD, np.uint8)
    words = marks.view(np.uint64)
    # Changes of this row and of the next one: they wait until no neighbour needs what was there before.
    count, columns, changes = (
        np.zeros(2, np.int64),
        np.empty((2, 4 * width), np.int64),
        np.empty((2, 4 * width, 4), np.float32),
    )
    for row in range(height):
        below = min(row + 1, height - 1)
        here, beyond = row & 1, 1 - (row & 1)
        for column in range(width - 1):
            marks[column] = triangle[row, column] != triangle[row, column + 1]
        marks[width - 1] = 0
        for column in range(width):
            marks[column] |= np.uint8(np.uint8(triangle[row, column] != triangle[below, column]) << 1)
        for word in range(words.shape[0]):
            if words[word] == 0:
                continue
            for column in range(_WORD * word, _WORD * word + _WORD):
                for axis in range(2):
                    if not marks[column] >> axis & 1:
                        continue
                    next_row, next_column, differs = row + axis, column + 1 - axis, False
                    for channel in range(channels):
                        a, b = radiance[row, channel, column], radiance[next_row, channel, next_column]
                        differs |= abs(a - b) > SEEN_FROM * (a + b)
                    if not differs:
                        continue
                    place = _place(triangle, nearness, sides, row, column, axis)
                    if place == HALF:
                        continue
                    to = here if place < HALF or axis == 0 else beyond
                    k = count[to]
                    columns[to, k] = column if place < HALF else next_column
                    for channel in range(channels):
                        a, b = radiance[row, channel, column], radiance[next_row, channel, next_column]
                        changes[to, k, channel] = (HALF - place) * (b - a)
                    count[to] = k + 1
        for k in range(count[here]):
            for channel in range(channels):
                radiance[row, channel, columns[here, k]] += changes[here, k, channel]
        count[here] = 0


@njit(cache=True, error_model="numpy", forceinline=True, fastmath={"contract", "arcp", "nsz"})
def _place(
    triangle: NDArray[np.int32],
    nearness: NDArray[np.float32],
    sides: NDArray[np.float32],
    row: int,
    column: int,
    axis: int,
) -> np.float32:
    """Return how far from a pixel an edge crosses the way to its neighbour, 0 to 1; 1/2 where none does."""
    next_row, next_column = row + axis, column + 1 - axis
    one, other = triangle[row, column], triangle[next_row, next_column]
    behind = _to_edge(sides, one, axis, ONE, np.float32(column), np.float32(row))
    before = ONE - _to_edge(sides, other, axis, -ONE, np.float32(next_column), np.float32(next_row))
    if behind <= ONE and (before < ZERO or nearness[row, column] > nearness[next_row, next_column]):
        return behind
    return before if before >= ZERO else HALF


@njit(cache=True, error_model="numpy", forceinline=True, fastmath={"contract", "arcp", "nsz"})
def _to_edge(
    sides: NDArray[np.float32], index: int, axis: int, step: np.float32, x: np.float32, y: np.float32
) -> np.float32:
    """Return the way from a pixel (x, y) of a triangle to the first of its edges towards the next pixel along an axis.

    ``NO_EDGE`` if there is none within a pixel; edges that are steeper to the other axis do not count.

    Args:
        axis: 0 along the row, 1 along the column. step: +1 or -1.
    """
    first = NO_EDGE
    for edge in range(0, 9, 3):
        a, b = sides[index, edge], sides[index, edge + 1]
        along, across = (a, b) if axis == 0 else (b, a)
        if along * step < ZERO and abs(along) >= abs(across):
            # Along this axis the function is the distance, see ``TriangleTable``.
            distance = max(a * x + b * y + sides[index, edge + 2], ZERO)
            if distance <= ONE:
                first = min(first, distance)
    return first
