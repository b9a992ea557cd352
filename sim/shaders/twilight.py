"""Light of the sun and the sky by the height of the sun, from noon to night, and by cloud.

Total illuminance of level ground under a clear sky, by Janiczek and DeYoung, *Computer programs for sun and moon
illuminance* (US Naval Observatory Circular 171, 1987), with x the sun's elevation over 90°:

    log10 E = l0 + l1 x + l2 x² + l3 x³,   E in lux
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

SUN_LX, SKY_LX = 90_000.0, 18_000.0
"""Of a sun of ``FULL_FROM_DEG`` or more: on a surface square to it, and of the sky on level ground."""
FULL_FROM_DEG = 12.0
NIGHT_LX = 0.1
"""Of a night's sky over a town: its own glow, and some moon (Kyba et al. 2011 measured up to 0.1 lx of glow alone)."""
_CURVE = (
    # lowest elevation in degrees, l0 to l3
    (20.0, (3.74, 3.97, -4.07, 1.47)),
    (5.0, (3.05, 13.28, -45.98, 64.33)),
    (-0.8, (2.88, 22.26, -207.64, 1034.30)),
    (-5.0, (2.88, 21.81, -258.11, -858.36)),
    (-12.0, (2.70, 12.17, -431.69, -1899.83)),
    (-18.0, (13.84, 262.72, 1447.42, 2797.93)),
)
_EXTINCTION = 0.21
"""Of a clear sky, for each air mass (Illuminating Engineering Society, RP-21, 1984)."""

Cloud = Literal["none", "stratocumulus", "stratus", "nimbostratus"]
CLOUD_TRANSMITTANCE: dict[Cloud, float] = {"none": 1.0, "stratocumulus": 0.25, "stratus": 0.18, "nimbostratus": 0.16}
"""Share of the light of a clear sky below a closed cover (Kasten and Czeplak 1980)."""

LAMPS_BELOW_LX = 35.0
"""Street lamps burn below it: photocells of practice switch at 35 to 70 lx."""
HEADLIGHTS_BELOW_LX = 1000.0
"""Dipped beams go on below it by themselves (UN Regulation 48, Annex 12)."""


def clear_sky_lx(elevation_deg: float) -> float:
    """Return the illuminance of level ground under a clear sky without a moon, lux; 10^-3.2 below -18°."""
    h = min(max(elevation_deg, -18.0), 90.0)
    coefficients = next(found for low, found in _CURVE if h >= low)
    return float(10.0 ** np.polynomial.polynomial.polyval(h / 90.0, coefficients))


def sun_and_sky_lx(elevation_deg: float, cloud: Cloud = "none") -> tuple[float, float]:
    """Return the illuminances of the sun, on a surface square to it, and of the sky on level ground, lux.

    Above ``FULL_FROM_DEG`` they are constant. Towards the horizon the sun falls with the air mass m (Kasten and Young
    1989) as ``exp(-0.21 m)`` and the sky, evenly in its logarithm, to what the curve says of 0°; below it follows the
    curve down to ``NIGHT_LX``. Clouds hide the sun and leave a share of all light.
    """
    full = min(elevation_deg / FULL_FROM_DEG, 1.0)
    sun_lx, sky_lx = 0.0, clear_sky_lx(elevation_deg)
    if elevation_deg > 0.0:
        beyond = _air_mass(elevation_deg) - _air_mass(FULL_FROM_DEG)
        sun_lx = SUN_LX * math.exp(-_EXTINCTION * max(beyond, 0.0))
        sky_lx = clear_sky_lx(0.0) ** (1.0 - full) * SKY_LX**full
    if cloud != "none":
        level_lx = sun_lx * math.sin(math.radians(max(elevation_deg, 0.0))) + sky_lx
        sun_lx, sky_lx = 0.0, CLOUD_TRANSMITTANCE[cloud] * level_lx
    return sun_lx, sky_lx + (NIGHT_LX if elevation_deg <= 0.0 else 0.0)


def _air_mass(elevation_deg: float) -> float:
    h = max(elevation_deg, 0.0)
    return float(1.0 / (math.sin(math.radians(h)) + 0.50572 * (h + 6.07995) ** -1.6364))
