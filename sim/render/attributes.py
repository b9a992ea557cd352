"""What is seen in each pixel, given its nearest triangle: the second half of the rasteriser."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.gbuffer import SKY
from sim.render.sampling import mip_level, sample_nearest, sample_smooth
from sim.render.scene import SceneArrays
from sim.render.textures import TexturePool
from sim.render.visibility import TriangleTable

LEVEL_BLOCK = 32
"""The mip level is chosen once for so many neighbouring pixels of a row and triangle."""


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
    for row in range(triangle.shape[0]):
        resolve_row(
            scene,
            textures,
            table,
            row,
            nearness[row],
            triangle[row],
            base_colour_rgb[row],
            depth_m[row],
            instance_id[row],
            normal_world[row],
        )


@njit(cache=True, error_model="numpy")
def resolve_row(
    scene: SceneArrays,
    textures: TexturePool,
    table: TriangleTable,
    row: int,
    nearness: NDArray[np.float32],
    triangle: NDArray[np.int32],
    base_colour_rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    normal_world: NDArray[np.float32],
) -> None:
    """Write one row of a ``GBuffer``, a run of pixels with the same triangle at a time.

    With the planes of ``TriangleTable``: ``depth = 1 / nearness``, ``(u, v) = plane * depth`` and, on faces
    that are not flat, ``n = plane / |plane|``.
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
            instance_id[first:last] = SKY
            base_colour_rgb[first:last] = 0
            normal_world[first:last] = 0.0
        else:
            instance_id[first:last] = table.body[index]
            _colour_run(scene, textures, table, index, row, first, depth_m[first:last], base_colour_rgb[first:last])
            _normal_run(scene, table, index, row, first, normal_world[first:last])
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
    colour_rgb: NDArray[np.uint8],
) -> None:
    planes = table.uv_planes[index]
    u_plane = (planes[0], planes[1] * np.float32(row) + planes[2])
    v_plane = (planes[3], planes[4] * np.float32(row) + planes[5])
    t = scene.texture[table.body[index]]
    size = textures.width[t, 0] * textures.height[t, 0]
    if not textures.smooth[t]:
        texels = textures.texels[textures.offset[t, 0] : textures.offset[t, 0] + size]
        sample_nearest(
            texels,
            textures.width[t, 0],
            textures.height[t, 0],
            u_plane,
            v_plane,
            first_column,
            depth_m,
            colour_rgb,
        )
        return
    density = table.uv_density[index] * np.float32(size)
    for start in range(0, depth_m.shape[0], LEVEL_BLOCK):
        end = min(start + LEVEL_BLOCK, depth_m.shape[0])
        z = depth_m[(start + end) // 2]
        k = mip_level(density * z * z * z, textures.level_count[t])
        wide, high = textures.width[t, k], textures.height[t, k]
        texels = textures.texels[textures.offset[t, k] : textures.offset[t, k] + wide * high]
        sample_smooth(
            texels,
            wide,
            high,
            u_plane,
            v_plane,
            first_column + start,
            depth_m[start:end],
            colour_rgb[start:end],
        )


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _normal_run(
    scene: SceneArrays,
    table: TriangleTable,
    index: int,
    row: int,
    first_column: int,
    normal_world: NDArray[np.float32],
) -> None:
    p = table.normal_planes[index]
    if scene.face_is_flat[table.face[index]]:
        for k in range(normal_world.shape[0]):
            normal_world[k, 0] = p[2]
            normal_world[k, 1] = p[5]
            normal_world[k, 2] = p[8]
        return
    y = np.float32(row)
    for k in range(normal_world.shape[0]):
        x = np.float32(first_column + k)
        nx, ny, nz = p[0] * x + p[1] * y + p[2], p[3] * x + p[4] * y + p[5], p[6] * x + p[7] * y + p[8]
        scale = np.float32(1.0) / np.sqrt(nx * nx + ny * ny + nz * nz)
        normal_world[k, 0] = nx * scale
        normal_world[k, 1] = ny * scale
        normal_world[k, 2] = nz * scale
