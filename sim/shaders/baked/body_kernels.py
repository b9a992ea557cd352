"""Light on runs of pixels without a panel: of other bodies, and of the sky.

Pixels are those from ``first`` up to, not including, ``last`` of the row's arrays (W,).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel

ONE, ZERO = np.float32(1.0), np.float32(0.0)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def body_run(
    cubes: NDArray[np.float32],
    body: int,
    first: np.uint64,
    last: np.uint64,
    normal: NDArray[np.float32],
    red: NDArray[np.float32],
    green: NDArray[np.float32],
    blue: NDArray[np.float32],
) -> None:
    """Write ``sum of n_k² E_side(k)`` of pixels of a body."""
    cube = cubes[body]  # Loaded before the loop, which then selects between two numbers each and becomes vector code.
    r0, r1, r2, r3, r4, r5 = cube[0, 0], cube[1, 0], cube[2, 0], cube[3, 0], cube[4, 0], cube[5, 0]
    g0, g1, g2, g3, g4, g5 = cube[0, 1], cube[1, 1], cube[2, 1], cube[3, 1], cube[4, 1], cube[5, 1]
    b0, b1, b2, b3, b4, b5 = cube[0, 2], cube[1, 2], cube[2, 2], cube[3, 2], cube[4, 2], cube[5, 2]
    for k in range(first, last):
        x, y, z = normal[0, k], normal[1, k], normal[2, k]
        is_ahead, is_aside, is_up = x > ZERO, y > ZERO, z > ZERO
        x, y, z = x * x, y * y, z * z
        red[k] = x * (r0 if is_ahead else r3) + y * (r1 if is_aside else r4) + z * (r2 if is_up else r5)
        green[k] = x * (g0 if is_ahead else g3) + y * (g1 if is_aside else g4) + z * (g2 if is_up else g5)
        blue[k] = x * (b0 if is_ahead else b3) + y * (b1 if is_aside else b4) + z * (b2 if is_up else b5)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sun_on_body(
    towards_sun: NDArray[np.float32],
    share: np.float32,
    first: np.uint64,
    last: np.uint64,
    normal: NDArray[np.float32],
    cosine: NDArray[np.float32],
    sun_lit: NDArray[np.float32],
) -> None:
    """Write ``max(0, n . l)`` of pixels of a body, and its product with the share of the sun that arrives."""
    for k in range(first, last):
        along = normal[0, k] * towards_sun[0] + normal[1, k] * towards_sun[1] + normal[2, k] * towards_sun[2]
        cosine[k] = max(along, ZERO)
        sun_lit[k] = share * cosine[k]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sky_run(
    sky: NDArray[np.float32],
    rays: NDArray[np.float32],
    row: int,
    first: np.uint64,
    last: np.uint64,
    red: NDArray[np.float32],
    green: NDArray[np.float32],
    blue: NDArray[np.float32],
) -> None:
    """Write the sky's radiance in the directions of pixels."""
    down = np.float32(row)
    bx, by, bz = rays[0, 0] + down * rays[2, 0], rays[0, 1] + down * rays[2, 1], rays[0, 2] + down * rays[2, 2]
    sx, sy, sz = rays[1, 0], rays[1, 1], rays[1, 2]
    r, g, b = sky[0, 0], sky[0, 1], sky[0, 2]
    r_rise, g_rise, b_rise = sky[1, 0], sky[1, 1], sky[1, 2]
    for k in range(first, last):
        column = np.float32(np.int32(k))
        dx, dy, dz = bx + column * sx, by + column * sy, bz + column * sz
        flat = ONE - max(dz, ZERO) / np.sqrt(dx * dx + dy * dy + dz * dz)
        red[k], green[k], blue[k] = r + r_rise * flat, g + g_rise * flat, b + b_rise * flat
