"""Thinning of a mask to lines one cell wide, and tracing of these lines from crossing to crossing."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

_NEIGHBOURS = np.array([(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)])
"""Rows and columns to the eight neighbours of a cell."""


@njit(cache=True)
def thin(mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the skeleton (H, W) of a mask (H, W): 1 on the lines, 0 elsewhere. The outermost cells count as 0.

    Zhang and Suen 1984, "A fast parallel algorithm for thinning digital patterns": with the neighbours p2 (above) ...
    p9 in clockwise order, B = their sum and A = the number of 0 -> 1 steps along the ring, a cell is deleted if
    2 <= B <= 6, A = 1 and alternately p2 p4 p6 = p4 p6 p8 = 0, or p2 p4 p8 = p2 p6 p8 = 0; until nothing changes.
    """
    height, width = mask.shape
    result = np.zeros((height, width), np.uint8)
    border = np.empty((height * width, 2), np.int32)
    count = 0
    for i in range(1, height - 1):
        for j in range(1, width - 1):
            if mask[i, j]:
                result[i, j] = 1
                border[count, 0], border[count, 1] = i, j
                count += 1
    gone = np.empty((count, 2), np.int32)
    changed = True
    while changed:
        changed = False
        for turn in range(2):
            deleted = 0
            kept = 0
            for k in range(count):
                i, j = border[k, 0], border[k, 1]
                p2, p3, p4, p5 = result[i - 1, j], result[i - 1, j + 1], result[i, j + 1], result[i + 1, j + 1]
                p6, p7, p8, p9 = result[i + 1, j], result[i + 1, j - 1], result[i, j - 1], result[i - 1, j - 1]
                B = p2 + p3 + p4 + p5 + p6 + p7 + p8 + p9
                A = (p2 < p3) + (p3 < p4) + (p4 < p5) + (p5 < p6) + (p6 < p7) + (p7 < p8) + (p8 < p9) + (p9 < p2)
                first = p2 * p4 * p6 == 0 and p4 * p6 * p8 == 0
                second = p2 * p4 * p8 == 0 and p2 * p6 * p8 == 0
                if 2 <= B <= 6 and A == 1 and (first if turn == 0 else second):
                    gone[deleted, 0], gone[deleted, 1] = i, j
                    deleted += 1
                else:
                    border[kept, 0], border[kept, 1] = i, j
                    kept += 1
            for k in range(deleted):
                result[gone[k, 0], gone[k, 1]] = 0
            count = kept
            changed = changed or deleted > 0
    return result


@njit(cache=True)
def trace_lines(skeleton: NDArray[np.uint8]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Trace the lines of a skeleton between its ends and crossings.

    A cell whose neighbours on lines (of eight) are not two is a stop; every run between two stops is one line. Rings
    without a stop start and end at their first cell.

    Args:
        skeleton: (H, W) 0 or 1, outermost cells 0.

    Returns:
        cells (M, 2) (row, column) of all lines one after the other, and offsets (L + 1,): line k is
        ``cells[offsets[k]:offsets[k + 1]]``.
    """
    height, width = skeleton.shape
    degree, total = _degrees(skeleton)
    cells = np.empty((10 * total + 16, 2), np.int32)
    offsets = np.zeros(4 * total + 2, np.int64)
    visited = np.zeros((height, width), np.uint8)
    size, lines = 0, 0
    for rings in (False, True):
        for i in range(1, height - 1):
            for j in range(1, width - 1):
                is_start = not visited[i, j] if rings else degree[i, j] != 2
                if not skeleton[i, j] or not is_start:
                    continue
                for n in range(len(_NEIGHBOURS)):
                    r, c = i + _NEIGHBOURS[n, 0], j + _NEIGHBOURS[n, 1]
                    if not skeleton[r, c] or visited[r, c]:
                        continue
                    # Two stops side by side: a line of two cells, written once.
                    if not rings and degree[r, c] != 2 and r * width + c < i * width + j:
                        continue
                    if rings:
                        visited[i, j] = 1
                    size = _follow(skeleton, degree, visited, i, j, r, c, cells, size)
                    lines += 1
                    offsets[lines] = size
    return cells[:size].copy(), offsets[: lines + 1].copy()


@njit(cache=True)
def _degrees(skeleton: NDArray[np.uint8]) -> tuple[NDArray[np.int8], int]:
    """Return the number of neighbours on lines of each cell on a line (H, W), and the number of such cells."""
    height, width = skeleton.shape
    degree = np.zeros((height, width), np.int8)
    total = 0
    for i in range(1, height - 1):
        for j in range(1, width - 1):
            if skeleton[i, j]:
                total += 1
                for n in range(len(_NEIGHBOURS)):
                    degree[i, j] += skeleton[i + _NEIGHBOURS[n, 0], j + _NEIGHBOURS[n, 1]]
    return degree, total


@njit(cache=True)
def _follow(
    skeleton: NDArray[np.uint8],
    degree: NDArray[np.int8],
    visited: NDArray[np.uint8],
    first_r: int,
    first_c: int,
    r: int,
    c: int,
    cells: NDArray[np.int32],
    size: int,
) -> int:
    """Append the line from a cell through its neighbour (r, c) to ``cells``, which holds ``size`` of them, and mark its
    inner cells as visited. Return the new size.
    """
    start = size
    cells[size, 0], cells[size, 1] = first_r, first_c
    size += 1
    last_r, last_c = first_r, first_c
    while True:
        cells[size, 0], cells[size, 1] = r, c
        size += 1
        if degree[r, c] != 2:
            return size
        visited[r, c] = 1
        next_r, next_c = -1, -1
        for n in range(len(_NEIGHBOURS)):
            to_r, to_c = r + _NEIGHBOURS[n, 0], c + _NEIGHBOURS[n, 1]
            if not skeleton[to_r, to_c] or visited[to_r, to_c] or (to_r == last_r and to_c == last_c):
                continue
            # The second cell does not lead back to the first.
            if size - start == 2 and to_r == first_r and to_c == first_c:
                continue
            next_r, next_c = to_r, to_c
        if next_r < 0:
            return size
        last_r, last_c = r, c
        r, c = next_r, next_c
