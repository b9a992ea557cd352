"""Thinning of a mask to lines one cell wide, and tracing of those lines from crossing to crossing."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def thin(mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the skeleton (H, W) of a mask (H, W): 1 on the lines, 0 elsewhere. The outermost cells count
    as 0.

    Zhang and Suen 1984, "A fast parallel algorithm for thinning digital patterns": with the neighbours p2
    (above) ... p9 in clockwise order, B = their sum and A = the number of 0 -> 1 steps round the ring, a
    cell goes if 2 <= B <= 6, A = 1 and (in turn) p2 p4 p6 = p4 p6 p8 = 0, or p2 p4 p8 = p2 p6 p8 = 0; until
    nothing changes.
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
    """Follow the lines of a skeleton from end or crossing to end or crossing.

    A cell with other than two neighbours (of eight) is a stop; every maximal run between two stops becomes
    one line. Closed rings without a stop are cut open at their first cell.

    Args:
        skeleton: (H, W) 0 or 1, outermost cells 0.

    Returns:
        cells (M, 2) (row, column) of all lines one after the other, and offsets (L + 1,): line k is
        ``cells[offsets[k]:offsets[k + 1]]``.
    """
    height, width = skeleton.shape
    degree = np.zeros((height, width), np.int8)
    total = 0
    for i in range(1, height - 1):
        for j in range(1, width - 1):
            if skeleton[i, j]:
                total += 1
                around = -1
                for a in range(-1, 2):
                    for b in range(-1, 2):
                        around += skeleton[i + a, j + b]
                degree[i, j] = around
    cells = np.empty((10 * total + 16, 2), np.int32)
    offsets = np.zeros(4 * total + 2, np.int64)
    visited = np.zeros((height, width), np.uint8)
    size = 0
    lines = 0
    for rings in range(2):
        for i in range(1, height - 1):
            for j in range(1, width - 1):
                start = degree[i, j] != 2 if rings == 0 else not visited[i, j]
                if not skeleton[i, j] or not start:
                    continue
                for a in range(-1, 2):
                    for b in range(-1, 2):
                        r, c = i + a, j + b
                        if (a == 0 and b == 0) or not skeleton[r, c] or visited[r, c]:
                            continue
                        # Two stops side by side: a line of two cells, written once.
                        if rings == 0 and degree[r, c] != 2 and r * width + c < i * width + j:
                            continue
                        first = size
                        cells[size, 0], cells[size, 1] = i, j
                        size += 1
                        last_r, last_c = i, j
                        if rings == 1:
                            visited[i, j] = 1
                        while True:
                            cells[size, 0], cells[size, 1] = r, c
                            size += 1
                            if degree[r, c] != 2:
                                break
                            visited[r, c] = 1
                            next_r, next_c = -1, -1
                            for e in range(-1, 2):
                                for f in range(-1, 2):
                                    if (e == 0 and f == 0) or not skeleton[r + e, c + f]:
                                        continue
                                    if (r + e == last_r and c + f == last_c) or visited[r + e, c + f]:
                                        continue
                                    # The run's own beginning is no way on for its second cell.
                                    if size - first == 2 and r + e == i and c + f == j:
                                        continue
                                    next_r, next_c = r + e, c + f
                            if next_r < 0:
                                break
                            last_r, last_c = r, c
                            r, c = next_r, next_c
                        lines += 1
                        offsets[lines] = size
    return cells[:size].copy(), offsets[: lines + 1].copy()
