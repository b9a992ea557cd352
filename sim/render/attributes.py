"""What is seen in each pixel, given its nearest triangle: the second half of the rasteriser."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.sampling import LEVEL_0_UP_TO, mip_level, sample_row
from sim.render.textures import TexturePool
from sim.render.visibility import (
    BEGIN,
    BODY,
    IS_FLAT,
    IS_SMOOTH,
    LAST_TEXEL,
    NOTHING,
    NX,
    NY,
    NZ,
    ROW_PITCH,
    TEXEL_DENSITY,
    TEXTURE,
    TriangleTable,
    U,
    V,
)

LEVEL_BLOCK = 128
"""The mip level is chosen once for so many neighbouring pixels of a row and triangle."""
SHORT = 64
"""Runs below this number of pixels are over before vector code has started."""


class RowRoom(NamedTuple):
    """What ``resolve_row`` works in, for rows of W pixels; see ``sample_row``.

    Attributes:
        position: (2, W) float32. level: (2, W) int32. texel: (6, W) uint32.
    """

    position: NDArray[np.float32]
    level: NDArray[np.int32]
    texel: NDArray[np.uint32]


@njit(cache=True)
def new_row_room(width: int) -> RowRoom:
    """Return room for rows of ``width`` pixels."""
    return RowRoom(np.empty((2, width), np.float32), np.empty((2, width), np.int32), np.empty((6, width), np.uint32))


@njit(cache=True)
def resolve_picture(
    textures: TexturePool,
    table: TriangleTable,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
    base_colour_rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    normal_world: NDArray[np.float32],
) -> None:
    """Write a ``GBuffer`` from what ``draw_picture`` found; arrays are (H, W) or (H, W, 3)."""
    width = triangle.shape[1]
    room = new_row_room(width)
    colour = np.empty(width, np.uint32)
    normal = np.empty((3, width), np.float32)
    for row in range(triangle.shape[0]):
        depth, identity = depth_m[row], instance_id[row]
        resolve_row(textures, table, row, nearness[row], triangle[row], room, colour, depth, identity, normal)
        for column in range(width):
            texel = colour[column]
            base_colour_rgb[row, column, 0] = texel & np.uint32(255)
            base_colour_rgb[row, column, 1] = (texel >> np.uint32(8)) & np.uint32(255)
            base_colour_rgb[row, column, 2] = (texel >> np.uint32(16)) & np.uint32(255)
            for k in range(3):
                normal_world[row, column, k] = normal[k, column]


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def resolve_row(
    textures: TexturePool,
    table: TriangleTable,
    row: int,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
    room: RowRoom,
    colour: NDArray[np.uint32],
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    normal: NDArray[np.float32],
) -> None:
    """Write what one row of pixels shows.

    With the planes of ``TriangleTable``: ``depth = 1 / nearness``, ``(u, v) = plane * depth`` and, on faces that
    are not flat, ``n = plane / |plane|``.

    Args:
        colour: (W,), written: packed like texels, 0 where there is nothing; so are the others.
        normal: (3, W).
    """
    whole, real = table.whole, table.real
    position_x, position_y, level_begin, level_pitch = room.position[0], room.position[1], room.level[0], room.level[1]
    normal_x, normal_y, normal_z = normal[0], normal[1], normal[2]
    y, zero, one = np.float32(row), np.float32(0.0), np.float32(1.0)
    offset, row_pitch, level_count = textures.offset, textures.row_pitch, textures.level_count
    widths, heights = textures.width, textures.height
    width = np.uint64(triangle.shape[0])
    for column in range(triangle.shape[0]):
        depth_m[column] = np.float32(1.0) / nearness[column]
    first = np.uint64(0)
    # Unsigned numbers of columns: signed ones would be checked for counting from the end.
    while first < width:
        index = np.uint32(triangle[first])
        last = first + np.uint64(1)
        while last < width and np.uint32(triangle[last]) == index:
            last += np.uint64(1)
        if last - first >= np.uint64(SHORT) or index == NOTHING:
            _describe_run(whole, real, index, row, first, last, instance_id, normal_x, normal_y, normal_z)
            _place_run(textures, whole, real, index, row, first, last, depth_m, room.position, room.level)
            first = last
            continue
        body, smooth, flat = whole[index, BODY], whole[index, IS_SMOOTH], whole[index, IS_FLAT]
        begin, pitch = whole[index, BEGIN], whole[index, ROW_PITCH]
        x_last, y_last = real[index, LAST_TEXEL], real[index, LAST_TEXEL + 1]
        u_step, u_base = real[index, U], real[index, U + 1] * y + real[index, U + 2]
        v_step, v_base = real[index, V], real[index, V + 1] * y + real[index, V + 2]
        x_step, x_base = real[index, NX], real[index, NX + 1] * y + real[index, NX + 2]
        y_step, y_base = real[index, NY], real[index, NY + 1] * y + real[index, NY + 2]
        z_step, z_base = real[index, NZ], real[index, NZ + 1] * y + real[index, NZ + 2]
        z, density = depth_m[first], real[index, TEXEL_DENSITY]
        if density * z * z * z > np.float32(LEVEL_0_UP_TO):
            t, z = whole[index, TEXTURE], depth_m[first + ((last - first) >> np.uint64(1))]
            k = mip_level(density * z * z * z, level_count[t])
            if k > 0:
                begin, pitch = np.int32(offset[t, k]), row_pitch[t, k]
                wide, high = np.float32(widths[t, k]), np.float32(heights[t, k])
                u_scale, v_scale = wide / (x_last + one), high / (y_last + one)
                u_step, u_base, v_step, v_base = u_step * u_scale, u_base * u_scale, v_step * v_scale, v_base * v_scale
                x_last, y_last = wide - one, high - one
        half = np.float32(0.5 if smooth else 0.0)
        # Short runs, a pixel at a time: over before vector code has started.
        while first < width and np.uint32(triangle[first]) == index:
            z, x = depth_m[first], np.float32(np.int32(first))
            a = min(max((u_base + u_step * x) * z - half, zero), x_last)
            b = min(max((v_base + v_step * x) * z - half, zero), y_last)
            position_x[first] = a if smooth else np.floor(a)
            position_y[first] = b if smooth else np.floor(b)
            level_begin[first], level_pitch[first], instance_id[first] = begin, pitch, body
            nx, ny, nz = x_step * x + x_base, y_step * x + y_base, z_step * x + z_base
            scale = one if flat else one / np.sqrt(nx * nx + ny * ny + nz * nz)
            normal_x[first], normal_y[first], normal_z[first] = nx * scale, ny * scale, nz * scale
            first += np.uint64(1)
    sample_row(textures.texels, room.position, room.level, room.texel, colour)
    for column in range(triangle.shape[0]):
        colour[column] = np.uint32(0) if triangle[column] == NOTHING else colour[column]


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _describe_run(
    whole: NDArray[np.int32],
    real: NDArray[np.float32],
    index: np.uint32,
    row: int,
    first: np.uint64,
    last: np.uint64,
    instance_id: NDArray[np.int32],
    normal_x: NDArray[np.float32],
    normal_y: NDArray[np.float32],
    normal_z: NDArray[np.float32],
) -> None:
    """Write body and normal of the pixels first … last - 1 of a triangle."""
    body = whole[index, BODY]
    for column in range(first, last):
        instance_id[column] = body
    if whole[index, IS_FLAT]:
        nx, ny, nz = real[index, NX + 2], real[index, NY + 2], real[index, NZ + 2]
        for column in range(first, last):
            normal_x[column], normal_y[column], normal_z[column] = nx, ny, nz
        return
    y = np.float32(row)
    x_step, x_base = real[index, NX], real[index, NX + 1] * y + real[index, NX + 2]
    y_step, y_base = real[index, NY], real[index, NY + 1] * y + real[index, NY + 2]
    z_step, z_base = real[index, NZ], real[index, NZ + 1] * y + real[index, NZ + 2]
    for column in range(first, last):
        x = np.float32(np.int32(column))
        nx, ny, nz = x_step * x + x_base, y_step * x + y_base, z_step * x + z_base
        scale = np.float32(1.0) / np.sqrt(nx * nx + ny * ny + nz * nz)
        normal_x[column], normal_y[column], normal_z[column] = nx * scale, ny * scale, nz * scale


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _place_run(
    textures: TexturePool,
    whole: NDArray[np.int32],
    real: NDArray[np.float32],
    index: np.uint32,
    row: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    position: NDArray[np.float32],
    level: NDArray[np.int32],
) -> None:
    """Write where in which mip level the pixels first … last - 1 of a triangle lie, as ``sample_row`` wants it.

    Texel (i, j) has its centre at ``(u width, v height) = (j + 1/2, i + 1/2)``; beyond the outermost centres the
    edge goes on. Palettes are not interpolated: each position is that of the nearest texel's centre.
    """
    if index == NOTHING:
        for column in range(first, last):
            position[0, column] = position[1, column] = np.float32(0.0)
            level[0, column] = level[1, column] = np.int32(0)
        return
    t, y, one = whole[index, TEXTURE], np.float32(row), np.float32(1.0)
    smooth, count = whole[index, IS_SMOOTH], textures.level_count[t]
    start = first
    while start < last:
        end = min(start + np.uint64(LEVEL_BLOCK), last)
        z = depth_m[start + ((end - start) >> np.uint64(1))]
        k = mip_level(real[index, TEXEL_DENSITY] * z * z * z, count)
        width, height = np.float32(textures.width[t, k]), np.float32(textures.height[t, k])
        x_scale, y_scale = width / np.float32(textures.width[t, 0]), height / np.float32(textures.height[t, 0])
        x_step, x_base = real[index, U] * x_scale, (real[index, U + 1] * y + real[index, U + 2]) * x_scale
        y_step, y_base = real[index, V] * y_scale, (real[index, V + 1] * y + real[index, V + 2]) * y_scale
        half = np.float32(0.5 if smooth else 0.0)
        _positions(x_step, x_base, half, width - one, start, end, depth_m, position[0])
        _positions(y_step, y_base, half, height - one, start, end, depth_m, position[1])
        begin, pitch = np.int32(textures.offset[t, k]), textures.row_pitch[t, k]
        for column in range(start, end):
            level[0, column] = begin
            level[1, column] = pitch
        if not smooth:
            for column in range(start, end):
                position[0, column] = np.floor(position[0, column])
                position[1, column] = np.floor(position[1, column])
        start = end


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _positions(
    step: np.float32,
    base: np.float32,
    half: np.float32,
    largest: np.float32,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    position: NDArray[np.float32],
) -> None:
    """Write ``(base + step * column) * depth - half``, clipped to [0, largest]; by itself, to be vector code."""
    for column in range(first, last):
        x = np.float32(np.int32(column))
        value = (base + step * x) * depth_m[column] - half
        position[column] = min(max(value, np.float32(0.0)), largest)
