"""A rippled surface of water: a sum of plane waves over a rectangle.

    h(x, y, t) = sum of a_i sin(k_i . (x, y) - w_i t + phase_i)
    w² = (g k + sigma / rho k³) tanh(k depth)

the dispersion relation of gravity-capillary waves (Lamb, Hydrodynamics, 1932, article 267).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.checks import check, check_types, check_within
from sim.render.compilation import announce_compilation

_GRAVITY_MPS2 = 9.81
_TENSION_PER_DENSITY_M3PS2 = 0.0728 / 998.0
_SAMPLES_PER_WAVE = 12


@dataclass(frozen=True, slots=True)
class Ripples:
    """Statistics of ripples.

    Attributes:
        slope_rms: root mean square of the slope, in [0, 0.2]: 0.01 is a calm tank, 0.05 one with a strong filter.
        wavelengths_m: shortest and longest, in [0.01, 1].
        waves: number of waves, in [1, 64].
    """

    slope_rms: float = 0.02
    wavelengths_m: tuple[float, float] = (0.03, 0.2)
    waves: int = 16

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "slope_rms", 0.0, 0.2)
        check_within(self, "wavelengths_m", 0.01, 1.0)
        check_within(self, "waves", 1, 64)


class Waves(NamedTuple):
    """Plane waves, all arrays float64.

    Attributes:
        amplitude_m: (M,).
        vector_per_m: (M, 2), rad/m.
        frequency_per_s: (M,), rad/s.
        phase_rad: (M,).
    """

    amplitude_m: NDArray[np.float64]
    vector_per_m: NDArray[np.float64]
    frequency_per_s: NDArray[np.float64]
    phase_rad: NDArray[np.float64]


class SurfaceGrid(NamedTuple):
    """A surface at one time, at the points of a grid.

    Attributes:
        values: (3, rows, columns) float32: height above the level in metres, slope along x and along y.
        first_m: (2,) x and y of the first point; rows go along y.
        step_m: between points.
    """

    values: NDArray[np.float32]
    first_m: NDArray[np.float64]
    step_m: float


class RippledSurface:
    """The surface of water that fills a rectangle.

    Attributes:
        waves: of the surface.
        low_m, high_m: (2,) corners of the rectangle, world frame.
        level_m: height of the surface at rest, world frame.
        depth_m: of the water, > 0; its floor is level.
        refractive_index: of the water, > 1.
        time_s: set it to move on; every picture, projection and light of the surface is that of this time.
    """

    def __init__(
        self,
        waves: Waves,
        low_m: tuple[float, float],
        high_m: tuple[float, float],
        level_m: float,
        depth_m: float,
        refractive_index: float = 1.333,
    ) -> None:
        """Fill the rectangle; ``time_s`` is 0.

        Raises:
            ValueError: for an empty rectangle, no depth, or an index of 1 or less.
        """
        low, high = np.array(low_m, dtype=float), np.array(high_m, dtype=float)
        check("high_m", bool((high > low).all()), f"more than low_m = {low_m} in x and y", high_m)
        check("depth_m", depth_m > 0, "a length > 0 m", depth_m)
        check("refractive_index", refractive_index > 1, "a number > 1", refractive_index)
        self.waves, self.low_m, self.high_m = waves, low, high
        self.level_m, self.depth_m, self.refractive_index = float(level_m), float(depth_m), float(refractive_index)
        self.time_s = 0.0
        shortest_m = 2 * np.pi / float(np.sqrt((waves.vector_per_m**2).sum(axis=1)).max())
        step_m = shortest_m / _SAMPLES_PER_WAVE
        # Light from beyond the rectangle arrives on the floor of it.
        margin_m = 4 * step_m + 0.1 * depth_m
        columns, rows = (np.ceil((high - low + 2 * margin_m) / step_m).astype(int) + 1).tolist()
        self._grid = SurfaceGrid(np.empty((3, rows, columns), np.float32), low - margin_m, step_m)
        self._grid_time_s: float | None = None
        announce_compilation(_fill_grid)

    def height_and_slope(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return height above the level in metres and slopes along x and y, (N, 3), at (x, y) points (N, 2)."""
        result = np.empty((len(points_m), 3))
        for n, (x, y) in enumerate(points_m.tolist()):
            result[n] = sum_waves(self.waves, self.time_s, x, y)
        return result

    def grid(self) -> SurfaceGrid:
        """Return the surface at ``time_s``, valid until the method is called at another time.

        With twelve points to the shortest wave, linear interpolation is right to 3.4 % of that wave's part.
        """
        if self._grid_time_s != self.time_s:
            _fill_grid(self.waves, self.time_s, self._grid.first_m, self._grid.step_m, self._grid.values)
            self._grid_time_s = self.time_s
        return self._grid


def draw_waves(ripples: Ripples, depth_m: float, rng: np.random.Generator) -> Waves:
    """Return waves with the same share of the slope each, of log-uniform lengths and evenly spread directions."""
    shortest_m, longest_m = ripples.wavelengths_m
    count = ripples.waves
    share = (np.arange(count) + rng.random(count)) / count
    number_per_m = 2 * np.pi / (shortest_m * (longest_m / shortest_m) ** share)
    heading_rad = 2 * np.pi * (rng.permutation(count) + rng.random(count)) / count
    vector_per_m = number_per_m[:, None] * np.column_stack([np.cos(heading_rad), np.sin(heading_rad)])
    amplitude_m = ripples.slope_rms * np.sqrt(2.0 / count) / number_per_m
    return Waves(amplitude_m, vector_per_m, angular_frequency(number_per_m, depth_m), 2 * np.pi * rng.random(count))


def angular_frequency(number_per_m: NDArray[np.float64], depth_m: float) -> NDArray[np.float64]:
    """Return the angular frequency in rad/s of waves with these wave numbers in rad/m, see the module."""
    restoring = _GRAVITY_MPS2 * number_per_m + _TENSION_PER_DENSITY_M3PS2 * number_per_m**3
    return np.sqrt(restoring * np.tanh(number_per_m * depth_m))


@njit(cache=True)
def sum_waves(waves: Waves, time_s: float, x: float, y: float) -> tuple[float, float, float]:
    """Return height above the level, and slopes along x and y, at one point."""
    height, slope_x, slope_y = 0.0, 0.0, 0.0
    for i in range(waves.amplitude_m.shape[0]):
        kx, ky = waves.vector_per_m[i, 0], waves.vector_per_m[i, 1]
        angle = kx * x + ky * y - waves.frequency_per_s[i] * time_s + waves.phase_rad[i]
        height += waves.amplitude_m[i] * np.sin(angle)
        along = waves.amplitude_m[i] * np.cos(angle)
        slope_x += kx * along
        slope_y += ky * along
    return height, slope_x, slope_y


@njit(cache=True, fastmath={"contract"})
def _fill_grid(
    waves: Waves, time_s: float, first_m: NDArray[np.float64], step_m: float, values: NDArray[np.float32]
) -> None:
    """Write the surface at the points of a grid, see ``SurfaceGrid``.

    ``sin(p + q) = sin p cos q + cos p sin q``, where p depends on the column only and q on the row only.
    """
    rows, columns = values.shape[1], values.shape[2]
    count = waves.amplitude_m.shape[0]
    sines, cosines = np.empty((count, columns), np.float32), np.empty((count, columns), np.float32)
    values[:] = np.float32(0.0)
    for i in range(count):
        for column in range(columns):
            p = waves.vector_per_m[i, 0] * (first_m[0] + column * step_m)
            sines[i, column], cosines[i, column] = np.float32(np.sin(p)), np.float32(np.cos(p))
    for row in range(rows):
        height, slope_x, slope_y = values[0, row], values[1, row], values[2, row]
        for i in range(count):
            kx, ky, amplitude = waves.vector_per_m[i, 0], waves.vector_per_m[i, 1], waves.amplitude_m[i]
            sine, cosine = sines[i], cosines[i]
            q = ky * (first_m[1] + row * step_m) - waves.frequency_per_s[i] * time_s + waves.phase_rad[i]
            along, across = np.float32(amplitude * np.cos(q)), np.float32(amplitude * np.sin(q))
            kx_, ky_ = np.float32(kx), np.float32(ky)
            for column in range(columns):
                slope = cosine[column] * along - sine[column] * across
                height[column] += sine[column] * along + cosine[column] * across
                slope_x[column] += kx_ * slope
                slope_y[column] += ky_ * slope
