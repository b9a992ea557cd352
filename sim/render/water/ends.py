"""Where the bent rays of a picture end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Endings(NamedTuple):
    """The ends of a picture's rays; all are (H, W).

    Attributes:
        column, row: float32, where in the inner picture, in pixels from the middle of the first; of rays that are not
            bent, in the straight picture.
        source: int32, number k of the inner pixel that shows the same surface, counted along rows; ``-1 - k`` for that
            of the straight picture.
        depth_m: float32, along the camera's optical axis; inf where there is no body.
    """

    column: NDArray[np.float32]
    row: NDArray[np.float32]
    source: NDArray[np.int32]
    depth_m: NDArray[np.float32]


def new_endings(height: int, width: int, depth_m: NDArray[np.float32]) -> Endings:
    """Return ends for pictures of this size, with a depth map of the caller's."""
    real = np.empty((2, height, width), np.float32)
    return Endings(real[0], real[1], np.empty((height, width), np.int32), depth_m)
