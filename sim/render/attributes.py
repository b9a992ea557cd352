"""Attributes of each pixel from its nearest triangle: the second half of the rasteriser."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.rows import (
    LANES,
    LEVEL_0_UP_TO,
    PITCH,
    TEXEL_LINES,
    fetch_row,
    find_runs,
    mip_level,
    new_lines,
    number_texels,
)
from sim.render.textures import TexturePool
from sim.render.visibility import (
    BODY,
    IS_FLAT,
    IS_SMOOTH,
    NOTHING,
    NX,
    NY,
    NZ,
    TEXEL_DENSITY,
    TEXTURE,
    TriangleTable,
    U,
    V,
)

LEVEL_BLOCK = 128
"""Neighbouring pixels of a row and triangle that share a mip level."""
SHORT = 64
"""Runs below this number of pixels are too short for vector code."""


class Visible(NamedTuple):
    """A picture whose nearest triangles are known, see ``draw_bodies``; maps are (H, W).

    Attributes:
        depth_m, instance_id: see ``GBuffer``; ids are written row by row.
    """

    textures: TexturePool
    table: TriangleTable
    nearness: NDArray[np.float32]
    triangle: NDArray[np.int32]
    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]


class Drawn(NamedTuple):
    """The first four of ``Visible``: a picture of which the depth is not needed."""

    textures: TexturePool
    table: TriangleTable
    nearness: NDArray[np.float32]
    triangle: NDArray[np.int32]


class SurfaceRow(NamedTuple):
    """Surfaces of the W pixels of one row.

    Attributes:
        colour: (W,) uint32 base colours, ``R | G << 8 | B << 16``; 0 where there is nothing.
        depth_m, instance_id: (W,), see ``GBuffer``.
        normal: (3, >= W), unit vectors in the world frame.
    """

    colour: NDArray[np.uint32]
    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]
    normal: NDArray[np.float32]


class ResolveScratch(NamedTuple):
    """Scratch of ``resolve_row``, for rows of W pixels.

    Attributes:
        real: line buffer (``sim.render.rows``) of depth, and x, y and z of the normal.
        normal: (3, ``PITCH``), the same x, y and z.
        whole: line buffer of what ``sim.render.rows`` needs, and the instance id.
        firsts: of runs (> W,).
        colour: (W,).
    """

    real: NDArray[np.float32]
    normal: NDArray[np.float32]
    whole: NDArray[np.uint32]
    firsts: NDArray[np.uint32]
    colour: NDArray[np.uint32]


@njit(cache=True)
def new_resolve_scratch(width: int) -> ResolveScratch:
    """Return scratch for rows of ``width`` pixels."""
    real, whole = new_lines(4, width), new_lines(TEXEL_LINES + 1, width).view(np.uint32)
    normal, firsts = real[PITCH:].reshape(3, PITCH), np.empty(width + 1, np.uint32)
    return ResolveScratch(real, normal, whole, firsts, np.empty(width, np.uint32))


@njit(cache=True)
def resolve_picture(seen: Visible, base_colour_rgb: NDArray[np.uint8], normal_world: NDArray[np.float32]) -> None:
    """Write a ``GBuffer``; arrays are (H, W) or (H, W, 3)."""
    width = seen.triangle.shape[1]
    scratch = new_resolve_scratch(width)
    for row in range(seen.triangle.shape[0]):
        surfaces = SurfaceRow(scratch.colour, seen.depth_m[row], seen.instance_id[row], scratch.normal)
        resolve_row(seen, row, scratch, surfaces)
        write_row(surfaces, base_colour_rgb[row], normal_world[row])


@row_kernel()
def write_row(surfaces: SurfaceRow, base_colour_rgb: NDArray[np.uint8], normal_world: NDArray[np.float32]) -> None:
    """Write a row of a ``GBuffer``; arrays are (W, 3)."""
    for column in range(base_colour_rgb.shape[0]):
        texel = surfaces.colour[column]
        base_colour_rgb[column, 0] = texel & np.uint32(255)
        base_colour_rgb[column, 1] = (texel >> np.uint32(8)) & np.uint32(255)
        base_colour_rgb[column, 2] = (texel >> np.uint32(16)) & np.uint32(255)
        for k in range(3):
            normal_world[column, k] = surfaces.normal[k, column]


@njit(cache=True, error_model="numpy")
def normals_of(drawn: Drawn, normal_world: NDArray[np.float32]) -> None:
    """Write the normals of a ``GBuffer`` (H, W, 3) alone, which takes a fifth of the time of all."""
    scratch = new_resolve_scratch(drawn.triangle.shape[1])
    width, normal = np.uint64(drawn.triangle.shape[1]), scratch.normal
    for row in range(drawn.triangle.shape[0]):
        triangle, written = drawn.triangle[row], normal_world[row]
        runs = find_runs(triangle, scratch.firsts)
        for run in range(runs):
            first, last = np.uint64(scratch.firsts[run]), np.uint64(scratch.firsts[run + np.uint64(1)])
            index = np.uint32(triangle[first])
            _describe_run(drawn.table.whole, drawn.table.real, index, row, first, last, scratch.whole, scratch.real)
        for column in range(width):
            written[column, 0] = normal[0, column]
            written[column, 1] = normal[1, column]
            written[column, 2] = normal[2, column]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def resolve_row(seen: Visible, row: int, scratch: ResolveScratch, surfaces: SurfaceRow) -> None:
    """Write the surfaces of one row of pixels; colour and normal are those of the scratch.

    With the planes of ``TriangleTable``: ``depth = 1 / nearness``, ``(u, v) = plane * depth`` and, on faces that
    are not flat, ``n = plane / |plane|``.
    """
    textures, nearness, triangle = seen.textures, seen.nearness[row], seen.triangle[row]
    real, whole, firsts = scratch.real, scratch.whole, scratch.firsts
    colour, depth_m, instance_id = surfaces.colour, surfaces.depth_m, surfaces.instance_id
    triangles, planes = seen.table.whole, seen.table.real
    width = np.uint64(triangle.shape[0])
    for column in range(width):
        depth_m[column] = np.float32(1.0) / nearness[column]
    for column in range(width):
        real[column] = depth_m[column]
    runs = find_runs(triangle, firsts)
    for run in range(runs):
        first, last = np.uint64(firsts[run]), np.uint64(firsts[run + np.uint64(1)])
        index = np.uint32(triangle[first])
        _describe_run(triangles, planes, index, row, first, last, whole, real)
        if index == NOTHING:
            for line in range(TEXEL_LINES):
                for column in range(first, last):
                    whole[np.uint64(line * PITCH) + column] = np.uint32(0)
        else:
            _place_run(textures, triangles, planes, index, row, first, last, real, whole)
    fetch_row(textures.texels, whole, colour)
    for column in range(width):
        colour[column] = np.uint32(0) if triangle[column] == NOTHING else colour[column]
    for column in range(width):
        instance_id[column] = np.int32(whole[np.uint64(TEXEL_LINES * PITCH) + column])


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _describe_run(
    triangles: NDArray[np.int32],
    planes: NDArray[np.float32],
    index: np.uint32,
    row: int,
    first: np.uint64,
    last: np.uint64,
    whole: NDArray[np.uint32],
    real: NDArray[np.float32],
) -> None:
    """Write body and normal of the pixels first … last - 1 of a triangle."""
    body = np.uint32(triangles[index, BODY])
    # A number, not a branch: the compiler would make two loops of it, and no vector code of the shorter one.
    flat = np.float32(triangles[index, IS_FLAT])
    to_body = np.uint64(TEXEL_LINES * PITCH)
    to_x, to_y, to_z = np.uint64(PITCH), np.uint64(2 * PITCH), np.uint64(3 * PITCH)
    y, one = np.float32(row), np.float32(1.0)
    x_step, x_base = planes[index, NX], planes[index, NX + 1] * y + planes[index, NX + 2]
    y_step, y_base = planes[index, NY], planes[index, NY + 1] * y + planes[index, NY + 2]
    z_step, z_base = planes[index, NZ], planes[index, NZ + 1] * y + planes[index, NZ + 2]
    for block in range(first, last, np.uint64(LANES)):
        for column in range(block, block + np.uint64(LANES)):
            x = np.float32(np.int32(column))
            nx, ny, nz = x_step * x + x_base, y_step * x + y_base, z_step * x + z_base
            scale = one / np.sqrt(flat + (one - flat) * (nx * nx + ny * ny + nz * nz))
            real[to_x + column], real[to_y + column], real[to_z + column] = nx * scale, ny * scale, nz * scale
            whole[to_body + column] = body


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _place_run(
    textures: TexturePool,
    triangles: NDArray[np.int32],
    planes: NDArray[np.float32],
    index: np.uint32,
    row: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    texel: NDArray[np.uint32],
) -> None:
    """Write the numbers and weights of the texels around the pixels first … last - 1 of a triangle.

    Texel (i, j) has its centre at ``(u width, v height) = (j + 1/2, i + 1/2)``; beyond the outermost centres the
    edge goes on. Palettes are not interpolated: each position is that of the nearest texel's centre.
    """
    y = np.float32(row)
    t, density = np.uint32(triangles[index, TEXTURE]), planes[index, TEXEL_DENSITY]
    half = np.float32(0.5 if triangles[index, IS_SMOOTH] else 0.0)
    u_step, u_base = planes[index, U], planes[index, U + 1] * y + planes[index, U + 2]
    v_step, v_base = planes[index, V], planes[index, V + 1] * y + planes[index, V + 2]
    z = depth_m[first]
    is_level_0 = last - first < np.uint64(SHORT) and density * z * z * z <= LEVEL_0_UP_TO
    start, k = first, np.uint32(0)
    while start < last:
        end = min(start + np.uint64(LEVEL_BLOCK), last)
        if not is_level_0:
            z = depth_m[start + ((end - start) >> np.uint64(1))]
            k = mip_level(density * z * z * z, textures.level_count[t])
        x_scale, y_scale = textures.scale[t, k, 0], textures.scale[t, k, 1]
        last_column, last_row = textures.last[t, k, 0], textures.last[t, k, 1]
        begin, pitch = textures.where[t, k, 0], textures.where[t, k, 1]
        number_texels(
            u_step * x_scale,
            u_base * x_scale,
            v_step * y_scale,
            v_base * y_scale,
            half,
            last_column,
            last_row,
            begin,
            pitch,
            start,
            end,
            depth_m,
            texel,
        )
        start = end
