"""The posture of one slender body: its centre line from the geodesic distances inside its outline."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

STATIONS = 9
"""Points of a centre line."""
_STRAIGHT, _DIAGONAL = 1.0, math.sqrt(2.0)
_SLICE_PX = 2.5


@numba.njit(cache=True)
def geodesic(mask: NDArray[np.uint8], row: int, column: int) -> NDArray[np.float32]:
    """Return the length (H, W) of the shortest path inside ``mask`` from a pixel, by steps to the 8 neighbours.

    Infinite outside and where there is no path. Two chamfer sweeps, down and up, repeated until nothing changes.
    """
    height, width = mask.shape
    distance = np.full((height, width), np.float32(np.inf))
    distance[row, column] = 0.0
    changed = True
    while changed:
        changed = False
        for sweep in range(2):
            for index in range(height * width):
                at = index if sweep == 0 else height * width - 1 - index
                i, j = at // width, at % width
                if mask[i, j] == 0:
                    continue
                best = distance[i, j]
                for di in range(-1, 2):
                    for dj in range(-1, 2):
                        k, m = i + di, j + dj
                        if 0 <= k < height and 0 <= m < width:
                            through = distance[k, m] + (_DIAGONAL if di != 0 and dj != 0 else _STRAIGHT)
                            if through < best - 1e-4:
                                best = np.float32(through)
                                changed = True
                distance[i, j] = best
    return distance


@numba.njit(cache=True)
def _farthest(mask: NDArray[np.uint8], distance: NDArray[np.float32]) -> tuple[int, int]:
    best, row, column = -1.0, 0, 0
    for i in range(mask.shape[0]):
        for j in range(mask.shape[1]):
            if mask[i, j] != 0 and np.isfinite(distance[i, j]) and distance[i, j] > best:
                best, row, column = distance[i, j], i, j
    return row, column


@numba.njit(cache=True)
def _slices(mask: NDArray[np.uint8], weight: NDArray[np.float32], shade: NDArray[np.float32]) -> NDArray[np.float64]:
    """Cut a body into slices between its two ends and return (S, 5): x, y, pixels, weight and shade of each.

    The ends are the two pixels that are farthest from each other along the body; a slice is a band of equal distances
    from one of them. x and y are the slice's weighted centre, in pixels from the top left corner of ``mask``.
    """
    row, column = -1, -1
    for i in range(mask.shape[0]):
        for j in range(mask.shape[1]):
            if mask[i, j] != 0 and row < 0:
                row, column = i, j
    row, column = _farthest(mask, geodesic(mask, row, column))
    distance = geodesic(mask, row, column)
    row, column = _farthest(mask, distance)
    length = distance[row, column] + 1.0
    count = max(1, round(length / _SLICE_PX))
    sums = np.zeros((count, 5))
    for i in range(mask.shape[0]):
        for j in range(mask.shape[1]):
            if mask[i, j] != 0 and np.isfinite(distance[i, j]):
                k = min(int((distance[i, j] + 0.5) / length * count), count - 1)
                sums[k, 0] += weight[i, j] * (j + 0.5)
                sums[k, 1] += weight[i, j] * (i + 0.5)
                sums[k, 2] += 1.0
                sums[k, 3] += weight[i, j]
                sums[k, 4] += shade[i, j]
    kept = 0
    for k in range(count):
        if sums[k, 3] > 0:
            sums[kept] = sums[k]
            kept += 1
    for k in range(kept):
        sums[k, 0] /= sums[k, 3]
        sums[k, 1] /= sums[k, 3]
        sums[k, 4] /= sums[k, 2]
    return sums[:kept]


@numba.njit(cache=True)
def _interpolated(at: float, along: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    k = 1
    while k < len(along) - 1 and along[k] < at:
        k += 1
    span = max(along[k] - along[k - 1], 1e-9)
    share = min(max((at - along[k - 1]) / span, 0.0), 1.0)
    return values[k - 1] + share * (values[k] - values[k - 1])  # type: ignore[no-any-return]


@numba.njit(cache=True)
def posture(
    mask: NDArray[np.uint8], weight: NDArray[np.float32], shade: NDArray[np.float32], stations: int
) -> tuple[NDArray[np.float64], float]:
    """Return (stations, 4) x, y, width and shade at equal distances along a body from its heavier end, and its centre.

    The heavier half is the head's: a fish is wide and dark before its middle and tapers to the tail. The centre is that
    of weight, as a share of the length behind the head.

    Args:
        mask: (H, W) 1 on the body, one component, not empty.
        weight: (H, W) contrast to the floor, > 0 on the body. shade: (H, W) what is averaged along the body.
    """
    cut = _slices(mask, weight, shade)
    count = len(cut)
    line = np.zeros((count + 2, 2))
    line[1:-1] = cut[:, :2]
    for k in range(1, count - 1):
        line[k + 1] = 0.25 * (cut[k - 1, :2] + 2 * cut[k, :2] + cut[k + 1, :2])
    # The outline goes on for half a slice beyond the centres of the outer ones.
    for end, inner, other in ((0, 1, min(2, count)), (count + 1, count, max(count - 1, 1))):
        step = line[inner] - line[other]
        norm = math.hypot(step[0], step[1])
        line[end] = line[inner] + (0.5 * _SLICE_PX * step / norm if norm > 0 else 0.0 * step)
    along = np.zeros(count + 2)
    for k in range(1, count + 2):
        along[k] = along[k - 1] + math.hypot(line[k, 0] - line[k - 1, 0], line[k, 1] - line[k - 1, 1])
    thickness = max(along[-1], 1.0) / count
    values = np.zeros((count + 2, 4))
    values[:, :2] = line
    values[1:-1, 2] = cut[:, 2] / thickness
    values[1:-1, 3] = cut[:, 4]
    values[0, 3], values[-1, 3] = values[1, 3], values[-2, 3]
    result = np.zeros((stations, 4))
    for s in range(stations):
        at = along[-1] * s / (stations - 1)
        for column in range(4):
            result[s, column] = _interpolated(at, along, values[:, column])
    balance, centre = 0.0, 0.0
    for k in range(count):
        balance += cut[k, 3] * (1.0 if along[k + 1] < 0.5 * along[-1] else -1.0)
        centre += cut[k, 3] * along[k + 1]
    centre /= max(along[-1] * cut[:, 3].sum(), 1e-9)
    return (result, centre) if balance >= 0 else (result[::-1].copy(), 1.0 - centre)


def headings(lines_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the directions (T,) from the middle of centre lines (T, K, 2) to their heads."""
    ahead = lines_px[:, 0] - lines_px[:, lines_px.shape[1] // 2]
    return np.arctan2(ahead[:, 1], ahead[:, 0])
