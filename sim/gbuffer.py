"""Visible surfaces of a view, from geometry alone, without light."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SKY = -1
"""Instance id of a pixel that shows no body."""


class GBuffer(NamedTuple):
    """Visible surface of each pixel; both renderers return this.

    Attributes:
        base_colour_rgb: (H, W, 3) uint8, unlit surface colour (sRGB encoded); 0 where there is no body.
        depth_m: (H, W) float32, z in the camera frame; inf where there is no body.
        instance_id: (H, W) int32, index into ``World.bodies``; ``SKY`` where there is no body.
        normal_world: (H, W, 3) float32 unit vectors; 0 where there is no body.
    """

    base_colour_rgb: NDArray[np.uint8]
    depth_m: NDArray[np.float32]
    instance_id: NDArray[np.int32]
    normal_world: NDArray[np.float32]
