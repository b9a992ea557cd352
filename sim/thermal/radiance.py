"""Radiance of black bodies in the band of uncooled thermal cameras, 8 to 14 µm.

Planck's law integrated from wavelength 0 to l is, with ``x = c2 / (l T)``,

    L(0 … l, T) = 2 k⁴ T⁴ / (h³ c²) * sum_n exp(-n x) (x³ / n + 3 x² / n² + 6 x / n³ + 6 / n⁴)

(Chang and Rhee, "Blackbody radiation functions", 1984); the band is the difference of two such integrals.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.constants import Boltzmann, Planck, speed_of_light

from sim.checks import check

BAND_M = (8e-6, 14e-6)
COLDEST_K, HOTTEST_K = 120.0, 800.0
"""Range of temperatures."""
TABLE_STEP_K = 0.25

_SECOND_CONSTANT_M_K = Planck * speed_of_light / Boltzmann
_SCALE = 2.0 * Boltzmann**4 / (Planck**3 * speed_of_light**2)
_TERMS = np.arange(1.0, 25.0)
"""At 800 K and 14 µm, ``exp(-24 x)`` is below 1e-13."""


def band_radiance(temperature_k: ArrayLike) -> NDArray[np.float64]:
    """Return the radiance of black bodies (...) in the band, W/(m² sr).

    Raises:
        ValueError: for a temperature outside ``COLDEST_K`` to ``HOTTEST_K``.
    """
    kelvin = _checked(temperature_k)
    short, long = (_SECOND_CONSTANT_M_K / (edge_m * kelvin) for edge_m in BAND_M)
    return np.asarray(_SCALE * kelvin**4 * (_sum(long) - _sum(short)))


def band_slope(temperature_k: ArrayLike) -> NDArray[np.float64]:
    """Return the derivative of ``band_radiance`` by temperature (...), W/(m² sr K)."""
    kelvin = _checked(temperature_k)
    short, long = (_SECOND_CONSTANT_M_K / (edge_m * kelvin) for edge_m in BAND_M)
    moving_edges = long**4 / np.expm1(long) - short**4 / np.expm1(short)
    return np.asarray(_SCALE * kelvin**3 * (4.0 * (_sum(long) - _sum(short)) + moving_edges))


def apparent_temperature_k(radiance: ArrayLike) -> NDArray[np.float64]:
    """Return the temperature (...) of black bodies with this radiance in the band, the inverse of ``band_radiance``.

    Radiances beyond the range count as its ends. Interpolated to within 1e-3 K above 200 K.
    """
    values = np.asarray(radiance, dtype=float)
    kelvin = np.empty(values.size)
    _look_up(np.ascontiguousarray(values).ravel(), _KELVIN_BY_ROOT, kelvin)
    return kelvin.reshape(values.shape)


@njit(cache=True)
def _look_up(radiance: NDArray[np.float64], kelvin_by_root: NDArray[np.float64], kelvin: NDArray[np.float64]) -> None:
    """Interpolate in a table that is even in the fourth root of the radiance, in which temperature is nearly linear."""
    last = kelvin_by_root.shape[0] - 1
    for k in range(radiance.shape[0]):
        root = np.sqrt(np.sqrt(max(radiance[k], 0.0)))
        place = min(max((root - _LEAST_ROOT) * _PER_ROOT, 0.0), float(last))
        entry = min(int(place), last - 1)
        share = place - entry
        kelvin[k] = (1.0 - share) * kelvin_by_root[entry] + share * kelvin_by_root[entry + 1]


def _sum(x: NDArray[np.float64]) -> NDArray[np.float64]:
    n, x = _TERMS, x[..., None]
    total: NDArray[np.float64] = (np.exp(-n * x) * (x**3 / n + 3 * x**2 / n**2 + 6 * x / n**3 + 6 / n**4)).sum(-1)
    return total


def _checked(temperature_k: ArrayLike) -> NDArray[np.float64]:
    kelvin = np.asarray(temperature_k, dtype=float)
    good = bool(((kelvin >= COLDEST_K) & (kelvin <= HOTTEST_K)).all())
    check("temperature_k", good, f"numbers in [{COLDEST_K:g}, {HOTTEST_K:g}]", temperature_k)
    return kelvin


_TABLE_K = np.arange(COLDEST_K, HOTTEST_K + TABLE_STEP_K, TABLE_STEP_K)
TABLE = band_radiance(_TABLE_K)
"""``band_radiance`` at ``COLDEST_K`` + n ``TABLE_STEP_K``."""
_LEAST_ROOT, _LARGEST_ROOT, _ROOTS = float(TABLE[0]) ** 0.25, float(TABLE[-1]) ** 0.25, 4096
_PER_ROOT = (_ROOTS - 1) / (_LARGEST_ROOT - _LEAST_ROOT)
_KELVIN_BY_ROOT = np.interp(np.linspace(_LEAST_ROOT, _LARGEST_ROOT, _ROOTS) ** 4, TABLE, _TABLE_K)
