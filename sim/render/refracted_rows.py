"""Attributes of the surfaces that bent rays meet, from the triangles of the rasteriser: a row of pixels at a time.

As ``sim.render.attributes``, but each pixel has its own place in the inner picture, between that picture's pixels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.attributes import LEVEL_BLOCK, SHORT, Drawn, SurfaceRow, write_row
from sim.render.compilation import row_kernel
from sim.render.rows import LANES, LEVEL_0_UP_TO, PITCH, TEXEL_LINES, fetch_row, find_runs, mip_level, new_lines
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
from sim.render.water.trace import Endings

_DEPTH, _NORMAL, _COLUMN, _ROW, _LINES = 0, 1, 4, 5, 6
"""Lines of the scratch."""


class Refracted(NamedTuple):
    """A picture whose bent rays have been traced; maps are (H, W).

    Attributes:
        straight: the camera's picture without water. inner: that of the eye.
        ends: of the rays in them.
        depth_m, instance_id: see ``GBuffer``; ids are written row by row.
    """

    straight: Drawn
    inner: Drawn
    ends: Endings
    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]


class RefractedScratch(NamedTuple):
    """Scratch of ``resolve_refracted_row``, for rows of W pixels; see ``ResolveScratch``, and:

    Attributes:
        real: has two more lines, the places in the inner picture.
        triangle: (W,) int32.
    """

    real: NDArray[np.float32]
    normal: NDArray[np.float32]
    whole: NDArray[np.uint32]
    firsts: NDArray[np.uint32]
    colour: NDArray[np.uint32]
    triangle: NDArray[np.int32]


@njit(cache=True)
def new_refracted_scratch(width: int) -> RefractedScratch:
    """Return scratch for rows of ``width`` pixels."""
    real, whole = new_lines(_LINES, width), new_lines(TEXEL_LINES + 1, width).view(np.uint32)
    normal, firsts = real[PITCH : 4 * PITCH].reshape(3, PITCH), np.empty(width + 1, np.uint32)
    return RefractedScratch(real, normal, whole, firsts, np.empty(width, np.uint32), np.empty(width, np.int32))


@njit(cache=True)
def resolve_refracted(seen: Refracted, base_colour_rgb: NDArray[np.uint8], normal_world: NDArray[np.float32]) -> None:
    """Write a ``GBuffer``; arrays are (H, W) or (H, W, 3)."""
    width = seen.depth_m.shape[1]
    scratch = new_refracted_scratch(width)
    for row in range(seen.depth_m.shape[0]):
        surfaces = SurfaceRow(scratch.colour, seen.depth_m[row], seen.instance_id[row], scratch.normal)
        resolve_refracted_row(seen, row, scratch, surfaces)
        write_row(surfaces, base_colour_rgb[row], normal_world[row])


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def resolve_refracted_row(seen: Refracted, row: int, scratch: RefractedScratch, surfaces: SurfaceRow) -> None:
    """Write the surfaces of one row of pixels, see ``sim.render.attributes.resolve_row``."""
    real, whole, firsts, triangle = scratch.real, scratch.whole, scratch.firsts, scratch.triangle
    colour, instance_id = surfaces.colour, surfaces.instance_id
    sources, bent, straight = seen.ends.source[row], seen.inner.triangle.reshape(-1), seen.straight.triangle.reshape(-1)
    width, one = np.uint64(triangle.shape[0]), np.int32(1)
    # Triangles of the straight picture have negative numbers.
    for column in range(width):
        k = sources[column]
        if k >= 0:
            triangle[column] = bent[np.uint64(np.uint32(k))]
        else:
            triangle[column] = -one - straight[np.uint64(np.uint32(-one - k))]
    to_column, to_row = np.uint64(_COLUMN * PITCH), np.uint64(_ROW * PITCH)
    for column in range(width):
        real[column] = surfaces.depth_m[column]
        real[to_column + column] = seen.ends.column[row, column]
        real[to_row + column] = seen.ends.row[row, column]
    runs = find_runs(triangle, firsts)
    for run in range(runs):
        first, last = np.uint64(firsts[run]), np.uint64(firsts[run + np.uint64(1)])
        is_bent = triangle[first] >= 0
        index = np.uint32(triangle[first] if is_bent else -one - triangle[first])
        table = seen.inner.table if is_bent else seen.straight.table
        _describe_run(table.whole, table.real, index, first, last, whole, real)
        if index == NOTHING:
            for line in range(TEXEL_LINES):
                for column in range(first, last):
                    whole[np.uint64(line * PITCH) + column] = np.uint32(0)
        else:
            _place_run(seen.inner.textures, table, index, first, last, real, whole)
    fetch_row(seen.inner.textures.texels, whole, colour)
    for column in range(width):
        is_none = (triangle[column] == NOTHING) | (triangle[column] == -1 - NOTHING)
        colour[column] = np.uint32(0) if is_none else colour[column]
    for column in range(width):
        instance_id[column] = np.int32(whole[np.uint64(TEXEL_LINES * PITCH) + column])


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _describe_run(
    triangles: NDArray[np.int32],
    planes: NDArray[np.float32],
    index: np.uint32,
    first: np.uint64,
    last: np.uint64,
    whole: NDArray[np.uint32],
    real: NDArray[np.float32],
) -> None:
    """Write body and normal of the pixels first … last - 1 of a triangle."""
    body, flat = np.uint32(triangles[index, BODY]), np.float32(triangles[index, IS_FLAT])
    to_body, to_column, to_row = np.uint64(TEXEL_LINES * PITCH), np.uint64(_COLUMN * PITCH), np.uint64(_ROW * PITCH)
    to_x, to_y, to_z = np.uint64(PITCH), np.uint64(2 * PITCH), np.uint64(3 * PITCH)
    one = np.float32(1.0)
    x_step, x_line, x_base = planes[index, NX], planes[index, NX + 1], planes[index, NX + 2]
    y_step, y_line, y_base = planes[index, NY], planes[index, NY + 1], planes[index, NY + 2]
    z_step, z_line, z_base = planes[index, NZ], planes[index, NZ + 1], planes[index, NZ + 2]
    for block in range(first, last, np.uint64(LANES)):
        for column in range(block, block + np.uint64(LANES)):
            x, y = real[to_column + column], real[to_row + column]
            nx, ny, nz = (
                x_step * x + x_line * y + x_base,
                y_step * x + y_line * y + y_base,
                z_step * x + z_line * y + z_base,
            )
            scale = one / np.sqrt(flat + (one - flat) * (nx * nx + ny * ny + nz * nz))
            real[to_x + column], real[to_y + column], real[to_z + column] = nx * scale, ny * scale, nz * scale
            whole[to_body + column] = body


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _place_run(
    textures: TexturePool,
    table: TriangleTable,
    index: np.uint32,
    first: np.uint64,
    last: np.uint64,
    real: NDArray[np.float32],
    texel: NDArray[np.uint32],
) -> None:
    """Write the numbers and weights of the texels around the pixels first … last - 1 of a triangle."""
    planes = table.real
    t, density = np.uint32(table.whole[index, TEXTURE]), planes[index, TEXEL_DENSITY]
    half = np.float32(0.5 if table.whole[index, IS_SMOOTH] else 0.0)
    z = real[first]
    is_level_0 = last - first < np.uint64(SHORT) and density * z * z * z <= LEVEL_0_UP_TO
    start, k = first, np.uint32(0)
    while start < last:
        end = min(start + np.uint64(LEVEL_BLOCK), last)
        if not is_level_0:
            z = real[start + ((end - start) >> np.uint64(1))]
            k = mip_level(density * z * z * z, textures.level_count[t])
        scale, edge, where = textures.scale[t, k], textures.last[t, k], textures.where[t, k]
        u_step, u_line, u_base = (
            planes[index, U] * scale[0],
            planes[index, U + 1] * scale[0],
            planes[index, U + 2] * scale[0],
        )
        v_step, v_line, v_base = (
            planes[index, V] * scale[1],
            planes[index, V + 1] * scale[1],
            planes[index, V + 2] * scale[1],
        )
        _number_texels(
            (u_step, u_line, u_base, edge[0]),
            (v_step, v_line, v_base, edge[1]),
            half,
            where[0],
            where[1],
            start,
            end,
            real,
            texel,
        )
        start = end


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _number_texels(
    across: tuple[np.float32, np.float32, np.float32, np.float32],
    down: tuple[np.float32, np.float32, np.float32, np.float32],
    half: np.float32,
    begin: np.int32,
    row_pitch: np.int32,
    first: np.uint64,
    last: np.uint64,
    real: NDArray[np.float32],
    texel: NDArray[np.uint32],
) -> None:
    """As ``sim.render.rows.number_texels``, at the places in the inner picture.

    Args:
        across, down: change of the texel's column or row per column and per row, constant, and the last texel.
    """
    to_01, to_10, to_11 = np.uint64(PITCH), np.uint64(2 * PITCH), np.uint64(3 * PITCH)
    to_weight_x, to_weight_y = np.uint64(4 * PITCH), np.uint64(5 * PITCH)
    to_column, to_row = np.uint64(_COLUMN * PITCH), np.uint64(_ROW * PITCH)
    u_step, u_line, u_base, last_column = across
    v_step, v_line, v_base, last_row = down
    zero, whole = np.float32(0.0), np.float32(256.0 if half > 0 else 0.0)
    for block in range(first, last, np.uint64(LANES)):
        for column in range(block, block + np.uint64(LANES)):
            x, y, z = real[to_column + column], real[to_row + column], real[column]
            u = min(max((u_base + u_step * x + u_line * y) * z - half, zero), last_column)
            v = min(max((v_base + v_step * x + v_line * y) * z - half, zero), last_row)
            j, i = np.int32(u), np.int32(v)
            j1, i1 = np.int32(j + 1), np.int32(i + 1)
            left = np.int32(((j >> 2) << 4) + (j & 3))
            right = np.int32(((j1 >> 2) << 4) + (j1 & 3))
            above = np.int32(np.int32(begin + np.int32((i >> 2) * row_pitch)) + ((i & 3) << 2))
            below = np.int32(np.int32(begin + np.int32((i1 >> 2) * row_pitch)) + ((i1 & 3) << 2))
            texel[column], texel[to_01 + column] = np.uint32(above + left), np.uint32(above + right)
            texel[to_10 + column], texel[to_11 + column] = np.uint32(below + left), np.uint32(below + right)
            texel[to_weight_x + column] = np.uint32(np.int32((u - np.float32(j)) * whole))
            texel[to_weight_y + column] = np.uint32(np.int32((v - np.float32(i)) * whole))
