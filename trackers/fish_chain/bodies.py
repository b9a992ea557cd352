"""Fits several known bodies to the outline of one blob, so that fish that touch or cross are followed apart."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from trackers.fish_chain.posture import STATIONS

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
