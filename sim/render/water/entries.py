"""Where points of the water are seen: the way back of ``sim.render.water.rays``, of the sum of waves itself."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.water.rays import STEEPEST, WaterBody, bend, ray, vanishing
from sim.water_surface import Waves, sum_waves

_SAME_HEIGHT_M = 1e-8
"""Heights of the surface that differ less are at one place: to a thousandth of a pixel, even of a grazing ray."""


@njit(cache=True, error_model="numpy")
def _exact_ray(
    water: WaterBody,
    waves: Waves,
    time_s: float,
    origin: NDArray[np.float64],
    matrix: NDArray[np.float64],
    projection: NDArray[np.float64],
    x: float,
    y: float,
) -> tuple[float, float, float]:
    """Return z_s and e of one pixel, of the sum of waves itself; NaN where the ray misses the water."""
    dx, dy, dz = ray(matrix, x, y)
    if not dz < STEEPEST:
        return np.nan, np.nan, np.nan
    height, before, slope_x, slope_y, depth = 0.0, np.inf, 0.0, 0.0, 0.0
    for _ in range(5):
        if abs(height - before) < _SAME_HEIGHT_M:
            break
        before, depth = height, (water.level_m + height - origin[2]) / dz
        height, slope_x, slope_y = sum_waves(waves, time_s, origin[0] + depth * dx, origin[1] + depth * dy)
    tx, ty, tz, _, _ = bend(dx, dy, dz, slope_x, slope_y, water.refractive_index)
    vx, vy = vanishing(projection, tx, ty, tz)
    return depth, vx - x, vy - y


@njit(cache=True, error_model="numpy")
def find_entries(
    water: WaterBody,
    waves: Waves,
    time_s: float,
    origin: NDArray[np.float64],
    matrix: NDArray[np.float64],
    projection: NDArray[np.float64],
    depth_m: NDArray[np.float64],
    pixels: NDArray[np.float64],
) -> None:
    """Replace pixels (N, 2), where the inner renderer draws points at depths (N,), by those at which they are seen.

    Solves ``p + (1 - z_s(p) / w) e(p) = q`` by Broyden's method (1965), from p = q with the unit matrix.
    """
    for n in range(pixels.shape[0]):
        qx, qy, w = pixels[n, 0], pixels[n, 1], depth_m[n]
        x, y, x_before, y_before, fx_before, fy_before = qx, qy, qx, qy, 0.0, 0.0
        a, b, c, d = 1.0, 0.0, 0.0, 1.0
        found = False
        for iteration in range(40):
            z, ex, ey = _exact_ray(water, waves, time_s, origin, matrix, projection, x, y)
            share = 1.0 - z / w
            fx, fy = x + share * ex - qx, y + share * ey - qy
            if fx * fx + fy * fy < 1e-7:
                found = True
                break
            if iteration > 0:
                # The inverse Jacobian (a b; c d) changes by the least that explains the last step (Sherman-Morrison).
                sx, sy, gx, gy = x - x_before, y - y_before, fx - fx_before, fy - fy_before
                ux, uy = a * gx + b * gy, c * gx + d * gy
                scale = 1.0 / (sx * ux + sy * uy)
                rx, ry = (sx - ux) * scale, (sy - uy) * scale
                lx, ly = sx * a + sy * c, sx * b + sy * d
                a, b, c, d = a + rx * lx, b + rx * ly, c + ry * lx, d + ry * ly
            x_before, y_before, fx_before, fy_before = x, y, fx, fy
            x, y = x - (a * fx + b * fy), y - (c * fx + d * fy)
        pixels[n, 0], pixels[n, 1] = (x, y) if found else (np.nan, np.nan)
