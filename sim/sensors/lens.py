"""The lens: scattered light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel


def veil(metered: NDArray[np.float64], share: float) -> NDArray[np.float32]:
    """Return the light (3,) that lens and housing spread evenly over a picture, given its mean radiance (3,).

    A share of all light is scattered (veiling glare, ISO 9358): ``L' = (1 - share) L + share mean(L)``, of which this
    is the last part.
    """
    return (share * metered).astype(np.float32)


@row_kernel()
def scatter_row(
    radiance: NDArray[np.float32], share: np.float32, veil: NDArray[np.float32], scattered: NDArray[np.float32]
) -> None:
    """Write ``(1 - share) L + veil`` of one row (3, W)."""
    kept = np.float32(1.0) - share
    for channel in range(3):
        line, into, more = radiance[channel], scattered[channel], veil[channel]
        for k in range(line.shape[0]):
            into[k] = kept * line[k] + more
