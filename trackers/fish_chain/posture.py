"""The posture of slender bodies: centre lines in one outline, of one body or of several that touch or cross."""

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


_MOVES = 5
_SCALES = (1.0, 0.5, 0.5, 0.25, 0.25, 0.12, 0.12)
"""Steps of the successive rounds, in deviations."""
_DISCS = 2 * STATIONS - 1


@numba.njit(cache=True)
def body_line(pose: NDArray[np.float64], length_px: float, points: int) -> NDArray[np.float64]:
    """Return ``points`` (an odd number, 2) at equal distances from head to tail of a body of constant curvature."""
    line = np.zeros((points, 2))
    middle = points // 2
    step = length_px / (points - 1)
    line[middle] = pose[:2]
    for side in (-1, 1):
        for k in range(1, middle + 1):
            at = middle + side * k
            angle = pose[2] - side * pose[3] * (k - 0.5) / middle
            line[at, 0] = line[at - side, 0] - side * step * math.cos(angle)
            line[at, 1] = line[at - side, 1] - side * step * math.sin(angle)
    return line


@numba.njit(cache=True)
def _stamp(
    pose: NDArray[np.float64], length_px: float, half_px: NDArray[np.float64], stamp: NDArray[np.int32], mark: int
) -> None:
    """Set ``stamp`` to ``mark`` on the pixels that a body covers, by discs along its centre line."""
    line = body_line(pose, length_px, _DISCS)
    for k in range(_DISCS):
        radius = half_px[k // 2] if k % 2 == 0 else 0.5 * (half_px[k // 2] + half_px[k // 2 + 1])
        low, high = math.floor(line[k, 1] - radius), math.ceil(line[k, 1] + radius)
        for i in range(max(low, 0), min(high + 1, stamp.shape[0])):
            across = i + 0.5 - line[k, 1]
            reach = radius * radius - across * across
            if reach < 0:
                continue
            reach = math.sqrt(reach)
            left, right = math.ceil(line[k, 0] - reach - 0.5), math.floor(line[k, 0] + reach - 0.5)
            for j in range(max(left, 0), min(right + 1, stamp.shape[1])):
                stamp[i, j] = mark


@numba.njit(cache=True)
def _moved(pose: NDArray[np.float64], move: int, steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a pose moved along or across the body, turned, or with its front or its back half turned."""
    result = pose.copy()
    if move < 2:
        direction = pose[2] + 0.5 * math.pi * move
        result[0] += steps[move] * math.cos(direction)
        result[1] += steps[move] * math.sin(direction)
    elif move == 2:
        result[2] += steps[2]
    else:
        result[2] += 0.5 * steps[3]
        result[3] += steps[3] if move == 3 else -steps[3]
    return result


@numba.njit(cache=True)
def _loss(mask: NDArray[np.uint8], cover: NDArray[np.int32], stamp: NDArray[np.int32], mark: int) -> float:
    """Return the pixels in which the union of the others (``cover`` > 0) and one body differs from the mask."""
    wrong = 0
    for i in range(mask.shape[0]):
        for j in range(mask.shape[1]):
            covered = cover[i, j] > 0 or stamp[i, j] == mark
            if covered != (mask[i, j] != 0):
                wrong += 1
    return float(wrong)


@numba.njit(cache=True)
def fit_bodies(
    mask: NDArray[np.uint8],
    expected: NDArray[np.float64],
    lengths_px: NDArray[np.float64],
    halves_px: NDArray[np.float64],
    deviations: NDArray[np.float64],
    weight_px: float,
) -> tuple[NDArray[np.float64], float]:
    """Return the poses (N, 4) of N bodies that cover a blob best, and the pixels in which they differ from it.

    Minimises ``|mask xor union of bodies| + weight_px Σ ((pose - expected) / deviations)²`` by moving one body at a
    time, in steps that shrink; it finds a minimum near the expected poses, not the global one. A pose is x, y of the
    middle, the direction of the head there, and the bend from the middle to either end, radians.

    Args:
        mask: (H, W) 1 on the blob, with a free border as wide as bodies may stick out.
        expected: (N, 4) expected poses in pixels of the mask: x, y, direction, bend.
        lengths_px: (N,). halves_px: (N, STATIONS) half widths from head to tail.
        deviations: (N, 4) standard deviations of the expected poses.
        weight_px: pixels that one squared standard deviation counts.
    """
    count = len(expected)
    poses = expected.copy()
    stamps = np.zeros((count, mask.shape[0], mask.shape[1]), np.int32)
    trial = np.zeros(mask.shape, np.int32)
    cover = np.zeros(mask.shape, np.int32)
    for n in range(count):
        _stamp(poses[n], lengths_px[n], halves_px[n], stamps[n], 1)
        cover += stamps[n]
    mark = 1
    total = 0.0
    for scale in _SCALES:
        for n in range(count):
            cover -= stamps[n]
            best = _loss(mask, cover, stamps[n], 1) + weight_px * np.sum(
                ((poses[n] - expected[n]) / deviations[n]) ** 2
            )
            for move in range(_MOVES):
                for sign in (-1.0, 1.0):
                    while True:
                        moved = _moved(poses[n], move, sign * scale * deviations[n])
                        mark += 1
                        _stamp(moved, lengths_px[n], halves_px[n], trial, mark)
                        loss = _loss(mask, cover, trial, mark)
                        loss += weight_px * np.sum(((moved - expected[n]) / deviations[n]) ** 2)
                        if loss >= best - 1e-9:
                            break
                        best = loss
                        poses[n] = moved
            stamps[n][:] = 0
            _stamp(poses[n], lengths_px[n], halves_px[n], stamps[n], 1)
            cover += stamps[n]
    for i in range(mask.shape[0]):
        for j in range(mask.shape[1]):
            if (cover[i, j] > 0) != (mask[i, j] != 0):
                total += 1.0
    return poses, total


def pose_of(line_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the pose (4,) of a centre line (K, 2) from head to tail: its middle, direction there, and bend."""
    middle = len(line_px) // 2
    front, back = line_px[0] - line_px[middle], line_px[middle] - line_px[-1]
    ahead, behind = np.arctan2(front[1], front[0]), np.arctan2(back[1], back[0])
    bend = (ahead - behind + np.pi) % (2 * np.pi) - np.pi
    return np.array([*line_px[middle], behind + 0.5 * bend, bend])
