"""Intersection of rays and rectangles, for baked light.

A ray ``origin + t direction`` meets the plane of a rectangle at ``t = (offset - n . origin) / (n . direction)``, and
the rectangle itself if the point's shares u and v of its two sides are in [0, 1]. All rectangles are tested without
branches, sixteen at once: for a hundred that is faster than a tree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

OFF_SURFACE_M = 0.003
"""Distance before its surfaces at which a ray starts and ends."""
_BACK_BEHIND = 0.002
"""Share of a direction by which fronts are nearer than backs, for two rectangles back to back in one place."""


class Rectangles(NamedTuple):
    """R rectangles, float32.

    Attributes:
        normal: (3, R) unit vectors, side_a x side_b. offset: (R,) of the planes, n . corner.
        across: (6, R) side_a / |side_a|² and side_b / |side_b|²; a point's u and v are its products with them, less
            start: (2, R).
    """

    normal: NDArray[np.float32]
    offset: NDArray[np.float32]
    across: NDArray[np.float32]
    start: NDArray[np.float32]


def rectangles(
    corner_m: NDArray[np.float64], side_a_m: NDArray[np.float64], side_b_m: NDArray[np.float64]
) -> Rectangles:
    """Return rectangles by a corner and the two sides that begin there, (R, 3) each."""
    normal = np.cross(side_a_m, side_b_m)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    across_a = side_a_m / (side_a_m**2).sum(axis=1, keepdims=True)
    across_b = side_b_m / (side_b_m**2).sum(axis=1, keepdims=True)
    start = np.stack([(across_a * corner_m).sum(axis=1), (across_b * corner_m).sum(axis=1)])
    across = np.concatenate([across_a.T, across_b.T])
    offset = (normal * corner_m).sum(axis=1)
    in_rows = (np.ascontiguousarray(array, dtype=np.float32) for array in (normal.T, offset, across, start))
    return Rectangles(*in_rows)


def sphere_directions(count: int) -> NDArray[np.float64]:
    """Return unit vectors (count, 3) spread evenly over the sphere on a Fibonacci spiral, from below upwards.

    The z are the middles of ``count`` equal pieces of [-1, 1], so any zone has its share of them (Archimedes).
    """
    z = (2 * np.arange(count) + 1) / count - 1
    turn_rad = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    radius = np.sqrt(1 - z * z)
    return np.column_stack([radius * np.cos(turn_rad), radius * np.sin(turn_rad), z])


@njit(cache=True, forceinline=True, fastmath={"contract", "arcp", "nsz", "reassoc"}, error_model="numpy")
def blocked(
    them: Rectangles, x: float, y: float, z: float, along_x: float, along_y: float, along_z: float, farthest: float
) -> bool:
    """Return whether any rectangle, from either side, is met at 0 < t < ``farthest``."""
    ox, oy, oz = np.float32(x), np.float32(y), np.float32(z)
    dx, dy, dz = np.float32(along_x), np.float32(along_y), np.float32(along_z)
    zero, one, last = np.float32(0.0), np.float32(1.0), np.float32(farthest)
    nx, ny, nz, offset = them.normal[0], them.normal[1], them.normal[2], them.offset
    ax, ay, az, a_start = them.across[0], them.across[1], them.across[2], them.start[0]
    bx, by, bz, b_start = them.across[3], them.across[4], them.across[5], them.start[1]
    met = np.int32(0)
    for r in range(offset.shape[0]):
        t = (offset[r] - (nx[r] * ox + ny[r] * oy + nz[r] * oz)) / (nx[r] * dx + ny[r] * dy + nz[r] * dz)
        px, py, pz = ox + t * dx, oy + t * dy, oz + t * dz
        u = ax[r] * px + ay[r] * py + az[r] * pz - a_start[r]
        v = bx[r] * px + by[r] * py + bz[r] * pz - b_start[r]
        inside = (t > zero) & (t < last) & (u >= zero) & (u <= one) & (v >= zero) & (v <= one)
        met |= np.int32(inside)
    return met != 0


@njit(cache=True, forceinline=True, fastmath={"contract", "arcp", "nsz", "reassoc"}, error_model="numpy")
def nearest(
    them: Rectangles,
    x: float,
    y: float,
    z: float,
    along_x: float,
    along_y: float,
    along_z: float,
    distances: NDArray[np.float32],
) -> tuple[int, float, float, bool]:
    """Return the nearest rectangle that a ray meets (-1 for none), u and v there, and whether it is met from the
    front; ``distances`` (R,) is scratch.
    """
    ox, oy, oz = np.float32(x), np.float32(y), np.float32(z)
    dx, dy, dz = np.float32(along_x), np.float32(along_y), np.float32(along_z)
    zero, one, never = np.float32(0.0), np.float32(1.0), np.float32(1e30)
    behind = np.float32(_BACK_BEHIND)
    nx, ny, nz, offset = them.normal[0], them.normal[1], them.normal[2], them.offset
    ax, ay, az, a_start = them.across[0], them.across[1], them.across[2], them.start[0]
    bx, by, bz, b_start = them.across[3], them.across[4], them.across[5], them.start[1]
    for r in range(offset.shape[0]):
        towards = nx[r] * dx + ny[r] * dy + nz[r] * dz
        t = (offset[r] - (nx[r] * ox + ny[r] * oy + nz[r] * oz)) / towards
        px, py, pz = ox + t * dx, oy + t * dy, oz + t * dz
        u = ax[r] * px + ay[r] * py + az[r] * pz - a_start[r]
        v = bx[r] * px + by[r] * py + bz[r] * pz - b_start[r]
        inside = (t > zero) & (t < never) & (u >= zero) & (u <= one) & (v >= zero) & (v <= one)
        distances[r] = (t if towards < zero else t + behind) if inside else never
    found, t = -1, never
    for r in range(offset.shape[0]):
        if distances[r] < t:
            found, t = r, distances[r]
    if found < 0:
        return -1, 0.0, 0.0, False
    front = nx[found] * dx + ny[found] * dy + nz[found] * dz < zero
    t -= zero if front else behind
    px, py, pz = ox + t * dx, oy + t * dy, oz + t * dz
    u = ax[found] * px + ay[found] * py + az[found] * pz - a_start[found]
    v = bx[found] * px + by[found] * py + bz[found] * pz - b_start[found]
    return found, min(max(float(u), 0.0), 1.0), min(max(float(v), 0.0), 1.0), front


@njit(cache=True)
def count_backs(
    them: Rectangles,
    points_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    owner: NDArray[np.int32],
    directions: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the share (N,) of rays from each point that first meet the back of a rectangle.

    Only directions (K, 3) before the point's surface count: ``normals[owner]``, 0 for points on no surface. A point
    that sees mostly backs lies inside a wall or behind an object on it.
    """
    share = np.zeros(points_m.shape[0])
    distances = np.empty(them.offset.shape[0], np.float32)
    for n in range(points_m.shape[0]):
        traced, backs = 0, 0
        normal = normals[owner[n]]
        anywhere = normal[0] == 0.0 and normal[1] == 0.0 and normal[2] == 0.0
        for k in range(directions.shape[0]):
            dx, dy, dz = directions[k, 0], directions[k, 1], directions[k, 2]
            if not anywhere and dx * normal[0] + dy * normal[1] + dz * normal[2] <= 0.1:
                continue
            found, _, _, front = nearest(them, points_m[n, 0], points_m[n, 1], points_m[n, 2], dx, dy, dz, distances)
            traced += 1
            backs += 1 if found >= 0 and not front else 0
        share[n] = backs / max(traced, 1)
    return share
