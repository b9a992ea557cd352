"""Radiance in the band of thermal cameras, 8 to 14 µm: of black bodies, air and sky, and what water reflects.

Planck's law integrated from wavelength 0 to l is, with ``x = c2 / (l T)``,

    L(0 … l, T) = 2 k⁴ T⁴ / (h³ c²) * sum_n exp(-n x) (x³ / n + 3 x² / n² + 6 x / n³ + 6 / n⁴)

(Chang and Rhee, "Blackbody radiation functions", 1984); the band is the difference of two such integrals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.constants import Boltzmann, Planck, speed_of_light

from sim.checks import check, check_types, check_within

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


@dataclass(frozen=True, slots=True)
class Air:
    """Air and sky in the band of 8 to 14 µm.

    Attributes:
        temperature_k: of the air near the ground.
        attenuation_per_m: share of radiance lost a metre; lost radiance is replaced by that of the air (Beer's law).
        zenith_emissivity: of the clear sky overhead, 0 to 1.
        cloud: share of the sky that is covered, 0 to 1.
        cloud_k: temperature of the clouds' base.
    """

    temperature_k: float = 288.0
    attenuation_per_m: float = 2.5e-4
    zenith_emissivity: float = 0.35
    cloud: float = 0.0
    cloud_k: float = 278.0

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "temperature_k cloud_k", 180, 340)
        check_within(self, "attenuation_per_m", 0, 1)
        check_within(self, "zenith_emissivity cloud", 0, 1)


def sky_radiance(air: Air, sine: ArrayLike) -> NDArray[np.float64]:
    """Return the radiance (...) of the sky, W/(m² sr).

    A clear sky emits like a layer of air: ``1 - (1 - e_zenith)^m`` with the relative air mass m of Kasten and Young
    (1989), so it is cold overhead and as warm as the air at the horizon. Clouds are black.

    Args:
        sine: (...) of the elevation; below the horizon it counts as 0.
    """
    mass = air_mass(sine)
    clear = (1.0 - (1.0 - air.zenith_emissivity) ** mass) * band_radiance(air.temperature_k)
    return np.asarray((1.0 - air.cloud) * clear + air.cloud * band_radiance(air.cloud_k))


def air_mass(sine: ArrayLike) -> NDArray[np.float64]:
    """Return the relative air mass (...), 1 overhead and 38 at the horizon (Kasten and Young 1989)."""
    upward = np.clip(np.asarray(sine, dtype=float), 0.0, 1.0)
    elevation_deg = np.degrees(np.arcsin(upward))
    return np.asarray(1.0 / (upward + 0.50572 * (elevation_deg + 6.07995) ** -1.6364))


WAVELENGTH_M = 1e-6 * np.arange(8.0, 14.5)
REFRACTIVE_INDEX = np.array([1.291, 1.262, 1.218, 1.153, 1.111, 1.146, 1.210])
EXTINCTION_INDEX = np.array([0.0343, 0.0399, 0.0508, 0.0968, 0.199, 0.305, 0.370])
"""At ``WAVELENGTH_M``, 25 °C: Hale and Querry, "Optical constants of water in the 200 nm to 200 µm wavelength region",
Applied Optics 12 (1973)."""

# Half an interval at the ends; a black body of 288 K is nearly as bright at all wavelengths of the band.
_WEIGHTS = np.array([0.5, 1, 1, 1, 1, 1, 0.5]) / 6.0


def reflectance(cosine: ArrayLike) -> NDArray[np.float64]:
    """Return the share of unpolarised light in the band that a smooth water surface reflects.

    With the complex index m: ``r_s = (c - q) / (c + q)``, ``r_p = (m² c - q) / (m² c + q)``, ``q² = m² - 1 + c²``; the
    share is the mean of ``|r_s|²`` and ``|r_p|²``.

    Args:
        cosine: (...) of the angle of incidence, in [0, 1].
    """
    return np.asarray(spectral_reflectance(cosine) @ _WEIGHTS)


def spectral_reflectance(cosine: ArrayLike) -> NDArray[np.float64]:
    """Return ``reflectance`` at each of ``WAVELENGTH_M`` (..., 7)."""
    c = np.asarray(cosine, dtype=float)[..., None]
    square = (REFRACTIVE_INDEX + 1j * EXTINCTION_INDEX) ** 2
    q = np.sqrt(square - 1.0 + c**2)
    r_s, r_p = (c - q) / (c + q), (square * c - q) / (square * c + q)
    return 0.5 * (np.abs(r_s) ** 2 + np.abs(r_p) ** 2)
