"""The kernels of ``sim.shaders.daylight``, a row of pixels at a time.

Loops that compute, fetch and mix are separate, so that the first and the last become vector code.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.shadow_tiles import BLOCK
from sim.shaders.colour import srgb_to_linear

_CODES = np.arange(256)
_FIT = np.polynomial.Polynomial.fit(_CODES, srgb_to_linear(_CODES / 255.0), 6, domain=[-1, 1]).coef
P0, P1, P2, P3, P4, P5, P6 = (np.float32(coefficient) for coefficient in _FIT)
"""sRGB decoding as a polynomial of the code: a look-up for each pixel would cost ten times as much."""

ONE, HALF, ZERO = np.float32(1.0), np.float32(0.5), np.float32(0.0)
PER_PI = np.float32(1.0 / np.pi)
FLATTEST = np.float32(0.05)
NOT_IN_MAP = np.float32(-1.0)
"""In place of the cosine between normal and sun: the surface is not in the shadow map, and cannot shade itself."""
ALWAYS = np.float32(3e38)
FARTHEST_M = np.float32(1e6)
BYTE = np.uint32(255)
BLOCK_BITS = BLOCK.bit_length() - 1


class ShadowArrays(NamedTuple):
    """A shadow map as seen from a camera's pixels.

    Attributes:
        height_m: (N * N,) float32, see ``ShadowMap``.
        highest_m: (N / BLOCK * N / BLOCK,) float32, see there.
        size: N.
        from_pixel: (3, 4) float32: ``(column, row, height) = depth * from_pixel[:, :3] @ (x, y, 1) +
            from_pixel[:, 3]`` of the surface at pixel coordinates (x, y) and that depth.
        texel_m: side of a texel.
    """

    height_m: NDArray[np.float32]
    highest_m: NDArray[np.float32]
    size: int
    from_pixel: NDArray[np.float32]
    texel_m: np.float32


class DaylightArrays(NamedTuple):
    """Light in one picture as arrays for kernels, all float32.

    Attributes:
        towards_sun: (3,) unit vector.
        sun, sky, bounce: (3,) illuminances in lux, of R, G and B.
        shadows: in the camera's view.
    """

    towards_sun: NDArray[np.float32]
    sun: NDArray[np.float32]
    sky: NDArray[np.float32]
    bounce: NDArray[np.float32]
    shadows: ShadowArrays


class ShadowScratch(NamedTuple):
    """Scratch of ``shadow_row``, for rows of W pixels.

    Attributes:
        column, row, height: (W,) float32, position in the map. corners: (4, W) heights of the texels around it.
        texel, block: (W,) uint32 numbers of the upper left one and its block.
    """

    column: NDArray[np.float32]
    row: NDArray[np.float32]
    height: NDArray[np.float32]
    corners: NDArray[np.float32]
    texel: NDArray[np.uint32]
    block: NDArray[np.uint32]


class DaylightScratch(NamedTuple):
    """Scratch of ``shade_row``: ``lit`` is (W,) float32, ``max(0, n . l)`` times the share of the sun that arrives."""

    shadow: ShadowScratch
    lit: NDArray[np.float32]


def new_shadow_scratch(width: int) -> ShadowScratch:
    """Return scratch for rows of ``width`` pixels."""
    real, whole = np.empty((7, width), np.float32), np.empty((2, width), np.uint32)
    return ShadowScratch(real[0], real[1], real[2], real[3:], whole[0], whole[1])


def new_daylight_scratch(width: int) -> DaylightScratch:
    """Return scratch for rows of ``width`` pixels."""
    return DaylightScratch(new_shadow_scratch(width), np.empty(width, np.float32))


@row_kernel()
def shade_row(
    light: DaylightArrays, row: int, surfaces: SurfaceRow, scratch: DaylightScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (3, W) of one row."""
    colour, depth_m, normal, lit = surfaces.colour, surfaces.depth_m, surfaces.normal, scratch.lit
    _cosine(light, normal, lit)
    shadow_row(light.shadows, row, np.uint64(0), depth_m, lit, scratch.shadow, lit)
    for channel in range(3):
        reflectance_row(colour, np.uint32(8 * channel), radiance[channel])
        _light_up(light, channel, lit, depth_m, normal[2], radiance[channel])


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def reflectance_row(colour: NDArray[np.uint32], shift: np.uint32, reflectance: NDArray[np.float32]) -> None:
    """Write the linear value of one channel of packed sRGB colours."""
    mask, scale = _mask_and_scale(shift)
    for k in range(colour.shape[0]):
        reflectance[k] = _reflectance(colour[k], mask, scale)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def reflect_row(
    colour: NDArray[np.uint32], shift: np.uint32, light: NDArray[np.float32], radiance: NDArray[np.float32]
) -> None:
    """Write the light reflected by surfaces of one channel of packed sRGB colours."""
    mask, scale = _mask_and_scale(shift)
    for k in range(colour.shape[0]):
        radiance[k] = light[k] * _reflectance(colour[k], mask, scale)


@row_kernel(forceinline=True)
def _mask_and_scale(shift: np.uint32) -> tuple[np.uint32, np.float32]:
    """Return the mask of one channel of a packed colour, and the factor that scales it to 0-255.

    Shifts would yield 64-bit numbers, of which half as many fit into a vector.
    """
    return np.uint32(BYTE << shift), ONE / np.float32(np.int32(np.uint32(1) << shift))


@row_kernel(forceinline=True, fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _reflectance(colour: np.uint32, mask: np.uint32, scale: np.float32) -> np.float32:
    """Return the linear value of one channel of a packed sRGB colour, see ``_mask_and_scale``."""
    c = np.float32(np.int32(colour & mask)) * scale
    return P0 + c * (P1 + c * (P2 + c * (P3 + c * (P4 + c * (P5 + c * P6)))))


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _cosine(light: DaylightArrays, normal: NDArray[np.float32], cosine: NDArray[np.float32]) -> None:
    """Write ``max(0, n . l)``."""
    lx, ly, lz = light.towards_sun[0], light.towards_sun[1], light.towards_sun[2]
    nx, ny, nz = normal[0], normal[1], normal[2]
    for k in range(cosine.shape[0]):
        cosine[k] = max(nx[k] * lx + ny[k] * ly + nz[k] * lz, ZERO)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _light_coordinate(
    from_pixel: NDArray[np.float32],
    row: int,
    first_column: np.uint64,
    depth_m: NDArray[np.float32],
    shift: np.float32,
    low: np.float32,
    high: np.float32,
    coordinate: NDArray[np.float32],
) -> None:
    """Write ``depth * from_pixel[:3] @ (x, y, 1) + from_pixel[3] + shift`` at pixel centres, clipped to [low, high]."""
    base = from_pixel[1] * (np.float32(row) + HALF) + from_pixel[2] + HALF * from_pixel[0]
    step, at = from_pixel[0], from_pixel[3] + shift
    for k in range(depth_m.shape[0]):
        z = min(depth_m[k], FARTHEST_M)
        x = np.float32(np.int32(first_column + np.uint64(k)))
        coordinate[k] = min(max((base + step * x) * z + at, low), high)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _raise_by_bias(texel_m: np.float32, cosine: NDArray[np.float32], height: NDArray[np.float32]) -> None:
    """Add the rise of a lit surface itself within the 2x2 texels: ``texel (1.5 tan(n, l) + 0.75)``.

    Nothing is added where the cosine is ``NOT_IN_MAP``.
    """
    for k in range(cosine.shape[0]):
        c = max(cosine[k], FLATTEST)
        rise = texel_m * (np.float32(1.5) * np.sqrt(max(ONE - c * c, ZERO)) / c + np.float32(0.75))
        height[k] += rise if cosine[k] >= ZERO else ZERO


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _split_position(
    size: int,
    s: NDArray[np.float32],
    t: NDArray[np.float32],
    at: NDArray[np.uint32],
    block: NDArray[np.uint32],
) -> None:
    """Turn positions in texels into the numbers of the upper left texel and its block, and the fractions beyond it."""
    pitch, block_pitch = np.int32(size), np.int32(size // BLOCK)
    for k in range(s.shape[0]):
        j, i = np.int32(s[k]), np.int32(t[k])
        at[k] = np.uint32(np.int32(i * pitch) + j)
        block[k] = np.uint32(np.int32((i >> BLOCK_BITS) * block_pitch) + (j >> BLOCK_BITS))
        s[k] -= np.float32(j)
        t[k] -= np.float32(i)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _filter_shadow(
    corners: NDArray[np.float32],
    s: NDArray[np.float32],
    t: NDArray[np.float32],
    height: NDArray[np.float32],
    lit: NDArray[np.float32],
) -> None:
    """Multiply ``lit`` by the bilinear share of the four texels (4, W) that are not higher than ``height``."""
    c00, c01, c10, c11 = corners[0], corners[1], corners[2], corners[3]
    for k in range(lit.shape[0]):
        h, fs, ft = height[k], s[k], t[k]
        upper = (ONE - fs if c00[k] <= h else ZERO) + (fs if c01[k] <= h else ZERO)
        lower = (ONE - fs if c10[k] <= h else ZERO) + (fs if c11[k] <= h else ZERO)
        lit[k] *= upper + (lower - upper) * ft


@row_kernel(error_model="numpy")
def shadow_row(
    shadows: ShadowArrays,
    row: int,
    first_column: np.uint64,
    depth_m: NDArray[np.float32],
    cosine: NDArray[np.float32],
    scratch: ShadowScratch,
    lit: NDArray[np.float32],
) -> None:
    """Multiply ``lit`` (N,) by the share of sun rays that arrive where ``max(0, n . l)`` is ``cosine``.

    ``cosine`` may also be ``NOT_IN_MAP``. The map's outermost texels are never covered, so places outside are lit.

    Args:
        first_column: of the N columns of ``depth_m``, ``cosine`` and ``lit``.
        scratch: for rows of N pixels or more.
    """
    s, t, height, corners = scratch.column, scratch.row, scratch.height, scratch.corners
    texel, block = scratch.texel, scratch.block
    largest = np.float32(shadows.size) - np.float32(1.001)
    _light_coordinate(shadows.from_pixel[0], row, first_column, depth_m, -HALF, ZERO, largest, s)
    _light_coordinate(shadows.from_pixel[1], row, first_column, depth_m, -HALF, ZERO, largest, t)
    _light_coordinate(shadows.from_pixel[2], row, first_column, depth_m, ZERO, -ALWAYS, ALWAYS, height)
    _raise_by_bias(shadows.texel_m, cosine, height)
    count = lit.shape[0]
    _split_position(shadows.size, s[:count], t[:count], texel, block)
    heights_m, below = shadows.height_m, np.uint64(shadows.size)
    for k in range(lit.shape[0]):
        if shadows.highest_m[block[k]] <= height[k]:
            corners[0, k] = corners[1, k] = corners[2, k] = corners[3, k] = -ALWAYS
            continue
        corner = np.uint64(texel[k])
        corners[0, k] = heights_m[corner]
        corners[1, k] = heights_m[corner + np.uint64(1)]
        corners[2, k] = heights_m[corner + below]
        corners[3, k] = heights_m[corner + below + np.uint64(1)]
    _filter_shadow(corners, s, t, height, lit)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _light_up(
    light: DaylightArrays,
    channel: int,
    lit: NDArray[np.float32],
    depth_m: NDArray[np.float32],
    normal_z: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Turn one channel's reflectance rho into ``L = rho (sun lit + sky (1 + n_z) / 2 + bounce (1 - n_z) / 2) / pi``.

    ``lit`` includes the factor ``max(0, n . l)``. Where depth is inf, the sky itself is seen.
    """
    infinity = np.float32(np.inf)
    sun, sky = light.sun[channel] * PER_PI, light.sky[channel] * PER_PI
    bounce = light.bounce[channel] * PER_PI
    level, tilt = HALF * (sky + bounce), HALF * (sky - bounce)
    for k in range(depth_m.shape[0]):
        out = radiance[k] * (sun * lit[k] + level + tilt * normal_z[k])
        radiance[k] = out if depth_m[k] < infinity else sky
