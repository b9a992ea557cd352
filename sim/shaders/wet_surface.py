"""Wet surfaces: darker, and mirrors.

A film of water of refractive index n on a diffuse surface of reflectance rho (Lekner and Dorf, *Why some things are
darker when wet*, Applied Optics 27, 1988, after Angstrom 1925): of the light that enters, a share p is thrown back at
the film's upper side each time that it would leave,

    rho_wet = (1 - R) (1 - p) rho / (1 - p rho),   p = 1 - (1 - R) / n²

with R the share of diffuse light that the film reflects without letting it in. Beside that the film mirrors, by
Fresnel's law as Schlick (1994) has it: ``F = F0 + (1 - F0) (1 - cos)^5``, F0 = ((n - 1) / (n + 1))².
"""

from __future__ import annotations

import numpy as np

from sim.render.compilation import row_kernel

WATER_INDEX = 1.333
FILM_REFLECTANCE = 0.066
"""R: of diffuse light that falls on water (Ryde 1931)."""
THROWN_BACK = 1.0 - (1.0 - FILM_REFLECTANCE) / WATER_INDEX**2
HEAD_ON = ((WATER_INDEX - 1.0) / (WATER_INDEX + 1.0)) ** 2

_LET_THROUGH = np.float32((1.0 - FILM_REFLECTANCE) * (1.0 - THROWN_BACK))
_BACK, _F0, _ONE = np.float32(THROWN_BACK), np.float32(HEAD_ON), np.float32(1.0)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def wet_reflectance(rho: np.float32, wetness: np.float32) -> np.float32:
    """Return the diffuse reflectance of a surface of which the share ``wetness`` is under water."""
    return rho * (_ONE + wetness * (_LET_THROUGH / (_ONE - _BACK * rho) - _ONE))


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def mirrored_share(cosine: np.float32) -> np.float32:
    """Return the share F of light mirrored where rays and normal enclose an angle of this cosine."""
    away = _ONE - min(max(cosine, np.float32(0.0)), _ONE)
    squared = away * away
    return _F0 + (_ONE - _F0) * squared * squared * away
