"""Maps of a town's level ground, for light that no shadow map brings: how much sky a place sees, and what covers it.

The share of a uniform sky's light that arrives on level ground, with the horizon at angle gamma in N directions, is

    share = mean of cos² gamma

(Johnson and Watson 1984; Zaksek et al. 2011). Beside a body that moves, a wall of height h that ends after its length
and is d away, it is less by about ``(1 - d / sqrt(d² + h²)) / 2``.

A map's columns run along +x, its rows along -y, as in a picture of the ground. Texel (i, j) covers the square from
``(j, i) cell`` to ``(j + 1, i + 1) cell`` from the upper left corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import Camera, Intrinsics, look_down_pose, may_show, ray_of_pixel
from sim.render.compilation import row_kernel
from sim.render.raster import Raster
from sim.world import World

COARSE_M = 0.8
"""Cells of the map of heights, from which shares and lamps are derived."""
FINER = 4
"""Cells of the fine map along a side of a coarse one."""
CELL_M = COARSE_M / FINER
_FROM_ABOVE_M = 20_000.0
"""Height of the camera that sees heights: high enough that walls are hidden."""
_DIRECTIONS, _REACH_M = 16, 40.0
_COVERED_M, _BESIDE_WALLS = 1.5, 0.5
"""Ground below higher things counts as beside a wall, so that no darker rim shows around these."""
_CROWN_SHARE = 0.6
"""Of the height of trees, which let light through."""
_STAMP_BEYOND_M, _SEEN_WITHIN_M = 3.0, 12.0
"""Bodies darken the ground so far around them; those farther out of the picture do not."""
AWAY_M = 1e6
"""Place of what is left out of a picture."""

HALF, ONE, ZERO = np.float32(0.5), np.float32(1.0), np.float32(0.0)
_LOW, _PER_BYTE = np.uint16(255), np.float32(1.0 / 255.0)


class GroundArrays(NamedTuple):
    """A map of the ground as seen from a camera's pixels.

    Attributes:
        packed: (N * N,) uint16, ``share | cover << 8``, both of 255.
        size: N.
        from_pixel: (3, 4) float32, see ``ShadowArrays``: column, row, height above the ground in metres.
    """

    packed: NDArray[np.uint16]
    size: int
    from_pixel: NDArray[np.float32]


class GroundScratch(NamedTuple):
    """Scratch of ``ground_row``, for rows of W pixels.

    Attributes:
        at: (W,) uint32 number of the upper left texel. fraction_x, fraction_y: (W,) float32, place beyond its middle.
        above, below: (W,) uint32, two texels in each.
    """

    at: NDArray[np.uint32]
    fraction_x: NDArray[np.float32]
    fraction_y: NDArray[np.float32]
    above: NDArray[np.uint32]
    below: NDArray[np.uint32]


def new_ground_scratch(width: int) -> GroundScratch:
    """Return scratch for rows of ``width`` pixels."""
    whole, real = np.zeros((3, width), np.uint32), np.zeros((2, width), np.float32)
    return GroundScratch(whole[0], real[0], real[1], whole[1], whole[2])


class HeightMap(NamedTuple):
    """What stands on the ground, seen from straight above, in cells of ``COARSE_M``.

    Attributes:
        solid_m, crown_m: (n, n) float32, heights of houses and other solid things, and of trees; 0 without one.
    """

    solid_m: NDArray[np.float32]
    crown_m: NDArray[np.float32]

    @property
    def side_m(self) -> float:
        """Side of the square that it covers, at least that of the ground."""
        return COARSE_M * len(self.solid_m)


def heights_from_above(world: World, extent_m: float) -> HeightMap:
    """Return the heights on a square of at least ``extent_m`` around the origin; movable bodies and vehicles are left
    out.
    """
    cells = int(np.ceil(extent_m / COARSE_M))
    camera = Intrinsics(cells, cells, _FROM_ABOVE_M / COARSE_M)
    pose = look_down_pose(np.array([0.0, 0.0, _FROM_ABOVE_M]), 0.5 * np.pi, 0.0, 0.0)
    seen = Raster(world).gbuffer(camera, pose)
    height_m = np.maximum(_FROM_ABOVE_M - seen.depth_m, 0.0).astype(np.float32)
    kinds = np.array([_kind_of(body.category, body.movable) for body in world.bodies] + [0])[seen.instance_id]
    return HeightMap(np.where(kinds == 1, height_m, 0).astype(np.float32), np.where(kinds == 2, height_m, 0))


def _kind_of(category: str, movable: bool) -> int:
    """Return 1 for what is solid, 2 for crowns, 0 for what casts no lasting shadow."""
    if movable or category in ("ground", "kerb", "vehicle", "lamp"):
        return 0
    return 2 if category in ("tree", "wood") else 1


def sky_shares(heights: HeightMap) -> NDArray[np.float32]:
    """Return the share (n, n) of the sky's light that arrives on the ground."""
    height_m = np.maximum(heights.solid_m, _CROWN_SHARE * heights.crown_m)
    share = np.empty_like(height_m)
    _scan(height_m, share)
    share[height_m > _COVERED_M] = np.maximum(share, _BESIDE_WALLS)[height_m > _COVERED_M]
    return share


@njit(cache=True)
def _scan(height_m: NDArray[np.float32], share: NDArray[np.float32]) -> None:
    """Write the mean of cos² of the horizon's angle; steps grow with the distance."""
    size, steps = height_m.shape[0], 0
    dx, dy, away = np.empty((_DIRECTIONS, 64)), np.empty((_DIRECTIONS, 64)), np.empty(64)
    distance = COARSE_M
    while distance < _REACH_M:
        away[steps] = distance
        for direction in range(_DIRECTIONS):
            angle = 2.0 * np.pi * (direction + 0.5 * (steps % 2)) / _DIRECTIONS
            dx[direction, steps], dy[direction, steps] = np.cos(angle) * distance, np.sin(angle) * distance
        steps += 1
        distance *= 1.22
    for i in range(size):
        for j in range(size):
            total = 0.0
            for direction in range(_DIRECTIONS):
                steepest = 0.0
                for step in range(steps):
                    row = int(i + dy[direction, step] / COARSE_M + 0.5)
                    column = int(j + dx[direction, step] / COARSE_M + 0.5)
                    if 0 <= row < size and 0 <= column < size:
                        steepest = max(steepest, height_m[row, column] / away[step])
                total += 1.0 / (1.0 + steepest * steepest)
            share[i, j] = total / _DIRECTIONS


class Footprint(NamedTuple):
    """A body that stands on the ground, as a box: its pose's origin in the middle of its lower side.

    Attributes:
        body: its index in the world. length_m, width_m, height_m: its size.
    """

    body: int
    length_m: float
    width_m: float
    height_m: float


@dataclass(frozen=True, eq=False)
class GroundMap:
    """The fine map of a world's ground, on which bodies that move darken what is beside them.

    Attributes:
        fixed: (N, N) uint16, of what never moves, see ``GroundArrays``.
    """

    fixed: NDArray[np.uint16]

    @property
    def size(self) -> int:
        """Texels along a side."""
        return len(self.fixed)

    @property
    def half_m(self) -> float:
        """Half the side of the square."""
        return 0.5 * self.size * CELL_M

    def view(self, footprints: list[Footprint]) -> GroundView:
        """Return the map for one episode, with these bodies."""
        return GroundView(self, footprints)


def ground_map(share: NDArray[np.float32], cover: NDArray[np.uint8], parked: NDArray[np.float64]) -> GroundMap:
    """Return the map of what never moves.

    Args:
        share: (n, n), see ``sky_shares``. cover: (N, N) of 255, N = ``FINER`` n; its outermost texels also hold for all
            that lies beyond.
        parked: (P, 7) boxes that stay: x, y, cosine and sine of the yaw, length, width, height.
    """
    size = FINER * len(share)
    fine = cv2.resize(share, (size, size), interpolation=cv2.INTER_LINEAR)
    fine[[0, -1]], fine[:, [0, -1]] = 1.0, 1.0
    packed = np.rint(255.0 * fine).astype(np.uint16) | (cover.astype(np.uint16) << 8)
    _stamp(parked, 0.5 * size * CELL_M, CELL_M, np.zeros((len(parked), 4), np.int64), packed, packed)
    return GroundMap(packed)


class GroundView:
    """A ground map with the bodies of one episode."""

    def __init__(self, ground: GroundMap, footprints: list[Footprint]) -> None:
        self._ground, self._packed = ground, ground.fixed.copy()
        self._bodies = np.array([each.body for each in footprints], dtype=np.int64)
        self._sizes_m = np.array([each[1:] for each in footprints], dtype=float).reshape(-1, 3)
        self._changed = np.zeros((len(footprints), 4), np.int64)

    def arrays(self, poses: NDArray[np.float64], camera: Camera, T_world_camera: NDArray[np.float64]) -> GroundArrays:
        """Return the map with the bodies at their poses (B, 4, 4), seen from a camera."""
        now = poses[self._bodies]
        now[~may_show(camera, T_world_camera, now[:, :3, 3], _SEEN_WITHIN_M), 0, 3] = AWAY_M
        boxes = np.column_stack([now[:, 0, 3], now[:, 1, 3], now[:, 0, 0], now[:, 1, 0], self._sizes_m])
        ground = self._ground
        _stamp(boxes, ground.half_m, CELL_M, self._changed, ground.fixed, self._packed)
        to_map = np.array(
            [
                [1.0 / CELL_M, 0.0, 0.0, ground.half_m / CELL_M],
                [0.0, -1.0 / CELL_M, 0.0, ground.half_m / CELL_M],
                [0.0, 0.0, 1.0, 0.0],
            ]
        )
        from_pixel = np.empty((3, 4))
        from_pixel[:, :3] = to_map[:, :3] @ T_world_camera[:3, :3] @ ray_of_pixel(camera)
        from_pixel[:, 3] = to_map[:, :3] @ T_world_camera[:3, 3] + to_map[:, 3]
        return GroundArrays(self._packed.ravel(), ground.size, from_pixel.astype(np.float32))


@njit(cache=True)
def _stamp(
    boxes: NDArray[np.float64],
    half_m: float,
    cell_m: float,
    changed: NDArray[np.int64],
    fixed: NDArray[np.uint16],
    packed: NDArray[np.uint16],
) -> None:
    """Take the light beside boxes (B, 7) from the map; before, put back what each took the last time.

    Args:
        boxes: as ``parked`` of ``ground_map``. changed: (B, 4) rows and columns, first and after the last, written.
    """
    size = packed.shape[0]
    for n in range(changed.shape[0]):
        for row in range(changed[n, 0], changed[n, 1]):
            for column in range(changed[n, 2], changed[n, 3]):
                packed[row, column] = fixed[row, column]
    for n in range(boxes.shape[0]):
        x, y, c, s, length, width, height = boxes[n]
        reach = np.hypot(0.5 * length, 0.5 * width) + _STAMP_BEYOND_M
        top, bottom = max(int((half_m - y - reach) / cell_m), 1), min(int((half_m - y + reach) / cell_m) + 1, size - 1)
        first, last = max(int((x + half_m - reach) / cell_m), 1), min(int((x + half_m + reach) / cell_m) + 1, size - 1)
        changed[n, 0], changed[n, 1], changed[n, 2], changed[n, 3] = top, max(bottom, top), first, max(last, first)
        for row in range(top, bottom):
            dy = half_m - (row + 0.5) * cell_m - y
            for column in range(first, last):
                dx = (column + 0.5) * cell_m - half_m - x
                along, across = abs(c * dx + s * dy) - 0.5 * length, abs(c * dy - s * dx) - 0.5 * width
                ahead, aside = max(along, 0.0), max(across, 0.0)
                outside_squared = ahead * ahead + aside * aside
                if outside_squared > _STAMP_BEYOND_M * _STAMP_BEYOND_M:
                    continue
                outside = np.sqrt(outside_squared)
                away = outside + 0.15 if outside > 0.0 else 0.15 + max(along, across) * 0.5
                fading = 1.0 - (outside / _STAMP_BEYOND_M) ** 2
                taken = 0.5 * (1.0 - away / np.sqrt(away * away + height * height)) * fading
                if outside == 0.0:
                    taken = min(taken + 0.6 * min(-max(along, across), 0.5), 0.85)
                held = np.int64(packed[row, column])
                packed[row, column] = np.uint16((held & 0xFF00) | int((held & 0xFF) * (1.0 - taken)))


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def place_row(
    from_pixel: NDArray[np.float32],
    row: int,
    depth_m: NDArray[np.float32],
    low: np.float32,
    high: np.float32,
    coordinate: NDArray[np.float32],
) -> None:
    """Write ``depth * from_pixel[:3] @ (x, y, 1) + from_pixel[3]`` at the centres of a row, clipped to [low, high]."""
    base = from_pixel[1] * (np.float32(row) + HALF) + from_pixel[2] + HALF * from_pixel[0]
    step, at = from_pixel[0], from_pixel[3]
    for k in range(depth_m.shape[0]):
        z = min(depth_m[k], np.float32(1e6))
        coordinate[k] = min(max((base + step * np.float32(np.int32(k))) * z + at, low), high)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def ground_row(
    ground: GroundArrays,
    column: NDArray[np.float32],
    row: NDArray[np.float32],
    scratch: GroundScratch,
    share: NDArray[np.float32],
    cover: NDArray[np.float32],
) -> None:
    """Write share and cover, 0 to 1, between the four texels around places (W,) of the map."""
    _find_texels(ground.size, column, row, scratch)
    _fetch(ground.packed, np.uint64(ground.size), scratch)
    _mix(scratch, share, cover)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _find_texels(size: int, column: NDArray[np.float32], row: NDArray[np.float32], scratch: GroundScratch) -> None:
    """Write the number of the upper left texel around each place, and the fractions beyond it."""
    most, pitch = np.float32(size) - np.float32(1.01), np.int32(size)
    at, fs, ft = scratch.at, scratch.fraction_x, scratch.fraction_y
    for k in range(column.shape[0]):
        s, t = min(max(column[k] - HALF, ZERO), most), min(max(row[k] - HALF, ZERO), most)
        j, i = np.int32(s), np.int32(t)
        at[k] = np.uint32(np.int32(i * pitch) + j)
        fs[k], ft[k] = s - np.float32(j), t - np.float32(i)


@row_kernel()
def _fetch(packed: NDArray[np.uint16], size: np.uint64, scratch: GroundScratch) -> None:
    """Write the four texels of each place, two in a number."""
    one, sixteen = np.uint64(1), np.uint32(16)
    for k in range(scratch.at.shape[0]):
        above = np.uint64(scratch.at[k])
        below = above + size
        scratch.above[k] = np.uint32(packed[above]) | np.uint32(np.uint32(packed[above + one]) << sixteen)
        scratch.below[k] = np.uint32(packed[below]) | np.uint32(np.uint32(packed[below + one]) << sixteen)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def _mix(scratch: GroundScratch, share: NDArray[np.float32], cover: NDArray[np.float32]) -> None:
    """Write the means of the four texels."""
    byte, eight, sixteen, last = np.uint32(255), np.uint32(8), np.uint32(16), np.uint32(24)
    for k in range(share.shape[0]):
        a, c = scratch.above[k], scratch.below[k]
        fs, ft = scratch.fraction_x[k], scratch.fraction_y[k]
        w00, w01 = (ONE - fs) * (ONE - ft) * _PER_BYTE, fs * (ONE - ft) * _PER_BYTE
        w10, w11 = (ONE - fs) * ft * _PER_BYTE, fs * ft * _PER_BYTE
        share[k] = (
            w00 * np.float32(np.int32(a & byte))
            + w01 * np.float32(np.int32(np.uint32(a >> sixteen) & byte))
            + w10 * np.float32(np.int32(c & byte))
            + w11 * np.float32(np.int32(np.uint32(c >> sixteen) & byte))
        )
        cover[k] = (
            w00 * np.float32(np.int32(np.uint32(a >> eight) & byte))
            + w01 * np.float32(np.int32(np.uint32(a >> last)))
            + w10 * np.float32(np.int32(np.uint32(c >> eight) & byte))
            + w11 * np.float32(np.int32(np.uint32(c >> last)))
        )
