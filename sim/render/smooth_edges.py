"""Edges without stairs: a pixel at an edge gets the shares of the surfaces on both sides.

A pixel is drawn at its centre, so that an edge between two surfaces runs in steps. The edges of the triangle in front
say where the edge crosses the way between the centres of two neighbours p and q, ``s`` pixels from p. By the areas
that it leaves to them, taken along the axis to which it is steeper,

    s < 1/2:  L'_p = L_p + (1/2 - s) (L_q - L_p)
    s > 1/2:  L'_q = L_q + (s - 1/2) (L_p - L_q)

in linear radiance. The area is exact for an edge along an axis, and for any straight edge that crosses two opposite
sides of the pixel. Ids, depth and all truth stay those of the centres. What is narrower than a pixel and lies between
centres stays unseen, and where edges of two surfaces cross within a pixel, it may be off by half the step. (The idea of
Persson's Geometric Post-process Anti-Aliasing, 2011.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.attributes import Visible
from sim.render.compilation import row_kernel
from sim.render.rows import PITCH, new_lines

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
SEEN_FROM = np.float32(0.02)
"""Share of the sum of two radiances from which their difference is seen as a step (Weber: 1 to 2 % of either)."""
NO_EDGE = np.float32(2.0)
_WORD = 8
"""Pixels that are passed over at once where there is no edge."""
_OF_EDGES, _ALONG, _ACROSS, _IS_NEARER, _PLACE = 0, 18 * PITCH, 19 * PITCH, 20 * PITCH, 21 * PITCH
_LINES = 22


class SmoothScratch(NamedTuple):
    """Scratch of ``smooth_row``, for rows of W pixels.

    Attributes:
        marks: (>= W,) uint8, whether the triangle differs from that of the next pixel along an axis.
        words: the same memory, ``_WORD`` pixels each.
        pairs: (> W,) int64 columns of the pixels that differ.
        lines: line buffer, see ``sim.render.rows``, with a column for each pair: three numbers of each edge of both
            triangles; the pixel's place along the axis and across it; 1 if its surface is nearer; where the edge is.
        counts: (2,) int64, columns: (2, 4 W), changes: (2, 4 W, C): changes of even and of odd rows. They wait until no
            neighbour needs what was there before.
    """

    marks: NDArray[np.uint8]
    words: NDArray[np.uint64]
    pairs: NDArray[np.int64]
    lines: NDArray[np.float32]
    counts: NDArray[np.int64]
    columns: NDArray[np.int64]
    changes: NDArray[np.float32]


def new_smooth_scratch(width: int, channels: int) -> SmoothScratch:
    """Return scratch for rows of ``width`` pixels with ``channels`` numbers each."""
    whole = -(-width // _WORD) * _WORD
    marks, pairs, lines = np.zeros(whole, np.uint8), np.empty(whole + 1, np.int64), new_lines(_LINES, width)
    columns, changes = np.empty((2, 4 * width), np.int64), np.empty((2, 4 * width, channels), np.float32)
    return SmoothScratch(marks, marks.view(np.uint64), pairs, lines, np.zeros(2, np.int64), columns, changes)


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def smooth_row(
    seen: Visible, row: int, here: NDArray[np.float32], below: NDArray[np.float32], scratch: SmoothScratch
) -> None:
    """Smooth the edges of one row of a picture in place, after those above.

    Args:
        here, below: (C, W) radiance of the row and of the next one, of which only that row's is changed; the last row
            is its own next one.
    """
    pairs, counts, columns, changes = scratch.pairs, scratch.counts, scratch.columns, scratch.changes
    channels, mine = here.shape[0], row & 1
    for axis in range(2):
        found = _find_pairs(seen.triangle, row, axis, scratch.marks, scratch.words, pairs)
        _gather(seen, row, axis, found, pairs, scratch.lines)
        _find_places(found, scratch.lines)
        other = below if axis == 1 else here
        for k in range(found):
            place, column, next_column = scratch.lines[_PLACE + k], pairs[k], pairs[k] + 1 - axis
            beyond = place > HALF
            to = 1 - mine if beyond and axis == 1 else mine
            j, differs = counts[to], False
            for channel in range(channels):
                a, b = here[channel, column], other[channel, next_column]
                differs |= abs(a - b) > SEEN_FROM * (a + b)
                changes[to, j, channel] = (HALF - place) * (b - a)
            columns[to, j] = next_column if beyond else column
            # Without branches: a mispredicted one costs more than a needless change.
            counts[to] = j + np.int64(differs and place != HALF)
    for k in range(counts[mine]):
        for channel in range(channels):
            here[channel, columns[mine, k]] += changes[mine, k, channel]
    counts[mine] = 0


@row_kernel()
def _find_pairs(
    triangle: NDArray[np.int32],
    row: int,
    axis: int,
    marks: NDArray[np.uint8],
    words: NDArray[np.uint64],
    pairs: NDArray[np.int64],
) -> int:
    """Write the columns of a row where the next pixel along an axis shows another triangle; return how many."""
    height, width = triangle.shape
    here, there = triangle[row], triangle[min(row + axis, height - 1)]
    for column in range(width - 1):
        marks[column] = here[column] != there[column + 1 - axis]
    marks[width - 1] = here[width - 1] != there[width - 1]
    found = 0
    for word in range(words.shape[0]):
        if words[word] == 0:
            continue
        for column in range(_WORD * word, _WORD * word + _WORD):
            pairs[found] = column
            found += int(marks[column])
    return found


@row_kernel()
def _gather(
    seen: Visible, row: int, axis: int, found: int, pairs: NDArray[np.int64], lines: NDArray[np.float32]
) -> None:
    """Write the edges of both triangles of each pair, their slopes along the axis first, and the pixel's place."""
    triangle, nearness, sides = seen.triangle, seen.nearness, seen.table.sides
    for k in range(found):
        column = pairs[k]
        next_row, next_column = row + axis, column + 1 - axis
        one, other = triangle[row, column], triangle[next_row, next_column]
        for edge in range(0, 9, 3):
            for part in range(3):
                at = edge + (part if part == 2 else part ^ axis)
                lines[_OF_EDGES + (edge + part) * PITCH + k] = sides[one, at]
                lines[_OF_EDGES + (9 + edge + part) * PITCH + k] = sides[other, at]
        lines[_ALONG + k] = np.float32(row if axis == 1 else column)
        lines[_ACROSS + k] = np.float32(column if axis == 1 else row)
        lines[_IS_NEARER + k] = ONE if nearness[row, column] > nearness[next_row, next_column] else ZERO


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _find_places(found: int, lines: NDArray[np.float32]) -> None:
    """Write how far from a pixel an edge crosses the way to its neighbour, 0 to 1; 1/2 where none does.

    An edge of the nearer triangle counts; of the other one, where that has none.
    """
    for k in range(found):
        along, across = lines[_ALONG + k], lines[_ACROSS + k]
        behind, beyond = NO_EDGE, NO_EDGE
        for edge in range(3):
            at = 3 * edge * PITCH + k
            behind = min(behind, _to_edge(lines[at], lines[at + PITCH], lines[at + 2 * PITCH], ONE, along, across))
            at += 9 * PITCH
            slopes = lines[at], lines[at + PITCH], lines[at + 2 * PITCH]
            beyond = min(beyond, _to_edge(slopes[0], slopes[1], slopes[2], -ONE, along + ONE, across))
        before = ONE - beyond
        is_first = (behind <= ONE) & ((before < ZERO) | (lines[_IS_NEARER + k] > ZERO))
        lines[_PLACE + k] = behind if is_first else (before if before >= ZERO else HALF)


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _to_edge(
    slope: np.float32, aside: np.float32, base: np.float32, step: np.float32, along: np.float32, across: np.float32
) -> np.float32:
    """Return the way from a pixel to an edge of its triangle in the direction of the step, +1 or -1, along an axis.

    ``NO_EDGE`` if it is farther than a pixel, or steeper to the other axis.

    Args:
        slope, aside, base: of the edge function, along the axis and across it: along this axis it is the distance, see
            ``TriangleTable``.
    """
    distance = max(slope * along + aside * across + base, ZERO)
    is_crossed = (slope * step < ZERO) & (abs(slope) >= abs(aside)) & (distance <= ONE)
    return distance if is_crossed else NO_EDGE
