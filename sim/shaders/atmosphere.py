"""Air between the camera and what it sees: fog, rain and snow that take light away and add their own.

Koschmieder's law for a homogeneous medium, over the distance d from the camera:

    L = L0 exp(-beta d) + L_air (1 - exp(-beta d)),   beta = 3.912 / V

V is the meteorological visibility, at which a contrast of 1 is left as 0.02.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel

CONTRAST_LEFT = 3.912
"""- ln 0.02."""
THICKEST = np.float32(12.0)
"""Optical depths beyond it are taken for it: six parts in a million come through."""
ONE, HALF, THIRD = np.float32(1.0), np.float32(0.5), np.float32(1.0 / 3.0)
QUARTER, FIFTH = np.float32(0.25), np.float32(0.2)


class Air(NamedTuple):
    """Air for kernels.

    Attributes:
        beta_per_m: extinction, 0 in clear air. air_nit: (3,) float32 luminance of R, G and B of the air itself.
        ray: (3,) float32 of the camera: 1 / focal length, and the principal point in pixels, so that distances follow
            from depths.
    """

    beta_per_m: np.float32
    air_nit: NDArray[np.float32]
    ray: NDArray[np.float32]


def extinction_of_fog(visibility_m: float) -> float:
    """Return beta per metre of a visibility, 0 of an infinite one."""
    return CONTRAST_LEFT / visibility_m


def extinction_of_rain(rate_mm_h: float) -> float:
    """Return beta per metre of rain: ``0.312 R^0.67`` per km (Atlas 1953, as quoted by Ulbrich and Atlas 1985)."""
    return float(0.312e-3 * rate_mm_h**0.67)


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def transmittance_row(air: Air, row: int, depth_m: NDArray[np.float32], left: NDArray[np.float32]) -> None:
    """Write ``exp(-beta d)`` of each pixel of a row, d its distance; a millionth of the light accurate.

    ``exp(-t) = (exp(-t / 16))^16``, the inner one by its series, in vector code.
    """
    down = (np.float32(row) + HALF - air.ray[2]) * air.ray[0]
    base = ONE + down * down
    for k in range(depth_m.shape[0]):
        across = (np.float32(np.int32(k)) + HALF - air.ray[1]) * air.ray[0]
        t = min(air.beta_per_m * depth_m[k] * np.sqrt(base + across * across), THICKEST)
        s = t * np.float32(1.0 / 16.0)
        e = ONE - s * QUARTER * (ONE - s * FIFTH)
        e = ONE - s * (ONE - s * HALF * (ONE - s * THIRD * e))
        e *= e
        e *= e
        e *= e
        left[k] = e * e


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def veil_row(left: NDArray[np.float32], air_nit: np.float32, radiance: NDArray[np.float32]) -> None:
    """Turn the radiance (W,) of one channel into what arrives through the air."""
    for k in range(radiance.shape[0]):
        radiance[k] = air_nit + left[k] * (radiance[k] - air_nit)
