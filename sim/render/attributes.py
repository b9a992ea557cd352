"""What is seen in each pixel, given its nearest triangle: the second half of the rasteriser."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.gbuffer import SKY
from sim.render.sampling import BLOCK, mip_level, sample_nearest, sample_smooth
from sim.render.scene import SceneArrays
from sim.render.textures import TexturePool
from sim.render.visibility import TriangleTable


@njit(cache=True)
def resolve_picture(
    scene: SceneArrays,
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
    room = np.empty((6, BLOCK), np.uint32)
    colour = np.empty(width, np.uint32)
    normal = np.empty((3, width), np.float32)
    for row in range(triangle.shape[0]):
        depth, identity = depth_m[row], instance_id[row]
        resolve_row(scene, textures, table, row, nearness[row], triangle[row], room, colour, depth, identity, normal)
        for column in range(width):
            texel = colour[column]
            base_colour_rgb[row, column, 0] = texel & np.uint32(255)
            base_colour_rgb[row, column, 1] = (texel >> np.uint32(8)) & np.uint32(255)
            base_colour_rgb[row, column, 2] = (texel >> np.uint32(16)) & np.uint32(255)
            for k in range(3):
                normal_world[row, column, k] = normal[k, column]


@njit(cache=True, error_model="numpy")
def resolve_row(
    scene: SceneArrays,
    textures: TexturePool,
    table: TriangleTable,
    row: int,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
    room: NDArray[np.uint32],
    colour: NDArray[np.uint32],
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    normal: NDArray[np.float32],
) -> None:
    """Write what one row of pixels shows, a run of pixels with the same triangle at a time.

    With the planes of ``TriangleTable``: ``depth = 1 / nearness``, ``(u, v) = plane * depth`` and, on faces that
    are not flat, ``n = plane / |plane|``.

    Args:
        room: (6, BLOCK), see ``sample_smooth``.
        colour: (W,), written: packed like texels, 0 where there is nothing; so are the others.
        normal: (3, W).
    """
    width = triangle.shape[0]
    for column in range(width):
        depth_m[column] = np.float32(1.0) / nearness[column]
    first = 0
    while first < width:
        index = triangle[first]
        last = first + 1
        while last < width and triangle[last] == index:
            last += 1
        if index < 0:
            for column in range(first, last):
                instance_id[column], colour[column] = SKY, 0
                normal[0, column] = normal[1, column] = normal[2, column] = 0.0
        else:
            _fill_integers(instance_id[first:last], table.body[index])
            depth = depth_m[first:last]
            _colour_run(scene, textures, table, index, row, first, depth, room, colour[first:last])
            _normal_run(scene, table, index, row, first, last, normal)
        first = last


@njit(cache=True, error_model="numpy")
def _colour_run(
    scene: SceneArrays,
    textures: TexturePool,
    table: TriangleTable,
    index: int,
    row: int,
    first_column: int,
    depth_m: NDArray[np.float32],
    room: NDArray[np.uint32],
    colour: NDArray[np.uint32],
) -> None:
    planes = table.uv_planes[index]
    u_plane = (planes[0], planes[1] * np.float32(row) + planes[2])
    v_plane = (planes[3], planes[4] * np.float32(row) + planes[5])
    t = scene.texture[table.body[index]]
    if not textures.smooth[t]:
        texels = textures.texels[textures.offset[t, 0] :]
        size = (textures.width[t, 0], textures.height[t, 0])
        sample_nearest(texels, size, u_plane, v_plane, first_column, depth_m, colour)
        return
    density = table.uv_density[index] * np.float32(textures.width[t, 0] * textures.height[t, 0])
    for start in range(0, depth_m.shape[0], BLOCK):
        end = min(start + BLOCK, depth_m.shape[0])
        z = depth_m[(start + end) // 2]
        k = mip_level(density * z * z * z, textures.level_count[t])
        texels = textures.texels[textures.offset[t, k] :]
        size = (textures.width[t, k], textures.height[t, k])
        depth, out = depth_m[start:end], colour[start:end]
        sample_smooth(texels, size, u_plane, v_plane, first_column + start, depth, room, out)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _normal_run(
    scene: SceneArrays,
    table: TriangleTable,
    index: int,
    row: int,
    first: int,
    last: int,
    normal: NDArray[np.float32],
) -> None:
    normal_x, normal_y, normal_z = normal[0, first:last], normal[1, first:last], normal[2, first:last]
    p = table.normal_planes[index]
    if scene.face_is_flat[table.face[index]]:
        _fill_reals(normal_x, p[2])
        _fill_reals(normal_y, p[5])
        _fill_reals(normal_z, p[8])
        return
    y = np.float32(row)
    for k in range(last - first):
        x = np.float32(first + k)
        nx, ny, nz = p[0] * x + p[1] * y + p[2], p[3] * x + p[4] * y + p[5], p[6] * x + p[7] * y + p[8]
        scale = np.float32(1.0) / np.sqrt(nx * nx + ny * ny + nz * nz)
        normal_x[k], normal_y[k], normal_z[k] = nx * scale, ny * scale, nz * scale


@njit(cache=True)
def _fill_integers(out: NDArray[np.int32], value: np.int32) -> None:
    for k in range(out.shape[0]):
        out[k] = value


@njit(cache=True)
def _fill_reals(out: NDArray[np.float32], value: np.float32) -> None:
    for k in range(out.shape[0]):
        out[k] = value
