"""One scale for all tanks: that of the simulated tank in the overview's picture, which methods have parameters for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.checks import check

TANK_PX = 600.0
"""Length of the simulated tank."""


def scaled_to_tank(position: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places (T, N, 2) of any unit in pixels, scaled so that the box of all is as wide as the tank is long.

    Raises:
        ValueError: for places that do not differ in x.
    """
    width = float(np.nanmax(position[..., 0]) - np.nanmin(position[..., 0]))
    check("position", width > 0.0, "places that differ in x", f"a width of {width:g}")
    return position * (TANK_PX / width)
