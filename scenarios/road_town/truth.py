"""What is really so in a road town, besides what is so everywhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.truth import Truth, told


@dataclass(frozen=True, slots=True)
class Light:
    """The light of one instant.

    Attributes:
        sun_direction: (3,) unit vector from the scene towards the sun, world frame.
        sun_illuminance_lx, sky_illuminance_lx: on a surface square to the sun, and from the sky on the
            ground.
    """

    sun_direction: NDArray[np.float64]
    sun_illuminance_lx: float
    sky_illuminance_lx: float


@dataclass(frozen=True, slots=True)
class RoadTruth(Truth):
    """Truth of one frame of a road town.

    Attributes:
        on_road: whether the target's centre is on a road.
        turning: whether the target is turning at a crossing.
        flow_px: (H, W, 2) float32, where each pixel's surface point lay in the *previous* frame minus
            where it lies now (the next camera pose is not known yet when a tracker steers); NaN for sky; zeros on
            frame 0.
        background_motion: (3, 3) homography that takes ground pixels (z = 0) of the previous frame to
            this one; identity on frame 0.
        light: the light.
    """

    on_road: bool = told("1")
    turning: bool = told("1")
    flow_px: NDArray[np.float32] = told("px", "H", "W", 2, coding="x, y; NaN for sky", left_out=True)
    background_motion: NDArray[np.float64] = told("px", 3, 3)
    light: Light = told("lx")
