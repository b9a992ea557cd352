"""Daylight: a sun that casts shadows, with the sky and the lit ground as ambient light.

Loops that compute, fetch and mix are separate, so that the first and the last become vector code.

For a surface with reflectance ``rho`` (linear base colour), normal ``n`` and the direction ``l`` towards
the sun

    E = sun * max(0, n . l) * lit + sky * (1 + n_z) / 2 + bounce * (1 - n_z) / 2
    L = rho * E / pi
    bounce = 0.2 * (sun * max(0, l_z) + sky)

with illuminances in lux, so the radiance L is a luminance in cd/m² for each of R, G and B. ``lit`` in [0,
1] is the share of a 2x2 neighbourhood of shadow-map texels that see the sun, weighted bilinearly
(percentage-closer filtering, Reeves et al. 1987).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import GBuffer
from sim.optics import Camera, ray_of_pixel
from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.row_stages import RowStage, light_picture
from sim.render.shadow_map import BLOCK, ShadowCaster, bounds_across, find_tiles
from sim.shaders.colour import LUMINANCE_WEIGHTS, srgb_to_linear
from sim.world import World

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
    cosine_row(light, normal, lit)
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


@row_kernel()
def _mask_and_scale(shift: np.uint32) -> tuple[np.uint32, np.float32]:
    """Return the mask of one channel of a packed colour, and the factor that scales it to 0-255.

    Shifts would yield 64-bit numbers, of which half as many fit into a vector.
    """
    return np.uint32(BYTE << shift), ONE / np.float32(np.int32(np.uint32(1) << shift))


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _reflectance(colour: np.uint32, mask: np.uint32, scale: np.float32) -> np.float32:
    """Return the linear value of one channel of a packed sRGB colour, see ``_mask_and_scale``."""
    c = np.float32(np.int32(colour & mask)) * scale
    return P0 + c * (P1 + c * (P2 + c * (P3 + c * (P4 + c * (P5 + c * P6)))))


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def cosine_row(light: DaylightArrays, normal: NDArray[np.float32], cosine: NDArray[np.float32]) -> None:
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
    size: int, s: NDArray[np.float32], t: NDArray[np.float32], at: NDArray[np.uint32], block: NDArray[np.uint32]
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


GROUND_REFLECTANCE = 0.2
SHADOW_REACH_M = 400.0
"""Shadows are drawn on surfaces up to this depth."""
SHADOW_TEXELS = 1024
_PROBE_STEP_PX = 16


@dataclass(frozen=True, slots=True)
class Sun:
    """The sun.

    Attributes:
        direction: from the scene towards the sun, world frame; any length > 0.
        illuminance_lx: on a surface perpendicular to it, >= 0.
        colour_rgb: relative linear R, G, B.
    """

    direction: tuple[float, float, float] | NDArray[np.float64]
    illuminance_lx: float
    colour_rgb: tuple[float, float, float] = (1.06, 1.0, 0.88)


class DaylightShader:
    """Lights G-buffers of one world, whichever renderer drew them."""

    lighting = RowStage(shade_row, new_daylight_scratch)

    def __init__(
        self,
        world: World,
        sun: Sun,
        sky_illuminance_lx: float,
        *,
        sky_colour_rgb: tuple[float, float, float] = (0.86, 1.0, 1.3),
        shadow_texels: int = SHADOW_TEXELS,
    ) -> None:
        """Set the light.

        Args:
            sky_illuminance_lx: on level ground, >= 0.
            sky_colour_rgb: relative linear R, G, B.
            shadow_texels: side of the shadow map, see ``ShadowCaster``; it covers a little more than the view.
        """
        direction = np.asarray(sun.direction, dtype=float)
        check("sun.direction", bool(np.linalg.norm(direction) > 0), "a vector of length > 0", sun.direction)
        check("sun.illuminance_lx", sun.illuminance_lx >= 0, "a number >= 0", sun.illuminance_lx)
        check("sky_illuminance_lx", sky_illuminance_lx >= 0, "a number >= 0", sky_illuminance_lx)
        towards_sun = direction / np.linalg.norm(direction)
        sun_lx = sun.illuminance_lx * of_unit_luminance(sun.colour_rgb)
        sky_lx = sky_illuminance_lx * of_unit_luminance(sky_colour_rgb)
        bounce_lx = GROUND_REFLECTANCE * (sun_lx * max(0.0, towards_sun[2]) + sky_lx)
        self._caster = ShadowCaster(world, towards_sun, shadow_texels)
        self._light = (
            towards_sun.astype(np.float32),
            sun_lx.astype(np.float32),
            sky_lx.astype(np.float32),
            bounce_lx.astype(np.float32),
        )

    def shade(self, gbuffer: GBuffer, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B, of a G-buffer sampled at
        pixel centres.
        """
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> DaylightArrays:
        """Return the present light in one camera's picture, for the row kernel.

        Args:
            depth_m: (H, W).
        """
        return DaylightArrays(*self._light, shadows_in_view(self._caster, depth_m, camera, T_world_camera))


def shadows_in_view(
    caster: ShadowCaster, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
) -> ShadowArrays:
    """Return the shadows in a camera's present view.

    Args:
        depth_m: (H, W); every 16th pixel of every 16th row determines the region of the map, all pixels its tiles.
    """
    position_m, R_world_camera = T_world_camera[:3, 3], T_world_camera[:3, :3]
    rays = ray_of_pixel(camera)
    across = caster.axes[:2]
    across_of_pixel = np.empty((2, 4))
    across_of_pixel[:, :3], across_of_pixel[:, 3] = across @ R_world_camera @ rays, across @ position_m
    low_m, high_m = np.empty(2), np.empty(2)
    probe_depth_m = depth_m[::_PROBE_STEP_PX, ::_PROBE_STEP_PX]
    bounds_across(probe_depth_m, _PROBE_STEP_PX, SHADOW_REACH_M, across_of_pixel, low_m, high_m)
    if not low_m[0] <= high_m[0]:
        low_m = high_m = across @ position_m
    region = caster.region(low_m, high_m)
    in_map = region.in_map
    from_pixel = np.empty((3, 4))
    from_pixel[:, :3] = in_map[:, :3] @ R_world_camera @ rays
    from_pixel[:, 3] = in_map[:, :3] @ position_m + in_map[:, 3]
    wanted = np.empty_like(region.arrays.drawn)
    find_tiles(depth_m, from_pixel, wanted)
    shadow_map = caster.draw(region, wanted)
    return ShadowArrays(
        shadow_map.height_m.ravel(),
        shadow_map.highest_m.ravel(),
        shadow_map.height_m.shape[0],
        from_pixel.astype(np.float32),
        np.float32(shadow_map.texel_m),
    )


def of_unit_luminance(colour_rgb: tuple[float, float, float]) -> NDArray[np.float64]:
    colour = np.asarray(colour_rgb, dtype=float)
    return colour / float(colour @ LUMINANCE_WEIGHTS)
