"""Tables of the sea's facets.

A facet with slope s along the line of sight, seen at the grazing angle g, is seen at ``g + s`` and mirrors the sky at
the elevation ``g + 2 s``. Both are averaged over the slopes of waves that are too fine to be seen, weighted by what of
each facet faces the camera, ``1 + s / tan g``, and tabulated over ``sin g`` and s.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.thermal.radiance import band_radiance
from sim.thermal.sky import Air, sky_radiance
from sim.thermal.water import reflectance
from sim.thermal.waves import CELLS, LEVELS

SINES, SLOPES, STEEPEST = 96, 64, 0.6
"""Cells of the table, and the greatest slope in it."""
FIRST = np.cumsum([0] + [(CELLS >> level) ** 2 for level in range(LEVELS)]).astype(np.uint32)
"""First cell of each level."""
LEAST_SINE = np.float32(0.01)
_QUADRATURE = 9
_COSINES = np.linspace(0.0, 1.0, 1025)
_REFLECTED = reflectance(_COSINES)


def radiance_table(air: Air, temperature_k: float, fine_slope: float) -> NDArray[np.float32]:
    """Return ``SeaArrays.radiance``."""
    sine = np.linspace(0.0, 1.0, SINES)[:, None, None]
    slope = np.linspace(-STEEPEST, STEEPEST, SLOPES)[:, None]
    nodes, weights = np.polynomial.hermite_e.hermegauss(_QUADRATURE)
    grazing = np.arcsin(np.maximum(sine, LEAST_SINE))
    tilt = np.arctan(slope + fine_slope * nodes)
    facing = weights * np.maximum(np.sin(grazing + tilt), 1e-4) / np.cos(tilt)
    share = np.interp(np.sin(grazing + tilt), _COSINES, _REFLECTED)
    # A facet that mirrors something below the horizon mirrors more of the sea, which looks like the sky's edge.
    mirrored = sky_radiance(air, np.maximum(np.sin(grazing + 2 * tilt), 0.0))
    emitted = (1.0 - share) * band_radiance(temperature_k)
    total = facing.sum(-1)
    both = [(facing * each).sum(-1) / total for each in (emitted, share * mirrored)]
    return np.stack(both, axis=-1).reshape(-1, 2).astype(np.float32)


@njit(cache=True)
def levels_of(slopes: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return ``SeaArrays.slopes`` of the finest ones (CELLS, CELLS, 2)."""
    levels = np.empty((FIRST[-1], 2), np.float32)
    levels[: CELLS * CELLS] = slopes.reshape(-1, 2)
    for level in range(1, LEVELS):
        side, fine, own = CELLS >> level, FIRST[level - 1], FIRST[level]
        for i in range(side):
            for j in range(side):
                at = fine + 4 * i * side + 2 * j
                for c in range(2):
                    four = levels[at, c] + levels[at + 1, c] + levels[at + 2 * side, c] + levels[at + 2 * side + 1, c]
                    levels[own + i * side + j, c] = np.float32(0.25) * four
    return levels
