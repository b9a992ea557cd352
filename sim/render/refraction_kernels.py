"""The kernels of ``sim.render.refraction``."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.water_surface import SurfaceGrid, Waves, sum_waves

SURFACE_DEPTH, ALONG_X, ALONG_Y, MIRROR_X, MIRROR_Y, REFLECTANCE = range(6)
"""Planes of ``WaterRays.nodes``."""
FARTHEST_M = 1e6
_STEEPEST = -0.02
"""Rays that fall less than this, per unit of depth, miss the water."""
_STEP_PX = 0.5
_MOST_STEPS = 400


class Water(NamedTuple):
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
    """Bent rays of a picture, at every ``step_px``-th pixel of every ``step_px``-th row.

    Attributes:
        nodes: (6, R, C) float32: depth z_s of the surface, ``FARTHEST_M`` where it is missed; e along x and y in pixels;
            run along x and y of the reflected ray per metre of its rise; share of light that the surface reflects.
        step_px: distance of nodes. pixel_offset: where in a pixel it is sampled.
        position_m: (3,) of the camera.
        matrix: (3, 3) from (x, y, 1) of a pixel to its ray at unit camera depth, world frame.
        water: seen through.
    """

    nodes: NDArray[np.float32]
    step_px: int
    pixel_offset: float
    position_m: NDArray[np.float64]
    matrix: NDArray[np.float64]
    water: Water


@njit(cache=True, inline="always")
def _ray(matrix: NDArray[np.float64], x: float, y: float) -> tuple[float, float, float]:
    return (
        matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2],
        matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2],
        matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2],
    )


@njit(cache=True, inline="always", error_model="numpy")
def _bend(
    dx: float, dy: float, dz: float, slope_x: float, slope_y: float, index: float
) -> tuple[float, float, float, float, float]:
    """Return the ray (3,) behind a surface of these slopes for one of any length before it, by Snell's law in vector
    form: ``t = d / n + (cos i / n - cos t) N``; and cos i and cos t.
    """
    scale = 1.0 / np.sqrt(dx * dx + dy * dy + dz * dz)
    dx, dy, dz = dx * scale, dy * scale, dz * scale
    nz = 1.0 / np.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    nx, ny = -slope_x * nz, -slope_y * nz
    cos_i = -(dx * nx + dy * ny + dz * nz)
    cos_t = np.sqrt(1.0 - (1.0 - cos_i * cos_i) / (index * index))
    along = cos_i / index - cos_t
    return dx / index + along * nx, dy / index + along * ny, dz / index + along * nz, cos_i, cos_t


@njit(cache=True, inline="always", error_model="numpy")
def _vanishing(projection: NDArray[np.float64], tx: float, ty: float, tz: float) -> tuple[float, float]:
    """Return the pixel in which all rays of a direction meet."""
    w = projection[2, 0] * tx + projection[2, 1] * ty + projection[2, 2] * tz
    x = projection[0, 0] * tx + projection[0, 1] * ty + projection[0, 2] * tz
    y = projection[1, 0] * tx + projection[1, 1] * ty + projection[1, 2] * tz
    return x / w, y / w


@njit(cache=True, inline="always", error_model="numpy")
def _at(grid: SurfaceGrid, x: float, y: float) -> tuple[float, float, float]:
    """Return height and slopes of a surface by linear interpolation; beyond the grid, those of its edge."""
    values = grid.values
    s = min(max((x - grid.first_m[0]) / grid.step_m, 0.0), values.shape[2] - 1.001)
    t = min(max((y - grid.first_m[1]) / grid.step_m, 0.0), values.shape[1] - 1.001)
    j, i = int(s), int(t)
    s, t = s - j, t - i
    a, b, c, d = (1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t
    height = a * values[0, i, j] + b * values[0, i, j + 1] + c * values[0, i + 1, j] + d * values[0, i + 1, j + 1]
    slope_x = a * values[1, i, j] + b * values[1, i, j + 1] + c * values[1, i + 1, j] + d * values[1, i + 1, j + 1]
    slope_y = a * values[2, i, j] + b * values[2, i, j + 1] + c * values[2, i + 1, j] + d * values[2, i + 1, j + 1]
    return height, slope_x, slope_y


@njit(cache=True, error_model="numpy")
def bend_rays(rays: WaterRays, projection: NDArray[np.float64], grid: SurfaceGrid) -> None:
    """Write the nodes.

    The share of unpolarised light reflected is the mean of Fresnel's ``((cos i - n cos t) / (cos i + n cos t))²`` and
    ``((n cos i - cos t) / (n cos i + cos t))²``.
    """
    nodes, origin, index = rays.nodes, rays.position_m, rays.water.refractive_index
    drop = rays.water.level_m - origin[2]
    for row in range(nodes.shape[1]):
        y = row * rays.step_px + rays.pixel_offset
        for column in range(nodes.shape[2]):
            x = column * rays.step_px + rays.pixel_offset
            dx, dy, dz = _ray(rays.matrix, x, y)
            if not dz < _STEEPEST:
                nodes[:, row, column] = 0.0
                nodes[SURFACE_DEPTH, row, column] = FARTHEST_M
                continue
            depth = drop / dz
            height, slope_x, slope_y = _at(grid, origin[0] + depth * dx, origin[1] + depth * dy)
            depth = (drop + height) / dz
            height, slope_x, slope_y = _at(grid, origin[0] + depth * dx, origin[1] + depth * dy)
            tx, ty, tz, cos_i, cos_t = _bend(dx, dy, dz, slope_x, slope_y, index)
            vx, vy = _vanishing(projection, tx, ty, tz)
            nodes[SURFACE_DEPTH, row, column] = (drop + height) / dz
            nodes[ALONG_X, row, column], nodes[ALONG_Y, row, column] = vx - x, vy - y
            # r = d + 2 cos i N, here for d = (dx, dy, dz) of any length, times (1 + slope²).
            rise = dx * slope_x + dy * slope_y - dz
            steep = 1.0 + slope_x * slope_x + slope_y * slope_y
            rz = dz * steep + 2.0 * rise
            nodes[MIRROR_X, row, column] = (dx * steep - 2.0 * rise * slope_x) / rz
            nodes[MIRROR_Y, row, column] = (dy * steep - 2.0 * rise * slope_y) / rz
            across = (cos_i - index * cos_t) / (cos_i + index * cos_t)
            parallel = (index * cos_i - cos_t) / (index * cos_i + cos_t)
            nodes[REFLECTANCE, row, column] = 0.5 * (across * across + parallel * parallel)


@njit(cache=True, inline="always", error_model="numpy")
def _floor_depth(rays: WaterRays, x: float, y: float, surface_depth: float, ex: float, ey: float) -> float:
    """Return the depth at which the bent ray of a pixel meets the water's floor."""
    fall = rays.matrix[2, 0] * (x + ex) + rays.matrix[2, 1] * (y + ey) + rays.matrix[2, 2]
    return surface_depth - rays.water.depth_m / fall


@njit(cache=True, error_model="numpy")
def widest_shift(rays: WaterRays, width: int, height: int) -> tuple[float, float]:
    """Return how far beyond the picture's border places on the floor lie in the inner picture, pixels along x and y."""
    nodes, water = rays.nodes, rays.water
    widest_x, widest_y = 0.0, 0.0
    for row in range(nodes.shape[1]):
        y = row * rays.step_px + rays.pixel_offset
        for column in range(nodes.shape[2]):
            x = column * rays.step_px + rays.pixel_offset
            depth, ex, ey = nodes[SURFACE_DEPTH, row, column], nodes[ALONG_X, row, column], nodes[ALONG_Y, row, column]
            dx, dy, _ = _ray(rays.matrix, x, y)
            place_x, place_y = rays.position_m[0] + depth * dx, rays.position_m[1] + depth * dy
            is_in = water.low_m[0] < place_x < water.high_m[0] and water.low_m[1] < place_y < water.high_m[1]
            if depth >= FARTHEST_M or not is_in:
                continue
            share = 1.0 - depth / _floor_depth(rays, x, y, depth, ex, ey)
            shown_x, shown_y = x + share * ex, y + share * ey
            widest_x = max(widest_x, -shown_x, shown_x - width)
            widest_y = max(widest_y, -shown_y, shown_y - height)
    return widest_x, widest_y


@njit(cache=True, error_model="numpy")
def _exact_ray(
    water: Water,
    waves: Waves,
    time_s: float,
    origin: NDArray[np.float64],
    matrix: NDArray[np.float64],
    projection: NDArray[np.float64],
    x: float,
    y: float,
) -> tuple[float, float, float]:
    """Return z_s and e of one pixel, of the sum of waves itself; NaN where the ray misses the water."""
    dx, dy, dz = _ray(matrix, x, y)
    if not dz < _STEEPEST:
        return np.nan, np.nan, np.nan
    height, slope_x, slope_y, depth = 0.0, 0.0, 0.0, 0.0
    for _ in range(5):
        depth = (water.level_m + height - origin[2]) / dz
        height, slope_x, slope_y = sum_waves(waves, time_s, origin[0] + depth * dx, origin[1] + depth * dy)
    tx, ty, tz, _, _ = _bend(dx, dy, dz, slope_x, slope_y, water.refractive_index)
    vx, vy = _vanishing(projection, tx, ty, tz)
    return depth, vx - x, vy - y


@njit(cache=True, error_model="numpy")
def find_entries(
    water: Water,
    waves: Waves,
    time_s: float,
    origin: NDArray[np.float64],
    matrix: NDArray[np.float64],
    projection: NDArray[np.float64],
    depth_m: NDArray[np.float64],
    pixels: NDArray[np.float64],
) -> None:
    """Replace the pixels (N, 2) at which the inner renderer draws points at depths (N,) by those at which they are seen.

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
                # The inverse Jacobian (a b; c d) is changed by the least that explains the last step (Sherman-Morrison).
                sx, sy, gx, gy = x - x_before, y - y_before, fx - fx_before, fy - fy_before
                ux, uy = a * gx + b * gy, c * gx + d * gy
                scale = 1.0 / (sx * ux + sy * uy)
                rx, ry = (sx - ux) * scale, (sy - uy) * scale
                lx, ly = sx * a + sy * c, sx * b + sy * d
                a, b, c, d = a + rx * lx, b + rx * ly, c + ry * lx, d + ry * ly
            x_before, y_before, fx_before, fy_before = x, y, fx, fy
            x, y = x - (a * fx + b * fy), y - (c * fx + d * fy)
        pixels[n, 0], pixels[n, 1] = (x, y) if found else (np.nan, np.nan)


@njit(cache=True, inline="always", error_model="numpy")
def _node_value(nodes: NDArray[np.float32], plane: int, step: int, row: int, column: int) -> float:
    i, j = min(row // step, nodes.shape[1] - 2), min(column // step, nodes.shape[2] - 2)
    t, s = (row - i * step) / step, (column - j * step) / step
    upper = nodes[plane, i, j] + s * (nodes[plane, i, j + 1] - nodes[plane, i, j])
    lower = nodes[plane, i + 1, j] + s * (nodes[plane, i + 1, j + 1] - nodes[plane, i + 1, j])
    return upper + t * (lower - upper)


@njit(cache=True, error_model="numpy")
def warp(rays: WaterRays, inner: GBuffer, margin_x: int, margin_y: int, seen: GBuffer) -> None:
    """Write what is seen through the water of a G-buffer that is wider and higher by margins on each side."""
    water, offset = rays.water, rays.pixel_offset
    for row in range(seen.depth_m.shape[0]):
        for column in range(seen.depth_m.shape[1]):
            i, j = row + margin_y, column + margin_x
            z = _node_value(rays.nodes, SURFACE_DEPTH, rays.step_px, row, column)
            x, y = column + offset, row + offset
            dx, dy, _ = _ray(rays.matrix, x, y)
            place_x, place_y = rays.position_m[0] + z * dx, rays.position_m[1] + z * dy
            is_in = water.low_m[0] < place_x < water.high_m[0] and water.low_m[1] < place_y < water.high_m[1]
            if not (is_in and inner.depth_m[i, j] > z):
                seen.base_colour_rgb[row, column] = inner.base_colour_rgb[i, j]
                seen.normal_world[row, column] = inner.normal_world[i, j]
                seen.depth_m[row, column], seen.instance_id[row, column] = inner.depth_m[i, j], inner.instance_id[i, j]
                continue
            ex = _node_value(rays.nodes, ALONG_X, rays.step_px, row, column)
            ey = _node_value(rays.nodes, ALONG_Y, rays.step_px, row, column)
            last = 1.0 - z / _floor_depth(rays, x, y, z, ex, ey)
            i, j, share = _march(inner.depth_m, i, j, z, ex, ey, last)
            seen.depth_m[row, column], seen.instance_id[row, column] = inner.depth_m[i, j], inner.instance_id[i, j]
            seen.normal_world[row, column] = inner.normal_world[i, j]
            seen.base_colour_rgb[row, column] = inner.base_colour_rgb[i, j]


@njit(cache=True, error_model="numpy")
def _march(
    depth_m: NDArray[np.float32], i: int, j: int, z: float, ex: float, ey: float, last: float
) -> tuple[int, int, float]:
    """Return the inner pixel (row, column) that shows what a bent ray meets first, and the share ``1 - z_s / w``.

    Args:
        i, j: the inner pixel of the straight ray.
        last: share at the floor.
    """
    steps = min(int(np.sqrt(ex * ex + ey * ey) * last / _STEP_PX) + 2, _MOST_STEPS)
    front_i, front_j, front = i, j, 0.0
    for k in range(1, steps + 2):
        share = k * last / steps
        there_i, there_j = _pixel(depth_m, i + share * ey, j + share * ex)
        shown = 1.0 - z / depth_m[there_i, there_j]
        if shown > share:
            front_i, front_j, front = there_i, there_j, share
        elif shown >= front:
            exact_i, exact_j = _pixel(depth_m, i + shown * ey, j + shown * ex)
            again = 1.0 - z / depth_m[exact_i, exact_j]
            if abs(again - shown) * last <= 0.25 * last * last:
                return exact_i, exact_j, again
            return there_i, there_j, shown
    return front_i, front_j, 1.0 - z / depth_m[front_i, front_j]


@njit(cache=True, inline="always")
def _pixel(depth_m: NDArray[np.float32], row: float, column: float) -> tuple[int, int]:
    i = min(max(int(np.floor(row + 0.5)), 0), depth_m.shape[0] - 1)
    j = min(max(int(np.floor(column + 0.5)), 0), depth_m.shape[1] - 1)
    return i, j
