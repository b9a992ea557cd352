"""Smooth motion that starts and ends at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

PEAK_SPEED = 1.875
"""Largest speed of a smooth step, in steps per duration."""


def smooth_step(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 0 before t = 0, 1 after t = 1 and between them ``10 t^3 - 15 t^4 + 6 t^5``, as an array like ``t``.

    Speed and acceleration are zero at both ends.
    """
    t = np.clip(t, 0.0, 1.0)
    return t * t * t * (10 - 15 * t + 6 * t * t)
