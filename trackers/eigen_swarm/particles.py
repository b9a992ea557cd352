"""Kernels of the three-dimensional particle filter of paper D: motion, likelihood, and the region of a cloud."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def move(
    states: NDArray[np.float64],
    noise: NDArray[np.float64],
    interval_s: float,
    place_noise_m: float,
    velocity_noise_mps: float,
) -> None:
    """Equation (3) in place: ``x_t = F x_{t−1} + W``, ``F`` moves each place on by its velocity.

    Args:
        states: (N, 6) x, y, z in metres, their velocities in m/s. noise: (N, 6) standard normal.
        place_noise_m, velocity_noise_mps: standard deviations of W.
    """
    for i in range(len(states)):
        for axis in range(3):
            states[i, axis] += interval_s * states[i, 3 + axis] + place_noise_m * noise[i, axis]
            states[i, 3 + axis] += velocity_noise_mps * noise[i, 3 + axis]


@njit(cache=True)
def likelihoods(
    states: NDArray[np.float64],
    P_block_world: NDArray[np.float64],
    f: NDArray[np.float64],
    centre_m: NDArray[np.float64],
    axes: NDArray[np.float64],
    half_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The likelihood of each particle, section 2.2: f of the block into which the camera projects it.

    ``(a, b, c) = P (x, y, z, 1)``; block row ``floor(b / c)``, column ``floor(a / c)``. It is 0 outside the watched
    volume, outside the picture and behind the camera, where nothing is seen.

    Args:
        states: (N, 6). P_block_world: (3, 4), from metres to blocks.
        f: (rows, columns), equation (2).
        centre_m: (3,), axes: (3, 3) rows, half_m: (3,) half the extents of the watched volume.

    Returns:
        (N,).
    """
    rows, columns = f.shape
    result = np.zeros(len(states))
    for i in range(len(states)):
        x, y, z = states[i, 0], states[i, 1], states[i, 2]
        inside = True
        for axis in range(3):
            offset = axes[axis, 0] * (x - centre_m[0]) + axes[axis, 1] * (y - centre_m[1])
            offset += axes[axis, 2] * (z - centre_m[2])
            inside = inside and abs(offset) <= half_m[axis]
        c = P_block_world[2, 0] * x + P_block_world[2, 1] * y + P_block_world[2, 2] * z + P_block_world[2, 3]
        if not inside or c <= 0.0:
            continue
        a = P_block_world[0, 0] * x + P_block_world[0, 1] * y + P_block_world[0, 2] * z + P_block_world[0, 3]
        b = P_block_world[1, 0] * x + P_block_world[1, 1] * y + P_block_world[1, 2] * z + P_block_world[1, 3]
        if 0.0 <= a < columns * c and 0.0 <= b < rows * c:
            result[i] = f[min(int(b / c), rows - 1), min(int(a / c), columns - 1)]
    return result


@njit(cache=True)
def cloud(
    states: NDArray[np.float64], likelihood: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Centre, direction and spread of a cloud, section 3.1.

    ``x_0 = Σ π_i x_i / Σ π_i`` (equations (4), (5)), y_0 and z_0 alike. PCA of the places in the XY plane about the
    centre: ``a_1`` is the direction of the greatest variance ``sigma_1²``, ``a_2`` lies across. ``sigma_z`` likewise.

    Args:
        states: (N, 6) resampled particles. likelihood: (N,) π, not all zero.

    Returns:
        centre (3,); a_1 (2,) of length 1; (sigma_1, sigma_2, sigma_z).
    """
    count = len(states)
    centre = np.zeros(3)
    total = 0.0
    for i in range(count):
        total += likelihood[i]
        for axis in range(3):
            centre[axis] += likelihood[i] * states[i, axis]
    centre /= total
    xx, xy, yy, zz = 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        x, y, z = states[i, 0] - centre[0], states[i, 1] - centre[1], states[i, 2] - centre[2]
        xx += x * x
        xy += x * y
        yy += y * y
        zz += z * z
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    c, s = np.cos(angle), np.sin(angle)
    along = c * c * xx + 2.0 * c * s * xy + s * s * yy
    across = s * s * xx - 2.0 * c * s * xy + c * c * yy
    spread = np.sqrt(np.maximum(np.array([along, across, zz]) / count, 0.0))
    return centre, np.array([c, s]), spread


@njit(cache=True)
def count_inside(
    states: NDArray[np.float64], centre: NDArray[np.float64], a1: NDArray[np.float64], half_m: NDArray[np.float64]
) -> int:
    """N_in of equation (6): the particles inside the region, an upright box with one side along a_1.

    Args:
        states: (N, 6). centre: (3,). a1: (2,).
        half_m: (3,) half of the region's depth, width and height.
    """
    inside = 0
    for i in range(len(states)):
        x, y, z = states[i, 0] - centre[0], states[i, 1] - centre[1], states[i, 2] - centre[2]
        along, across = a1[0] * x + a1[1] * y, a1[0] * y - a1[1] * x
        inside += abs(along) <= half_m[0] and abs(across) <= half_m[1] and abs(z) <= half_m[2]
    return inside
