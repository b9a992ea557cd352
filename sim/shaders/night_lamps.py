"""Street lamps and headlights: a map of the light that they throw on and above the ground.

A small source of intensity I, d away in the direction u, brings the vector ``I u / d²``; a surface of normal n gets its
part along n (inverse square and cosine). The map holds the sum of these vectors on the ground for street lamps, baked
once with the shadows of what stands around, and for headlights, written anew for each picture.

Street lamps shine as the luminaires of streets do: ``I(gamma) = I0 min(1 / cos³ gamma, 2.2)``, which lights the road
evenly, and nothing above 80° from straight down. Dipped beams are brightest just below the horizon (UN Regulation 112):
``I = I0 exp(-(a / 14°)² / 2) exp(-v / 3.5°)`` at a to the side and v downwards.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import Camera, may_show
from sim.render.compilation import row_kernel
from sim.shaders.ground_map import AWAY_M, COARSE_M, Footprint, GroundArrays, HeightMap

EVEN_UP_TO = 2.2
_FROM_DEG, _UP_TO_DEG = 66.0, 80.0
"""Between these angles from straight down a street lamp's light ends."""
_REACH = 5.0
"""Lamps light the ground up to so many times their height."""
CROWN_LEFT = 0.82
"""Share of a lamp's light that a cell's width of foliage lets through."""
_CROWN_FROM = 0.35
"""Share of a tree's height at which its crown begins."""
BEAM_CD, BEAM_HEIGHT_M, BEAM_REACH_M = 40_000.0, 0.65, 46.0
"""Of both headlights of a car together, in the brightest direction; where they are; how far they are drawn."""
_BEAM_ASIDE_DEG, _BEAM_DOWN_DEG = 14.0, 3.5
_PER_ASIDE, _PER_DOWN = np.degrees(1.0) / _BEAM_ASIDE_DEG, np.degrees(1.0) / _BEAM_DOWN_DEG
_WIDEST = 1.5
"""Tangent of the angle to the side at which a beam ends."""
BLOCK = 8
"""Neighbouring pixels of a row whose light is interpolated, between the first and the next block's first, where the
surface is plain."""
_PLAIN = np.float32(0.1)
"""Largest bend of a row on a plain surface from pixel to pixel, in texels of the ground map: in a block up to 0.8."""
CHANNELS = 6
"""Numbers of both vectors, of street lamps and of headlights."""

HALF, ONE, ZERO = np.float32(0.5), np.float32(1.0), np.float32(0.0)


class LampScratch(NamedTuple):
    """Scratch of ``lamp_row``, for rows of W pixels.

    Attributes:
        vectors: (6, W) of street lamps and of headlights. ends: (2, 6) those at both ends of a block.
        bends: (>= W,) uint8, see ``_find_bends``. words: the same memory, a block each.
    """

    vectors: NDArray[np.float32]
    ends: NDArray[np.float32]
    bends: NDArray[np.uint8]
    words: NDArray[np.uint64]


def new_lamp_scratch(width: int) -> LampScratch:
    """Return scratch for rows of ``width`` pixels."""
    bends = np.zeros(-(-width // BLOCK) * BLOCK, np.uint8)
    return LampScratch(
        np.zeros((CHANNELS, width), np.float32), np.zeros((2, CHANNELS), np.float32), bends, bends.view(np.uint64)
    )


class LampArrays(NamedTuple):
    """The map for kernels.

    Attributes:
        light_lx: (n * n, 6) float32, see above. size: n, 0 where no lamp burns.
        share: of the ground map's columns in one of this.
        lamp_rgb, head_rgb: (3,) float32, colours of luminance 1. height_m: of the street lamps, which light nothing
            above them.
    """

    light_lx: NDArray[np.float32]
    size: int
    share: np.float32
    lamp_rgb: NDArray[np.float32]
    head_rgb: NDArray[np.float32]
    height_m: np.float32


def profile(cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a street lamp's intensity at angles of these cosines from straight down, 1 straight down."""
    c = np.maximum(cosine, 1e-3)
    gamma_deg = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    ending = np.clip((_UP_TO_DEG - gamma_deg) / (_UP_TO_DEG - _FROM_DEG), 0.0, 1.0)
    return np.minimum(c**-3, EVEN_UP_TO) * ending**2 * (3.0 - 2.0 * ending)


def intensity_down_cd(flux_lm: float) -> float:
    """Return I0 of a street lamp of this flux: its profile over all directions adds up to it."""
    gamma = np.linspace(0.0, 0.5 * np.pi, 2000)
    return flux_lm / float(2.0 * np.pi * np.trapezoid(profile(np.cos(gamma)) * np.sin(gamma), gamma))


_TABLE = profile(np.linspace(0.0, 1.0, 1025))
"""By the cosine."""


def bake_lamps(lamps_m: NDArray[np.float64], flux_lm: NDArray[np.float64], heights: HeightMap) -> NDArray[np.float32]:
    """Return the map (n, n, 6) of street lamps at places (K, 3), that of headlights 0."""
    light_lx = np.zeros((*heights.solid_m.shape, CHANNELS), np.float32)
    down_cd = np.array([intensity_down_cd(float(flux)) for flux in flux_lm])
    _bake(lamps_m.astype(float), down_cd, heights.solid_m, heights.crown_m, heights.side_m, _TABLE, light_lx)
    return light_lx


@njit(cache=True)
def _bake(
    lamps_m: NDArray[np.float64],
    down_cd: NDArray[np.float64],
    solid_m: NDArray[np.float32],
    crown_m: NDArray[np.float32],
    side_m: float,
    table: NDArray[np.float64],
    light_lx: NDArray[np.float32],
) -> None:
    """Add each lamp's vector to the cells that see it, weakened by crowns on the way."""
    size, half_m = solid_m.shape[0], 0.5 * side_m
    for n in range(lamps_m.shape[0]):
        x, y, z = lamps_m[n]
        reach = _REACH * z
        top, bottom = max(int((half_m - y - reach) / COARSE_M), 1), min(int((half_m - y + reach) / COARSE_M), size - 1)
        first, last = max(int((x + half_m - reach) / COARSE_M), 1), min(int((x + half_m + reach) / COARSE_M), size - 1)
        for row in range(top, bottom):
            dy = y - (half_m - (row + 0.5) * COARSE_M)
            for column in range(first, last):
                dx = x - ((column + 0.5) * COARSE_M - half_m)
                squared = dx * dx + dy * dy + z * z
                distance = np.sqrt(squared)
                intensity = down_cd[n] * table[int(z / distance * 1024.0 + 0.5)]
                if intensity < 1e-3 * down_cd[n]:
                    continue
                left, steps = 1.0, int(np.hypot(dx, dy) / COARSE_M)
                for step in range(1, steps):
                    along = step / steps
                    i = int((half_m - y + (1.0 - along) * dy) / COARSE_M)
                    j = int((x - (1.0 - along) * dx + half_m) / COARSE_M)
                    if not (0 <= i < size and 0 <= j < size):
                        continue
                    height = z * along
                    if height < solid_m[i, j]:
                        left = 0.0
                        break
                    if _CROWN_FROM * crown_m[i, j] < height < crown_m[i, j]:
                        left *= CROWN_LEFT
                strength = left * intensity / (squared * distance)
                light_lx[row, column, 0] += strength * dx
                light_lx[row, column, 1] += strength * dy
                light_lx[row, column, 2] += strength * z


class LampView:
    """The map of one episode, on which cars shine ahead."""

    def __init__(
        self,
        baked_lx: NDArray[np.float32],
        cars: list[Footprint],
        *,
        lamp_rgb: NDArray[np.float64],
        head_rgb: NDArray[np.float64],
        height_m: float,
    ) -> None:
        """``baked_lx``: see ``bake_lamps``; ``cars``: those with their lights on, which look along +x."""
        self._light_lx = baked_lx.copy()
        self._bodies = np.array([each.body for each in cars], dtype=np.int64)
        self._ahead_m = np.array([0.5 * each.length_m for each in cars])
        self._changed = np.zeros((len(cars), 4), np.int64)
        self._rgb = lamp_rgb.astype(np.float32), head_rgb.astype(np.float32), np.float32(height_m)

    def arrays(
        self, poses: NDArray[np.float64], ground: GroundArrays, camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> LampArrays:
        """Return the map with the beams of the cars at their poses (B, 4, 4), as far as the picture may show them."""
        size, now = len(self._light_lx), poses[self._bodies]
        middles_m = now[:, :3, 3] + 0.5 * BEAM_REACH_M * now[:, :3, 0]
        now[~may_show(camera, T_world_camera, middles_m, 0.6 * BEAM_REACH_M), 0, 3] = AWAY_M
        _shine(now, self._ahead_m, 0.5 * size * COARSE_M, self._changed, self._light_lx)
        flat = self._light_lx.reshape(-1, CHANNELS)
        return LampArrays(flat, size, np.float32(size / ground.size), *self._rgb)


NO_LAMPS = LampArrays(
    np.zeros((1, CHANNELS), np.float32), 0, ONE, np.zeros(3, np.float32), np.zeros(3, np.float32), np.float32(1.0)
)


@njit(cache=True)
def beam_cd(aside: float, down: float) -> float:
    """Return the intensity of a car's dipped beams in a direction: tangents of its angles to the side and down."""
    if down < 0.0 or abs(aside) > _WIDEST:
        return 0.0
    a, v = _PER_ASIDE * aside / (1.0 + 0.28 * aside * aside), _PER_DOWN * down
    return BEAM_CD * np.exp(-0.5 * a * a - v)


@njit(cache=True)
def _shine(
    poses: NDArray[np.float64],
    ahead_m: NDArray[np.float64],
    half_m: float,
    changed: NDArray[np.int64],
    light_lx: NDArray[np.float32],
) -> None:
    """Write the vectors of headlights (K cars) into channels 3 to 5; what they wrote before is taken out."""
    size, z = light_lx.shape[0], BEAM_HEIGHT_M
    for n in range(changed.shape[0]):
        light_lx[changed[n, 0] : changed[n, 1], changed[n, 2] : changed[n, 3], 3:] = 0.0
    for n in range(poses.shape[0]):
        c, s = poses[n, 0, 0], poses[n, 1, 0]
        x, y = poses[n, 0, 3] + c * ahead_m[n], poses[n, 1, 3] + s * ahead_m[n]
        # The beam's corners bound what it lights.
        wide = 0.45 * BEAM_REACH_M
        low_x, high_x = x - 1.0, x + 1.0
        low_y, high_y = y - 1.0, y + 1.0
        for side in (-wide, wide):
            low_x, high_x = min(low_x, x + c * BEAM_REACH_M - s * side), max(high_x, x + c * BEAM_REACH_M - s * side)
            low_y, high_y = min(low_y, y + s * BEAM_REACH_M + c * side), max(high_y, y + s * BEAM_REACH_M + c * side)
        top, bottom = max(int((half_m - high_y) / COARSE_M), 1), min(int((half_m - low_y) / COARSE_M) + 1, size - 1)
        first, last = max(int((low_x + half_m) / COARSE_M), 1), min(int((high_x + half_m) / COARSE_M) + 1, size - 1)
        changed[n, 0], changed[n, 1], changed[n, 2], changed[n, 3] = top, max(bottom, top), first, max(last, first)
        for row in range(top, bottom):
            dy = half_m - (row + 0.5) * COARSE_M - y
            for column in range(first, last):
                dx = (column + 0.5) * COARSE_M - half_m - x
                along, across = c * dx + s * dy, c * dy - s * dx
                if along <= 0.1 or along > BEAM_REACH_M or abs(across) > _WIDEST * along:
                    continue
                level_squared, reached = along * along + across * across, (along / BEAM_REACH_M) ** 2
                squared = level_squared + z * z
                intensity = beam_cd(across / along, z / np.sqrt(level_squared)) * (1.0 - reached * reached)
                strength = intensity / (squared * np.sqrt(squared))
                light_lx[row, column, 3] -= strength * dx
                light_lx[row, column, 4] -= strength * dy
                light_lx[row, column, 5] += strength * z


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def lamp_row(
    lamps: LampArrays,
    column: NDArray[np.float32],
    row: NDArray[np.float32],
    height_m: NDArray[np.float32],
    normal: NDArray[np.float32],
    scratch: LampScratch,
    lamp_lx: NDArray[np.float32],
    head_lx: NDArray[np.float32],
) -> None:
    """Write the illuminances (W,) of surfaces by street lamps and by headlights.

    Args:
        column, row: in the ground map.
        height_m: above the ground, (W,). Light from above ends at the lamps, and that of beams above the cars.
    """
    vectors, ends, block, one = scratch.vectors, scratch.ends, np.uint64(BLOCK), np.uint64(1)
    width = np.uint64(lamp_lx.shape[0])
    read_at = width
    _find_bends(column, row, scratch.bends)
    for number in range(scratch.words.shape[0]):
        first = np.uint64(number) * block
        if scratch.words[number] == 0:
            here, there = ends[np.uint64(number) & one], ends[one - (np.uint64(number) & one)]
            if read_at != first:
                _read(lamps, column[first], row[first], here)
            read_at = first + block
            _read(lamps, column[read_at], row[read_at], there)
            _draw_line(here, there, first, vectors)
        else:
            for k in range(first, min(first + block, width)):
                _read(lamps, column[k], row[k], ends[0])
                for channel in range(CHANNELS):
                    vectors[channel, k] = ends[0, channel]
            read_at = width
    _receive(vectors[0], vectors[1], vectors[2], normal, lamp_lx)
    _receive(vectors[3], vectors[4], vectors[5], normal, head_lx)
    per_height, beams_end = ONE / (HALF * lamps.height_m), np.float32(1.0 / 1.5)
    _end_above(height_m, lamps.height_m * per_height, per_height, lamp_lx)
    _end_above(height_m, np.float32(2.0), beams_end, head_lx)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _find_bends(column: NDArray[np.float32], row: NDArray[np.float32], bends: NDArray[np.uint8]) -> None:
    """Mark pixels after which a row leaves its straight line on the map, and the last two."""
    last, one, two = np.uint64(max(column.shape[0], 2) - 2), np.uint64(1), np.float32(2.0)
    for k in range(last):
        by_column = abs(column[k] - two * column[k + one] + column[k + one + one])
        by_row = abs(row[k] - two * row[k + one] + row[k + one + one])
        bends[k] = max(by_column, by_row) > _PLAIN
    bends[last] = bends[last + one] = 1


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _draw_line(
    here: NDArray[np.float32], there: NDArray[np.float32], first: np.uint64, vectors: NDArray[np.float32]
) -> None:
    """Write the vectors of a block from those at its first pixel and at the one after its last."""
    per = ONE / np.float32(BLOCK)
    for channel in range(CHANNELS):
        start, step = here[channel], per * (there[channel] - here[channel])
        for j in range(BLOCK):
            vectors[channel, first + np.uint64(j)] = start + np.float32(np.int32(j)) * step


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _receive(
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    z: NDArray[np.float32],
    normal: NDArray[np.float32],
    light_lx: NDArray[np.float32],
) -> None:
    """Write the part (W,) of vectors along normals."""
    nx, ny, nz = normal[0], normal[1], normal[2]
    for k in range(light_lx.shape[0]):
        light_lx[k] = max(nx[k] * x[k] + ny[k] * y[k] + nz[k] * z[k], ZERO)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _end_above(
    height_m: NDArray[np.float32], most: np.float32, per_m: np.float32, light_lx: NDArray[np.float32]
) -> None:
    """Weaken light towards the height at which it ends."""
    for k in range(light_lx.shape[0]):
        light_lx[k] *= min(max(most - height_m[k] * per_m, ZERO), ONE)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _read(lamps: LampArrays, column: np.float32, row: np.float32, vectors: NDArray[np.float32]) -> None:
    """Write both vectors (6,) at a place of the ground map, between the four cells around it."""
    light, size = lamps.light_lx, np.int64(lamps.size)
    most, one = np.float32(lamps.size) - np.float32(1.01), np.uint64(1)
    s, t = min(max(column * lamps.share - HALF, ZERO), most), min(max(row * lamps.share - HALF, ZERO), most)
    j, i = np.int32(s), np.int32(t)
    a = np.uint64(np.int64(i) * size + np.int64(j))
    c = a + np.uint64(size)
    b, d = a + one, c + one
    fs, ft = s - np.float32(j), t - np.float32(i)
    w00, w01, w10, w11 = (ONE - fs) * (ONE - ft), fs * (ONE - ft), (ONE - fs) * ft, fs * ft
    for channel in range(CHANNELS):
        above = w00 * light[a, channel] + w01 * light[b, channel]
        vectors[channel] = above + w10 * light[c, channel] + w11 * light[d, channel]
