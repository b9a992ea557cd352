"""What is seen in each pixel, given its nearest triangle: the second half of the rasteriser."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.sampling import LEVEL_0_UP_TO, mip_level, sample_row
from sim.render.textures import TexturePool
from sim.render.visibility import NOTHING, TriangleTable

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


@njit(cache=True, error_model="numpy")
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
    width = np.uint64(triangle.shape[0])
    for column in range(triangle.shape[0]):
        depth_m[column] = np.float32(1.0) / nearness[column]
    _describe(table.body, table.normal, triangle, instance_id, normal[0], normal[1], normal[2])
    first = np.uint64(0)
    # Unsigned numbers of columns: signed ones would be checked for counting from the end.
    while first < width:
        index = triangle[first]
        last = first + np.uint64(1)
        while last < width and triangle[last] == index:
            last += np.uint64(1)
        short = last - first < np.uint64(SHORT) and _place_short_run(
            table, index, row, first, last, depth_m, room.position, room.level
        )
        if not short:
            _place_run(textures, table, index, row, first, last, depth_m, room.position, room.level)
        if not table.is_flat[index]:
            _smooth_normals(table.normal_planes, index, row, first, last, normal)
        first = last
    sample_row(textures.texels, room.position, room.level, room.texel, colour)
    for column in range(triangle.shape[0]):
        colour[column] = np.uint32(0) if triangle[column] == NOTHING else colour[column]


@njit(cache=True, error_model="numpy")
def _describe(
    body: NDArray[np.int32],
    face_normal: NDArray[np.float32],
    triangle: NDArray[np.int32],
    instance_id: NDArray[np.int32],
    normal_x: NDArray[np.float32],
    normal_y: NDArray[np.float32],
    normal_z: NDArray[np.float32],
) -> None:
    """Write body and (flat) normal of each pixel's triangle."""
    for column in range(triangle.shape[0]):
        index = np.uint32(triangle[column])
        instance_id[column] = body[index]
        normal_x[column] = face_normal[index, 0]
        normal_y[column] = face_normal[index, 1]
        normal_z[column] = face_normal[index, 2]


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _smooth_normals(
    planes: NDArray[np.float32],
    index: int,
    row: int,
    first: np.uint64,
    last: np.uint64,
    normal: NDArray[np.float32],
) -> None:
    """Write ``n = plane / |plane|`` of the pixels first … last - 1 of a triangle."""
    y = np.float32(row)
    for column in range(first, last):
        x = np.float32(np.int32(column))
        nx = planes[index, 0] * x + planes[index, 1] * y + planes[index, 2]
        ny = planes[index, 3] * x + planes[index, 4] * y + planes[index, 5]
        nz = planes[index, 6] * x + planes[index, 7] * y + planes[index, 8]
        scale = np.float32(1.0) / np.sqrt(nx * nx + ny * ny + nz * nz)
        normal[0, column], normal[1, column], normal[2, column] = nx * scale, ny * scale, nz * scale


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _place_short_run(
    table: TriangleTable,
    index: int,
    row: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    position: NDArray[np.float32],
    level: NDArray[np.int32],
) -> bool:
    """Do as ``_place_run``, of which this is the short cut for few pixels, and return True if mip level 0 will do."""
    z = depth_m[first]
    if index != NOTHING and table.texel_density[index] * z * z * z > LEVEL_0_UP_TO:
        return False
    planes, y = table.texel_planes, np.float32(row)
    x_step, x_base = planes[index, 0], planes[index, 1] * y + planes[index, 2]
    y_step, y_base = planes[index, 3], planes[index, 4] * y + planes[index, 5]
    x_last, y_last = table.last_texel[index, 0], table.last_texel[index, 1]
    begin, pitch, smooth = table.begin[index], table.row_pitch[index], table.is_smooth[index]
    half, zero = np.float32(0.5 if smooth else 0.0), np.float32(0.0)
    for column in range(first, last):
        z = depth_m[column] if index != NOTHING else zero
        x = np.float32(np.int32(column))
        a = min(max((x_base + x_step * x) * z - half, zero), x_last)
        b = min(max((y_base + y_step * x) * z - half, zero), y_last)
        position[0, column] = a if smooth else np.floor(a)
        position[1, column] = b if smooth else np.floor(b)
        level[0, column] = begin
        level[1, column] = pitch
    return True


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _place_run(
    textures: TexturePool,
    table: TriangleTable,
    index: int,
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
    t, y, one = table.texture[index], np.float32(row), np.float32(1.0)
    planes, smooth, count = table.texel_planes, table.is_smooth[index], textures.level_count[t]
    start = first
    while start < last:
        end = min(start + np.uint64(LEVEL_BLOCK), last)
        z = depth_m[start + ((end - start) >> np.uint64(1))]
        k = mip_level(table.texel_density[index] * z * z * z, count)
        width, height = np.float32(textures.width[t, k]), np.float32(textures.height[t, k])
        x_scale, y_scale = width / np.float32(textures.width[t, 0]), height / np.float32(textures.height[t, 0])
        x_step, x_base = planes[index, 0] * x_scale, (planes[index, 1] * y + planes[index, 2]) * x_scale
        y_step, y_base = planes[index, 3] * y_scale, (planes[index, 4] * y + planes[index, 5]) * y_scale
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
