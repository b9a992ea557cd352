"""Reflection of light between rectangles.

Rectangles are cut into patches. With the direct illuminance E of a patch, its reflectance rho and the form factor
``F_ij``, the share of patch j in the light on patch i under uniform surroundings, the light that leaves a patch is

    B_i = rho_i (E_i + sum_j F_ij B_j)

(Goral et al., "Modeling the interaction of light between diffuse surfaces", 1984), solved by fixed-point iteration.
At any other place ``sum_j F_j B_j`` arrives.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.shaders.baked.light_maps import Geometry, Lattice, add_between
from sim.shaders.baked.rays import OFF_SURFACE_M, Rectangles, blocked

_NEAR = 4.0
"""Distance over the larger side of a patch below which it is a rectangle, and above a point."""
_MUCH = 2e-4
_MOST_ROUNDS = 60
_GOOD_ENOUGH = 1e-3


class Patches(NamedTuple):
    """N pieces of rectangles: middle, slightly before the surface, normal, two half sides (N, 3); rectangle (N,); u and
    v of the middle on it (N, 2); shares of its sides (N, 2).
    """

    middle_m: NDArray[np.float64]
    normal: NDArray[np.float64]
    half_a_m: NDArray[np.float64]
    half_b_m: NDArray[np.float64]
    owner: NDArray[np.int64]
    at: NDArray[np.float64]
    share: NDArray[np.float64]


def cut(geometry: Geometry, side_m: float) -> Patches:
    """Return patches with sides of at most ``side_m``."""
    owner, at, share = [], [], []
    for r in range(len(geometry.corner_m)):
        count_a, count_b = (
            max(int(np.ceil(np.linalg.norm(side[r]) / side_m - 1e-9)), 1)
            for side in (geometry.side_a_m, geometry.side_b_m)
        )
        u, v = np.meshgrid((np.arange(count_a) + 0.5) / count_a, (np.arange(count_b) + 0.5) / count_b)
        at.append(np.column_stack([u.ravel(), v.ravel()]))
        share.append(np.tile([1 / count_a, 1 / count_b], (count_a * count_b, 1)))
        owner.append(np.full(count_a * count_b, r))
    owners, where, shares = np.concatenate(owner), np.concatenate(at), np.concatenate(share)
    side_a_m, side_b_m, normal = geometry.side_a_m[owners], geometry.side_b_m[owners], geometry.normal[owners]
    middle_m = geometry.corner_m[owners] + where[:, :1] * side_a_m + where[:, 1:] * side_b_m + OFF_SURFACE_M * normal
    half_a_m, half_b_m = 0.5 * shares[:, :1] * side_a_m, 0.5 * shares[:, 1:] * side_b_m
    return Patches(middle_m, normal, half_a_m, half_b_m, owners, where, shares)


def thrown_back(
    factors: NDArray[np.float32], reflectance: NDArray[np.float32], arriving_lx: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return the light (N, C) that leaves patches with direct light ``arriving_lx`` (N, C).

    Args:
        factors: (N, N). reflectance: (N, C).
    """
    first = reflectance * arriving_lx
    leaving = first
    for _ in range(_MOST_ROUNDS):
        before = leaving
        leaving = first + reflectance * (factors @ before)
        if np.abs(leaving - before).max() <= _GOOD_ENOUGH * max(float(leaving.max()), 1e-9):
            break
    return leaving


@njit(cache=True)
def mean_over_patches(where: Lattice, patches: Patches, values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the mean (N, C) over each patch of samples (T, C), from 4 x 4 places on it."""
    result = np.empty((patches.owner.shape[0], values.shape[1]), np.float32)
    total = np.empty(values.shape[1])
    for n in range(patches.owner.shape[0]):
        total[:] = 0.0
        for i in range(4):
            for j in range(4):
                u = patches.at[n, 0] + patches.share[n, 0] * ((j + 0.5) / 4 - 0.5)
                v = patches.at[n, 1] + patches.share[n, 1] * ((i + 0.5) / 4 - 0.5)
                add_between(where, patches.owner[n], u, v, 1.0 / 16, values, total)
        result[n] = total
    return result


@njit(cache=True)
def factors_between(obstacles: Rectangles, patches: Patches) -> NDArray[np.float32]:
    """Return the form factors (N, N) of patches, seen from the middle of each."""
    count = patches.middle_m.shape[0]
    factors = np.zeros((count, count), np.float32)
    scratch = np.empty((2, 6, 3))
    for i in range(count):
        for j in range(i):
            if not _face_each_other(patches, i, j):
                continue
            if _hidden(obstacles, patches.middle_m[i], patches.middle_m[j]):
                continue
            factors[i, j] = _factor(patches.middle_m[i], patches.normal[i], patches, j, scratch)
            factors[j, i] = _factor(patches.middle_m[j], patches.normal[j], patches, i, scratch)
    return factors


@njit(cache=True)
def arriving_at(
    obstacles: Rectangles,
    patches: Patches,
    leaving_lx: NDArray[np.float32],
    weight: NDArray[np.float32],
    points_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    owner: NDArray[np.int32],
) -> NDArray[np.float32]:
    """Return the light (T, C) of patches on points (T, 3) of surfaces with ``normals[owner]``.

    Args:
        leaving_lx: (N, C).
        weight: (N,) relative brightness of each patch, at most 1. Patches of large contributions are sampled at four
            places: through a door, whole patches would act as so many lamps.
    """
    result = np.zeros((points_m.shape[0], leaving_lx.shape[1]), np.float32)
    scratch, target = np.empty((2, 6, 3)), np.empty(3)
    for n in range(points_m.shape[0]):
        for j in range(patches.middle_m.shape[0]):
            factor = _factor(points_m[n], normals[owner[n]], patches, j, scratch)
            if factor <= 0.0:
                continue
            if factor * weight[j] < _MUCH:
                seen = 0.0 if _hidden(obstacles, points_m[n], patches.middle_m[j]) else 1.0
            else:
                seen = 0.0
                for corner in range(4):
                    a, b = (0.5 if corner % 2 else -0.5), (0.5 if corner // 2 else -0.5)
                    for k in range(3):
                        target[k] = patches.middle_m[j, k] + a * patches.half_a_m[j, k] + b * patches.half_b_m[j, k]
                    seen += 0.0 if _hidden(obstacles, points_m[n], target) else 0.25
            if seen > 0.0:
                for c in range(leaving_lx.shape[1]):
                    result[n, c] += seen * factor * leaving_lx[j, c]
    return result


@njit(cache=True)
def _face_each_other(patches: Patches, i: int, j: int) -> bool:
    """Return whether a part of each patch lies before the other, and not only in its plane."""
    there, back = 0.0, 0.0
    reach_i, reach_j = 0.0, 0.0
    for k in range(3):
        towards = patches.middle_m[j, k] - patches.middle_m[i, k]
        there += towards * patches.normal[i, k]
        back -= towards * patches.normal[j, k]
        reach_i += abs(patches.half_a_m[j, k] * patches.normal[i, k]) + abs(
            patches.half_b_m[j, k] * patches.normal[i, k]
        )
        reach_j += abs(patches.half_a_m[i, k] * patches.normal[j, k]) + abs(
            patches.half_b_m[i, k] * patches.normal[j, k]
        )
    return there > 2 * OFF_SURFACE_M - reach_i and back > 2 * OFF_SURFACE_M - reach_j


@njit(cache=True)
def _hidden(obstacles: Rectangles, a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return blocked(obstacles, a[0], a[1], a[2], b[0] - a[0], b[1] - a[1], b[2] - a[2], 1.0)


@njit(cache=True)
def _factor(
    point: NDArray[np.float64], normal: NDArray[np.float64], patches: Patches, j: int, scratch: NDArray[np.float64]
) -> float:
    """Return the form factor of patch j from a point: ``A cos cos' / (pi d²)``, or exactly if it is near."""
    squared, along, ahead, size_a, size_b = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        towards = patches.middle_m[j, k] - point[k]
        squared += towards * towards
        along += towards * normal[k]
        ahead -= towards * patches.normal[j, k]
        size_a += 4 * patches.half_a_m[j, k] ** 2
        size_b += 4 * patches.half_b_m[j, k] ** 2
    if ahead <= 1e-6:
        return 0.0
    if squared > _NEAR * _NEAR * max(size_a, size_b):
        return max(along, 0.0) * ahead * np.sqrt(size_a * size_b) / (np.pi * squared * squared)
    return _exact_factor(point, normal, patches, j, scratch)


@njit(cache=True)
def _exact_factor(
    point: NDArray[np.float64], normal: NDArray[np.float64], patches: Patches, j: int, scratch: NDArray[np.float64]
) -> float:
    """Return Lambert's (1760) form factor of the part of a rectangle above the horizon of a point.

    ``F = 1 / (2 pi) sum over edges of angle(r, r') n . (r x r') / |r x r'|`` with r, r' from the point to an edge's
    ends.
    """
    corners, above = scratch[0], scratch[1]
    for c in range(4):
        sign_a, sign_b = (-1.0 if c == 0 or c == 3 else 1.0), (-1.0 if c < 2 else 1.0)
        for k in range(3):
            corners[c, k] = (
                patches.middle_m[j, k]
                - OFF_SURFACE_M * patches.normal[j, k]
                + sign_a * patches.half_a_m[j, k]
                + sign_b * patches.half_b_m[j, k]
                - point[k]
            )
    count = _above_horizon(corners, normal, above)
    total = 0.0
    for c in range(count):
        total += _edge(above[c], above[(c + 1) % count], normal)
    return max(total / (2 * np.pi), 0.0)


@njit(cache=True)
def _above_horizon(corners: NDArray[np.float64], normal: NDArray[np.float64], above: NDArray[np.float64]) -> int:
    """Write the corners (<= 5, 3) of the part with ``n . r >= 0`` of a rectangle; return their number."""
    count = 0
    for c in range(4):
        here, there = corners[c], corners[(c + 1) % 4]
        h_here, h_there = 0.0, 0.0
        for k in range(3):
            h_here += here[k] * normal[k]
            h_there += there[k] * normal[k]
        if h_here >= 0.0:
            above[count] = here
            count += 1
        if (h_here >= 0.0) != (h_there >= 0.0):
            share = h_here / (h_here - h_there)
            for k in range(3):
                above[count, k] = here[k] + share * (there[k] - here[k])
            count += 1
    return count


@njit(cache=True)
def _edge(a: NDArray[np.float64], b: NDArray[np.float64], normal: NDArray[np.float64]) -> float:
    """Return ``angle(a, b) n . (b x a) / |a x b|``: corners are counter-clockwise where the rectangle is seen."""
    x, y, z = b[1] * a[2] - b[2] * a[1], b[2] * a[0] - b[0] * a[2], b[0] * a[1] - b[1] * a[0]
    length = np.sqrt(x * x + y * y + z * z)
    if length < 1e-12:
        return 0.0
    angle = np.arctan2(length, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    return angle * (x * normal[0] + y * normal[1] + z * normal[2]) / length
