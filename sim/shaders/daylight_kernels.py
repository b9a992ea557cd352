"""The kernels of ``sim.shaders.daylight``, a row of pixels at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.shaders.colour import srgb_to_linear

if TYPE_CHECKING:
    from sim.shaders.daylight import DaylightArrays, ShadowArrays

LINEAR = srgb_to_linear(np.arange(256) / 255.0).astype(np.float32)
"""Linear value of each sRGB code."""

ONE, HALF, ZERO = np.float32(1.0), np.float32(0.5), np.float32(0.0)
PER_PI = np.float32(1.0 / np.pi)
STEEPEST = np.float32(12.0)


@njit(cache=True)
def shade_picture(
    light: DaylightArrays,
    shadows: ShadowArrays,
    base_colour_rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    normal_world: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance (3, H, W) of a G-buffer's arrays (H, W) or (H, W, 3)."""
    lit = np.empty(depth_m.shape[1], np.float32)
    for row in range(depth_m.shape[0]):
        lit_row(light, shadows, row, depth_m[row], normal_world[row], lit)
        shade_row(light, lit, base_colour_rgb[row], depth_m[row], normal_world[row], radiance[:, row])


@njit(cache=True, fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def lit_row(
    light: DaylightArrays,
    shadows: ShadowArrays,
    row: int,
    depth_m: NDArray[np.float32],
    normal_world: NDArray[np.float32],
    lit: NDArray[np.float32],
) -> None:
    """Write max(0, n . l) times the share of sun rays that arrive, for one row of pixels.

    A surface at height h (towards the sun) is lit by the texels whose caster is not higher than ``h +
    bias``. Within the 2x2 texels the surface itself rises by up to ``1.5 texel tan(n, l)``, which the bias
    must be.
    """
    m = shadows.from_pixel
    y = np.float32(row) + HALF
    column_base, column_step, column_at = m[0, 1] * y + m[0, 2], m[0, 0], m[0, 3]
    row_base, row_step, row_at = m[1, 1] * y + m[1, 2], m[1, 0], m[1, 3]
    height_base, height_step, height_at = m[2, 1] * y + m[2, 2], m[2, 0], m[2, 3]
    lx, ly, lz = light.towards_sun[0], light.towards_sun[1], light.towards_sun[2]
    size = np.int32(shadows.size)
    last = np.float32(size - 1)
    bias_m = np.float32(1.5) * shadows.texel_m
    for k in range(depth_m.shape[0]):
        cosine = normal_world[k, 0] * lx + normal_world[k, 1] * ly + normal_world[k, 2] * lz
        lit[k] = max(cosine, ZERO)
        z = depth_m[k]
        x = np.float32(k) + HALF
        s = (column_base + column_step * x) * z + column_at - HALF
        t = (row_base + row_step * x) * z + row_at - HALF
        if not (cosine > ZERO and s >= ZERO and s < last and t >= ZERO and t < last):
            continue
        slope = min(np.sqrt(max(ONE - cosine * cosine, ZERO)) / cosine, STEEPEST)
        h = (height_base + height_step * x) * z + height_at + bias_m * (slope + HALF)
        j, i = np.int32(s), np.int32(t)
        fs, ft = s - np.float32(j), t - np.float32(i)
        at = np.uint32(i * size + j)
        below = at + np.uint32(size)
        upper = (ONE - fs if shadows.height_m[at] <= h else ZERO) + (
            fs if shadows.height_m[at + np.uint32(1)] <= h else ZERO
        )
        lower = (ONE - fs if shadows.height_m[below] <= h else ZERO) + (
            fs if shadows.height_m[below + np.uint32(1)] <= h else ZERO
        )
        lit[k] = cosine * (upper + (lower - upper) * ft)


@njit(cache=True, fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def shade_row(
    light: DaylightArrays,
    lit: NDArray[np.float32],
    base_colour_rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    normal_world: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Write ``L = rho (sun lit + sky (1 + n_z) / 2 + bounce (1 - n_z) / 2) / pi`` of one row; the sky's
    where depth is inf.

    ``lit`` includes the factor ``max(0, n . l)``.
    """
    infinity = np.float32(np.inf)
    for channel in range(3):
        sun = light.sun[channel] * PER_PI
        sky, bounce = light.sky[channel] * PER_PI, light.bounce[channel] * PER_PI
        level, tilt = HALF * (sky + bounce), HALF * (sky - bounce)
        for k in range(depth_m.shape[0]):
            light_in = sun * lit[k] + level + tilt * normal_world[k, 2]
            out = LINEAR[base_colour_rgb[k, channel]] * light_in
            radiance[channel, k] = out if depth_m[k] < infinity else sky
        if light.haze_per_m > ZERO:
            for k in range(depth_m.shape[0]):
                through = np.exp(-light.haze_per_m * depth_m[k])
                radiance[channel, k] = sky + (radiance[channel, k] - sky) * through
