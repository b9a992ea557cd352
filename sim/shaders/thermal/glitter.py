"""The sun's glitter on the sea, in the thermal band (Cox and Munk, "Measurement of the roughness of the sea surface",
Journal of the Optical Society of America 44, 1954).

A facet mirrors the sun to the camera if its normal lies halfway between the two. Of water whose fine slopes are
normally distributed about those of the waves that are seen, with the deviation sigma,

    L = rho E p(s) / (4 sin(grazing) cos(tilt)^4),   p = exp(-|s - s_seen|² / (2 sigma²)) / (2 pi sigma²)

E is the irradiance by the sun of a surface that faces it, rho the reflectance at half the angle between sun and camera.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.constants import Boltzmann, Planck, speed_of_light

from sim.render.compilation import row_kernel
from sim.thermal.radiance import BAND_M
from sim.thermal.sky import Air, air_mass
from sim.thermal.water import reflectance

_SUN_K, _SUN_SR = 5772.0, 6.8e-5
_ONE, _ZERO, _HALF, _TWO = np.float32(1.0), np.float32(0.0), np.float32(0.5), np.float32(2.0)
_CELLS = 257
_REFLECTED = reflectance(np.linspace(0.0, 1.0, _CELLS)).astype(np.float32)
_LAST_CELL = np.float32(_CELLS - 1)
_FARTHEST = np.float32(4.0)
"""Deviations beyond which there is no glitter."""
_STEEPEST = np.float32(0.6)


class GlitterArrays(NamedTuple):
    """The sun, for kernels, float32.

    Attributes:
        towards: (3,) unit vector.
        irradiance: in the band, W/m², 0 for no sun.
        reflected: reflectance of water by the cosine of the angle of incidence, from 0 to 1.
    """

    towards: NDArray[np.float32]
    irradiance: np.float32
    reflected: NDArray[np.float32]


NO_GLITTER = GlitterArrays(np.zeros(3, np.float32), _ZERO, _REFLECTED)


def _outside_air_wm2() -> float:
    """Return the sun's irradiance in the band above the air: Planck's law, summed."""
    wavelength_m = np.linspace(*BAND_M, 601)
    photon = Planck * speed_of_light / (wavelength_m * Boltzmann * _SUN_K)
    spectral = 2.0 * Planck * speed_of_light**2 / wavelength_m**5 / np.expm1(photon)
    return float(_SUN_SR * np.trapezoid(spectral, wavelength_m))


_OUTSIDE_AIR_WM2 = _outside_air_wm2()


def glitter_arrays(towards_sun: NDArray[np.float32], air: Air) -> GlitterArrays:
    """Return the sun (3,) through gaps between clouds and through the clear air, which absorbs as much as it emits."""
    if towards_sun[2] <= 0.0:
        return NO_GLITTER
    passed = (1.0 - air.cloud) * (1.0 - air.zenith_emissivity) ** float(air_mass(towards_sun[2]))
    return GlitterArrays(towards_sun, np.float32(passed * _OUTSIDE_AIR_WM2), _REFLECTED)


@row_kernel(error_model="numpy")
def may_glitter(
    sun: GlitterArrays, along_x: np.float32, along_y: np.float32, sine: np.float32, fine_slope: np.float32
) -> bool:
    """Return whether water seen at a grazing angle along the level direction (x, y) may mirror the sun."""
    if sun.irradiance == _ZERO:
        return False
    cosine = np.sqrt(_ONE - sine * sine)
    nx, ny, nz = sun.towards[0] - cosine * along_x, sun.towards[1] - cosine * along_y, sun.towards[2] + sine
    return abs(nx * along_y - ny * along_x) < (_FARTHEST * fine_slope + _STEEPEST * _HALF) * nz


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def glitter(
    sun: GlitterArrays,
    along_x: np.float32,
    along_y: np.float32,
    sine: np.float32,
    slope_along: np.float32,
    slope_across: np.float32,
    fine_slope: np.float32,
) -> np.float32:
    """Return the radiance that glitter adds.

    Args:
        along_x, along_y: level direction of sight, a unit vector.
        sine: of the grazing angle.
        slope_along, slope_across: of the waves that are seen; across is to the left of the sight.
        fine_slope: sigma.
    """
    cosine = np.sqrt(max(_ONE - sine * sine, _ZERO))
    nx, ny, nz = sun.towards[0] - cosine * along_x, sun.towards[1] - cosine * along_y, sun.towards[2] + sine
    away_along = -(nx * along_x + ny * along_y) / nz - slope_along
    away_across = -(ny * along_x - nx * along_y) / nz - slope_across
    spread = _TWO * fine_slope * fine_slope
    square = (away_along * away_along + away_across * away_across) / spread
    if square > _HALF * _FARTHEST * _FARTHEST:
        return _ZERO
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    share = sun.reflected[np.uint32(_HALF * length * _LAST_CELL)]
    tilt = nz / length
    density = np.exp(-square) / (np.float32(np.pi) * spread)
    return share * sun.irradiance * density / (np.float32(4.0) * max(sine, np.float32(0.02)) * tilt**4)
