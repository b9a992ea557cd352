"""Rays bent at a rippled surface, and the way back: where points of the water are seen."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.water_surface import SurfaceGrid, Waves, sum_waves

ZERO, HALF, ONE, TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)
SURFACE_DEPTH, ALONG_X, ALONG_Y, MIRROR_X, MIRROR_Y, REFLECTANCE = range(6)
"""Planes of ``WaterRays.nodes``."""
FARTHEST_M = np.float32(1e6)
STEP_PX = 4
"""Rays are bent at every fourth pixel of every fourth row, and interpolated between."""
STEEPEST = np.float32(-0.02)
"""Rays that fall less than this, per unit of depth, miss the water."""


class WaterBody(NamedTuple):
    """A body of water.

    Attributes:
        low_m, high_m: (2,) float64 corners of its rectangle, world frame.
        level_m, depth_m: of the surface at rest; down from there to the floor.
        refractive_index: > 1.
    """

    low_m: NDArray[np.float64]
    high_m: NDArray[np.float64]
    level_m: float
    depth_m: float
    refractive_index: float


class WaterRays(NamedTuple):
    """Bent rays of a picture, at every ``STEP_PX``-th pixel of every ``STEP_PX``-th row.

    Attributes:
        nodes: (6, R, C) float32: depth z_s of the surface, ``FARTHEST_M`` where it is missed; e along x and y in
            pixels; run along x and y of the reflected ray per metre of its rise; share of light reflected.
        pixel_offset: where in a pixel it is sampled.
        position_m: (3,) of the camera.
        matrix: (3, 3) from (x, y, 1) of a pixel to its ray at unit camera depth, world frame.
        water: seen through.
    """

    nodes: NDArray[np.float32]
    pixel_offset: float
    position_m: NDArray[np.float64]
    matrix: NDArray[np.float64]
    water: WaterBody


@row_kernel()
def ray(matrix: NDArray[np.float64], x: float, y: float) -> tuple[float, float, float]:
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2],
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2],
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2],
    )


@njit(cache=True, inline="always", error_model="numpy")
def bend(
    dx: float, dy: float, dz: float, slope_x: float, slope_y: float, index: float | np.float32
) -> tuple[float, float, float, float, float]:
    """Return the ray (3,) behind a surface of these slopes for one of any length before it, by Snell's law in vector
    form: ``t = d / n + (cos i / n - cos t) N``; and cos i and cos t.
    """
    scale = ONE / np.sqrt(dx * dx + dy * dy + dz * dz)
    dx, dy, dz = dx * scale, dy * scale, dz * scale
    nz = ONE / np.sqrt(ONE + slope_x * slope_x + slope_y * slope_y)
    nx, ny = -slope_x * nz, -slope_y * nz
    cos_i = -(dx * nx + dy * ny + dz * nz)
    cos_t = np.sqrt(ONE - (ONE - cos_i * cos_i) / (index * index))
    along = cos_i / index - cos_t
    return dx / index + along * nx, dy / index + along * ny, dz / index + along * nz, cos_i, cos_t


@njit(cache=True, inline="always", error_model="numpy")
def vanishing(projection: NDArray[np.floating], tx: float, ty: float, tz: float) -> tuple[float, float]:
    """Return the pixel in which all rays of a direction meet."""
    w = projection[2, 0] * tx + projection[2, 1] * ty + projection[2, 2] * tz
    x = projection[0, 0] * tx + projection[0, 1] * ty + projection[0, 2] * tz
    y = projection[1, 0] * tx + projection[1, 1] * ty + projection[1, 2] * tz
    return x / w, y / w


@njit(cache=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def bend_rays(rays: WaterRays, projection: NDArray[np.float64], grid: SurfaceGrid) -> None:
    """Write the nodes.

    A ray meets the surface where it would meet one at the height above its place on the level surface. The share of
    unpolarised light reflected is the mean of Fresnel's ``((cos i - n cos t) / (cos i + n cos t))²`` and
    ``((n cos i - cos t) / (n cos i + cos t))²``.
    """
    nodes = rays.nodes
    matrix, origin = rays.matrix.astype(np.float32), rays.position_m.astype(np.float32)
    onto = projection.astype(np.float32)
    columns = nodes.shape[2]
    lines, cells = np.empty((8, columns), np.float32), np.empty(columns, np.int32)
    drop, offset = np.float32(rays.water.level_m - rays.position_m[2]), np.float32(rays.pixel_offset)
    for row in range(nodes.shape[1]):
        y = np.float32(row * STEP_PX) + offset
        dx, dy, dz, depth = lines[0], lines[1], lines[2], nodes[SURFACE_DEPTH, row]
        for k in range(columns):
            x = np.float32(np.int32(k * STEP_PX)) + offset
            dx[k] = matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]
            dy[k] = matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]
            dz[k] = min(matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2], STEEPEST)
            depth[k] = drop / dz[k]
        _look_up(grid, origin, lines, depth, 0, 1, cells)
        for k in range(columns):
            depth[k] = (drop + lines[5, k]) / dz[k]
        _look_up(grid, origin, lines, depth, 1, 3, cells)
        _bend_row(np.float32(rays.water.refractive_index), onto, row, offset, lines, nodes)
        for k in range(columns):
            if not dz[k] < STEEPEST:
                nodes[:, row, k] = ZERO
                depth[k] = FARTHEST_M


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _look_up(
    grid: SurfaceGrid,
    origin: NDArray[np.float32],
    lines: NDArray[np.float32],
    depth: NDArray[np.float32],
    first: int,
    after: int,
    cells: NDArray[np.int32],
) -> None:
    """Write planes first … after - 1 of a surface to lines 5 on, by linear interpolation; beyond the grid, its edge.

    Args:
        lines: of the rays' directions (0 to 2); 3 and 4 are scratch.
    """
    values, per_m = grid.values, np.float32(1.0 / grid.step_m)
    x_first, y_first = np.float32(grid.first_m[0]) - origin[0], np.float32(grid.first_m[1]) - origin[1]
    most_s, most_t = np.float32(values.shape[2]) - np.float32(1.01), np.float32(values.shape[1]) - np.float32(1.01)
    pitch = np.int32(values.shape[2])
    dx, dy, s, t = lines[0], lines[1], lines[3], lines[4]
    for k in range(depth.shape[0]):
        u = min(max((depth[k] * dx[k] - x_first) * per_m, ZERO), most_s)
        v = min(max((depth[k] * dy[k] - y_first) * per_m, ZERO), most_t)
        j, i = np.int32(u), np.int32(v)
        cells[k] = np.int32(i * pitch) + j
        s[k], t[k] = u - np.float32(j), v - np.float32(i)
    for plane in range(first, after):
        flat, into = values[plane].reshape(-1), lines[5 + plane - first]
        for k in range(depth.shape[0]):
            cell = np.uint64(np.uint32(cells[k]))
            below = cell + np.uint64(np.uint32(pitch))
            upper = flat[cell] + s[k] * (flat[cell + np.uint64(1)] - flat[cell])
            lower = flat[below] + s[k] * (flat[below + np.uint64(1)] - flat[below])
            into[k] = upper + t[k] * (lower - upper)


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _bend_row(
    index: np.float32,
    onto: NDArray[np.float32],
    row: int,
    offset: np.float32,
    lines: NDArray[np.float32],
    nodes: NDArray[np.float32],
) -> None:
    """Write one row of nodes, but for the depth, from directions (lines 0 to 2) and slopes (5 and 6)."""
    along_x, along_y, mirror_x, mirror_y = (
        nodes[ALONG_X, row],
        nodes[ALONG_Y, row],
        nodes[MIRROR_X, row],
        nodes[MIRROR_Y, row],
    )
    reflectance, y = nodes[REFLECTANCE, row], np.float32(row * STEP_PX) + offset
    dx, dy, dz, slope_x, slope_y = lines[0], lines[1], lines[2], lines[5], lines[6]
    for k in range(along_x.shape[0]):
        sx, sy = slope_x[k], slope_y[k]
        tx, ty, tz, cos_i, cos_t = bend(dx[k], dy[k], dz[k], sx, sy, index)
        vx, vy = vanishing(onto, tx, ty, tz)
        along_x[k] = vx - (np.float32(np.int32(k * STEP_PX)) + offset)
        along_y[k] = vy - y
        # r = d + 2 cos i N, here for d = (dx, dy, dz) of any length, times (1 + slope²).
        rise = dx[k] * sx + dy[k] * sy - dz[k]
        steep = ONE + sx * sx + sy * sy
        rz = dz[k] * steep + TWO * rise
        mirror_x[k] = (dx[k] * steep - TWO * rise * sx) / rz
        mirror_y[k] = (dy[k] * steep - TWO * rise * sy) / rz
        across = (cos_i - index * cos_t) / (cos_i + index * cos_t)
        parallel = (index * cos_i - cos_t) / (index * cos_i + cos_t)
        reflectance[k] = HALF * (across * across + parallel * parallel)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def interpolate_row(plane: NDArray[np.float32], row: int, width: int, line: NDArray[np.float32]) -> None:
    """Write the values (W,) of one row of pixels from those of a plane of nodes (R, C)."""
    i = min(row // STEP_PX, plane.shape[0] - 2)
    t = np.float32(row - i * STEP_PX) * np.float32(1.0 / STEP_PX)
    quarter, upper, lower = np.float32(1.0 / STEP_PX), plane[i], plane[i + 1]
    before = upper[0] + t * (lower[0] - upper[0])
    for j in range(width // STEP_PX):
        after = upper[j + 1] + t * (lower[j + 1] - upper[j + 1])
        rise = (after - before) * quarter
        for k in range(STEP_PX):
            line[j * STEP_PX + k] = before + np.float32(k) * rise
        before = after
    for k in range(width - width % STEP_PX, width):
        j = width // STEP_PX
        after = upper[j + 1] + t * (lower[j + 1] - upper[j + 1])
        line[k] = before + np.float32(k % STEP_PX) * quarter * (after - before)


_SAME_HEIGHT_M = 1e-8
"""Heights of the surface that differ less are at one place: to a thousandth of a pixel, even of a grazing ray."""


@njit(cache=True, error_model="numpy")
def _exact_ray(
    water: WaterBody,
    waves: Waves,
    time_s: float,
    origin: NDArray[np.float64],
    matrix: NDArray[np.float64],
    projection: NDArray[np.float64],
    x: float,
    y: float,
) -> tuple[float, float, float]:
    """Return z_s and e of one pixel, of the sum of waves itself; NaN where the ray misses the water."""
    dx, dy, dz = ray(matrix, x, y)
    if not dz < STEEPEST:
        return np.nan, np.nan, np.nan
    height, before, slope_x, slope_y, depth = 0.0, np.inf, 0.0, 0.0, 0.0
    for _ in range(5):
        if abs(height - before) < _SAME_HEIGHT_M:
            break
        before, depth = height, (water.level_m + height - origin[2]) / dz
        height, slope_x, slope_y = sum_waves(waves, time_s, origin[0] + depth * dx, origin[1] + depth * dy)
    tx, ty, tz, _, _ = bend(dx, dy, dz, slope_x, slope_y, water.refractive_index)
    vx, vy = vanishing(projection, tx, ty, tz)
    return depth, vx - x, vy - y


@njit(cache=True, error_model="numpy")
def find_entries(
    water: WaterBody,
    waves: Waves,
    time_s: float,
    origin: NDArray[np.float64],
    matrix: NDArray[np.float64],
    projection: NDArray[np.float64],
    depth_m: NDArray[np.float64],
    pixels: NDArray[np.float64],
) -> None:
    """Replace pixels (N, 2), where the inner renderer draws points at depths (N,), by those at which they are seen.

    Solves ``p + (1 - z_s(p) / w) e(p) = q`` by Broyden's method (1965), from p = q with the unit matrix.
    """
    for n in range(pixels.shape[0]):
        qx, qy, w = pixels[n, 0], pixels[n, 1], depth_m[n]
        x, y, x_before, y_before, fx_before, fy_before = qx, qy, qx, qy, 0.0, 0.0
        a, b, c, d = 1.0, 0.0, 0.0, 1.0
        found = False
        for iteration in range(40):
            z, ex, ey = _exact_ray(water, waves, time_s, origin, matrix, projection, x, y)
            share = 1.0 - z / w
            fx, fy = x + share * ex - qx, y + share * ey - qy
            if fx * fx + fy * fy < 1e-7:
                found = True
                break
            if iteration > 0:
                # The inverse Jacobian (a b; c d) changes by the least that explains the last step (Sherman-Morrison).
                sx, sy, gx, gy = x - x_before, y - y_before, fx - fx_before, fy - fy_before
                ux, uy = a * gx + b * gy, c * gx + d * gy
                scale = 1.0 / (sx * ux + sy * uy)
                rx, ry = (sx - ux) * scale, (sy - uy) * scale
                lx, ly = sx * a + sy * c, sx * b + sy * d
                a, b, c, d = a + rx * lx, b + rx * ly, c + ry * lx, d + ry * ly
            x_before, y_before, fx_before, fy_before = x, y, fx, fy
            x, y = x - (a * fx + b * fy), y - (c * fx + d * fy)
        pixels[n, 0], pixels[n, 1] = (x, y) if found else (np.nan, np.nan)
