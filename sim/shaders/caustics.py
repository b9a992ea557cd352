"""Light on the floor of a rippled water: caustics and the shadows of bodies that move in it.

Rays that fall straight on the surface are bent and counted where they reach the floor: the count, relative to that of a
level surface, is the caustic of a lamp straight above and far away, and its mean is 1. A lamp aside shifts it, and the
lamp's size blurs it, as Gaussian as the lamp is wide. So does it with shadows of bodies, sums of ellipses of optical
thickness ``t`` that leave ``exp(-t)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import announce_compilation
from sim.water_surface import RippledSurface, SurfaceGrid
from sim.world import World

_OUTERMOST = 8.0
"""Square of the distance, in standard deviations, at which an ellipse's thickness ends."""
_THINNEST = 0.02
"""Optical thickness of an ellipse below which it is left out."""


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def light_floor(
    grid: SurfaceGrid,
    index: float,
    floor: NDArray[np.float64],
    step_m: float,
    lights: NDArray[np.float64],
    poses: NDArray[np.float64],
    owner: NDArray[np.int64],
    ellipsoids: NDArray[np.float64],
    scratch: NDArray[np.float32],
    maps: NDArray[np.float32],
) -> None:
    """Write the maps, see ``sim.shaders.caustics.FloorLight.maps``.

    Args:
        floor: (4,) x and y of the first cell, height of the floor, depth of the water.
        lights: (L, 5) share of the light, run and spread.
        ellipsoids: (N, 2, 3) middles and standard deviations, in the frames of bodies ``owner`` (N,).
    """
    count, aside, thickness = scratch[0], scratch[1], scratch[2]
    count_rays(grid, index, floor, step_m, count)
    maps[:] = np.float32(0.0)
    for n in range(lights.shape[0]):
        light = lights[n]
        share = np.float32(light[0])
        if share == np.float32(0.0):
            continue
        _blur_and_shift(count, light, floor[3], step_m, thickness, aside)
        thickness[:] = np.float32(0.0)
        for k in range(owner.shape[0]):
            _add_ellipse(poses[owner[k]], ellipsoids[k], light, floor, step_m, thickness)
        for row in range(count.shape[0]):
            shadowed, plain, caustic, t = maps[0, row], maps[1, row], aside[row], thickness[row]
            for column in range(count.shape[1]):
                lit = share * caustic[column]
                shadowed[column] += lit * exp_minus(t[column])
                plain[column] += lit


@njit(cache=True, inline="always", fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def exp_minus(x: np.float32) -> np.float32:
    """Return exp(-x) for x >= 0, in vector code: by the 32nd power of a cubic, right to 1e-3 of it up to 5."""
    t = min(x, np.float32(60.0)) * np.float32(1.0 / 32.0)
    p = np.float32(1.0) + t * (np.float32(1.0) + t * (np.float32(0.5) + t * np.float32(1.0 / 6.0)))
    p *= p
    p *= p
    p *= p
    p *= p
    p *= p
    return np.float32(1.0) / p


@njit(cache=True, forceinline=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def count_rays(
    grid: SurfaceGrid, index: float, floor: NDArray[np.float64], step_m: float, count: NDArray[np.float32]
) -> None:
    """Write the rays that reach each cell, in units of those of a level surface; each is shared by four cells.

    The outermost cells, of which a part gets no rays, are made equal to their neighbours.

    A ray that falls straight on slopes s runs aside by ``s a cos i / (1 / n + a cos i)`` per metre of descent, with
    ``cos i = 1 / sqrt(1 + s²)`` and ``a = cos t - cos i / n``, from Snell's law in vector form.
    """
    rows, columns = count.shape
    count[:] = np.float32(0.0)
    one, per_step, depth = np.float32(1.0), np.float32(1.0 / step_m), np.float32(floor[3])
    eta, ray = np.float32(1.0 / index), np.float32((grid.step_m / step_m) ** 2)
    x_first, y_first = np.float32(grid.first_m[0] - floor[0]), np.float32(grid.first_m[1] - floor[1])
    step = np.float32(grid.step_m)
    at_x, at_y = np.empty(grid.values.shape[2], np.float32), np.empty(grid.values.shape[2], np.float32)
    for i in range(grid.values.shape[1]):
        height, slope_x, slope_y = grid.values[0, i], grid.values[1, i], grid.values[2, i]
        y_row = y_first + step * np.float32(i)
        for j in range(at_x.shape[0]):
            sx, sy = slope_x[j], slope_y[j]
            cos_i = one / np.sqrt(one + sx * sx + sy * sy)
            along = np.sqrt(one - (one - cos_i * cos_i) * eta * eta) - cos_i * eta
            fall = (depth + height[j]) * along * cos_i / (eta + along * cos_i)
            at_x[j] = (x_first + step * np.float32(np.int32(j)) + fall * sx) * per_step
            at_y[j] = (y_row + fall * sy) * per_step
        # Not in vector code: rays of one row may share a cell.
        for j in range(at_x.shape[0]):
            x, y = at_x[j], at_y[j]
            if not (x >= np.float32(0.0) and y >= np.float32(0.0)):
                continue
            column, row = np.int32(x), np.int32(y)
            if column >= columns - 1 or row >= rows - 1:
                continue
            s, t = x - np.float32(column), y - np.float32(row)
            lower = ray * t
            upper = ray - lower
            above, below = count[row], count[row + 1]
            above[column] += upper * (one - s)
            above[column + 1] += upper * s
            below[column] += lower * (one - s)
            below[column + 1] += lower * s
    count[0], count[-1] = count[1], count[-2]
    count[:, 0], count[:, -1] = count[:, 1], count[:, -2]


@njit(cache=True, forceinline=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _blur_and_shift(
    count: NDArray[np.float32],
    light: NDArray[np.float64],
    depth_m: float,
    step_m: float,
    between: NDArray[np.float32],
    result: NDArray[np.float32],
) -> None:
    """Write the count as a lamp casts it: moved by ``run depth`` and blurred by ``spread depth``.

    Args:
        light: (5,) share, run and spread.
        between: scratch. Maps go on as mirror images beyond their borders, like light between white walls.
    """
    rows, columns = count.shape
    first, weights = _taps(light[1] * depth_m / step_m, light[3] * depth_m / step_m)
    taps = weights.shape[0]
    line = np.empty(columns + taps, np.float32)
    for row in range(rows):
        for column in range(columns + taps - 1):
            line[column] = count[row, _mirrored(column + first, columns)]
        into = between[row]
        into[:] = np.float32(0.0)
        for k in range(taps):
            weight, part = weights[k], line[k : k + columns]
            for column in range(columns):
                into[column] += weight * part[column]
    first, weights = _taps(light[2] * depth_m / step_m, light[4] * depth_m / step_m)
    for row in range(rows):
        into = result[row]
        into[:] = np.float32(0.0)
        for k in range(weights.shape[0]):
            weight, part = weights[k], between[_mirrored(row + first + k, rows)]
            for column in range(columns):
                into[column] += weight * part[column]


@njit(cache=True)
def _taps(shift: float, sigma: float) -> tuple[int, NDArray[np.float32]]:
    """Return the weights of the neighbours from number ``first`` on that shift and blur a line, in cells."""
    sigma = max(sigma, 0.4)
    reach = 3.0 * sigma
    first, last = int(np.floor(-shift - reach)), int(np.ceil(-shift + reach))
    weights = np.exp(-0.5 * ((np.arange(first, last + 1) + shift) / sigma) ** 2)
    return first, (weights / weights.sum()).astype(np.float32)


@njit(cache=True, inline="always")
def _mirrored(k: int, count: int) -> int:
    k %= 2 * count
    return k if k < count else 2 * count - 1 - k


@njit(cache=True, forceinline=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _add_ellipse(
    pose: NDArray[np.float64],
    ellipsoid: NDArray[np.float64],
    light: NDArray[np.float64],
    floor: NDArray[np.float64],
    step_m: float,
    thickness: NDArray[np.float32],
) -> None:
    """Add the optical thickness of an ellipsoid's shadow on the floor.

    Its covariance is that of the ellipsoid, projected along the light, and the light's spread over the height above
    the floor. Its profile is ``(1 - m / 8)²`` of the squared Mahalanobis distance m, which has unit variance too; its
    sum is the area of the ellipse, so that a large body takes ``1 - exp(-3)`` of the light in its middle at most.
    """
    x, y, z = pose[0, 3], pose[1, 3], pose[2, 3]
    for k in range(3):
        x, y, z = (x + pose[0, k] * ellipsoid[0, k], y + pose[1, k] * ellipsoid[0, k], z + pose[2, k] * ellipsoid[0, k])
    above = z - floor[2]
    if not 0.0 < above < floor[3]:
        return
    xx, xy, yy = 0.0, 0.0, 0.0
    for k in range(3):
        along_x = (pose[0, k] + light[1] * pose[2, k]) * ellipsoid[1, k]
        along_y = (pose[1, k] + light[2] * pose[2, k]) * ellipsoid[1, k]
        xx, xy, yy = xx + along_x * along_x, xy + along_x * along_y, yy + along_y * along_y
    size = np.sqrt(max(xx * yy - xy * xy, 0.0))
    least = (0.5 * step_m) ** 2
    xx, yy = xx + (light[3] * above) ** 2 + least, yy + (light[4] * above) ** 2 + least
    determinant = xx * yy - xy * xy
    # The ellipse has the area 4 pi size, and its profile the integral 8 pi / 3 sqrt(determinant).
    peak = np.float32(1.5 * size / np.sqrt(determinant))
    if peak < _THINNEST:
        return
    x, y = (x + light[1] * above - floor[0]) / step_m, (y + light[2] * above - floor[1]) / step_m
    wide, high = np.sqrt(_OUTERMOST * xx) / step_m, np.sqrt(_OUTERMOST * yy) / step_m
    scale = step_m * step_m / (determinant * _OUTERMOST)
    a, b, c = np.float32(yy * scale), np.float32(-2.0 * xy * scale), np.float32(xx * scale)
    first, last = max(int(np.ceil(x - wide)), 0), min(int(x + wide) + 1, thickness.shape[1])
    for row in range(max(int(np.ceil(y - high)), 0), min(int(y + high) + 1, thickness.shape[0])):
        dy = np.float32(row - y)
        line = thickness[row]
        for column in range(first, last):
            dx = np.float32(np.float32(column) - np.float32(x))
            inside = max(np.float32(1.0) - (a * dx + b * dy) * dx - c * dy * dy, np.float32(0.0))
            line[column] += peak * inside * inside


@dataclass(frozen=True, slots=True)
class LightThroughSurface:
    """Light of one lamp in water at rest.

    Attributes:
        illuminance_lx: that enters.
        run: (2,) mean way of its rays along x and y per metre of descent.
        spread: (2,) standard deviation of it.
    """

    illuminance_lx: float
    run: NDArray[np.float64]
    spread: NDArray[np.float64]


class MapExtent(NamedTuple):
    """Where maps of the floor lie; all are world coordinates.

    Attributes:
        first_m: (2,) x and y of the first cell's middle; rows go along y. step_m: between cells.
        low_m, high_m: (2,) of the water.
        level_m, depth_m: of the surface at rest, and from there to the floor.
        refractive_index: of the water.
    """

    first_m: NDArray[np.float32]
    step_m: np.float32
    low_m: NDArray[np.float32]
    high_m: NDArray[np.float32]
    level_m: np.float32
    depth_m: np.float32
    refractive_index: np.float32


class FloorLight:
    """Maps of the light on the floor of one water."""

    def __init__(self, world: World, surface: RippledSurface, lights: Sequence[LightThroughSurface]) -> None:
        """Take the bodies of ``world`` that can move, now or later, as those that cast shadows."""
        self._world, self._surface = world, surface
        # Two rays to a cell along x and y: of a level surface, the same share of rays then reaches every cell.
        self._step_m = 2.0 * surface.grid().step_m
        columns, rows = (np.ceil((surface.high_m - surface.low_m) / self._step_m).astype(int) + 4).tolist()
        self._maps = np.ones((2, rows, columns), np.float32)
        self._scratch = np.empty((3, rows, columns), np.float32)
        total_lx = sum(light.illuminance_lx for light in lights) or 1.0
        self._lights = np.array([[light.illuminance_lx / total_lx, *light.run, *light.spread] for light in lights])
        self._bodies = -1
        self._owner, self._ellipsoids = np.empty(0, np.int64), np.empty((0, 2, 3))
        announce_compilation(light_floor)

    def maps(self) -> NDArray[np.float32]:
        """Return the light on the floor (2, rows, columns) float32, with and without shadows of bodies.

        It is relative to the mean without ripples and bodies, and valid until the next call.
        """
        if self._bodies != len(self._world.bodies):
            self._find_bodies()
        light_floor(
            self._surface.grid(),
            self._surface.refractive_index,
            self._floor(),
            self._step_m,
            self._lights,
            self._world.poses,
            self._owner,
            self._ellipsoids,
            self._scratch,
            self._maps,
        )
        return self._maps

    def extent(self) -> MapExtent:
        """Return where the maps lie."""
        surface = self._surface
        return MapExtent(
            self._floor()[:2].astype(np.float32),
            np.float32(self._step_m),
            surface.low_m.astype(np.float32),
            surface.high_m.astype(np.float32),
            np.float32(surface.level_m),
            np.float32(surface.depth_m),
            np.float32(surface.refractive_index),
        )

    def mean_direction(self) -> NDArray[np.float32]:
        """Return the unit vector (3,) in the water against the mean of the light."""
        share, run = self._lights[:, 0], self._lights[:, 1:3]
        against = np.array([*(-share @ run), 1.0])
        return (against / np.linalg.norm(against)).astype(np.float32)

    def _floor(self) -> NDArray[np.float64]:
        surface = self._surface
        return np.array([*(surface.low_m - 1.5 * self._step_m), surface.level_m - surface.depth_m, surface.depth_m])

    def _find_bodies(self) -> None:
        movers = [body for body in self._world.bodies if body.movable]
        low_high = [(body.mesh.vertices_m.min(axis=0), body.mesh.vertices_m.max(axis=0)) for body in movers]
        self._owner = np.array([body.index for body in movers], dtype=np.int64)
        # A quarter of the size is the standard deviation of an ellipse that fills it.
        middles = [(0.5 * (low + high), 0.25 * (high - low)) for low, high in low_high]
        self._ellipsoids = np.array(middles, dtype=float).reshape(-1, 2, 3)
        self._bodies = len(self._world.bodies)
