"""The air before a thermal camera, and the sky above: attenuation, and radiance by elevation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.checks import check_types, check_within
from sim.thermal.radiance import band_radiance


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
