"""Truth above a tank of fish, in addition to the fields of every scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from scenarios.truth import Keypoints, Truth, truth_field
from sim.motion.swim import CENTRE_LINE_POINTS

FISH = Keypoints(
    names=("snout", *(f"body-{k}" for k in range(1, CENTRE_LINE_POINTS - 1)), "tail"),
    links=tuple((k, k + 1) for k in range(CENTRE_LINE_POINTS - 1)),
    sigmas=(0.05,) * CENTRE_LINE_POINTS,
    flesh=(0.2,) * CENTRE_LINE_POINTS,
    place_m="centre_line_m",
    place_px="centre_line_px",
)
"""Points at equal distances from snout to the end of the tail fin; the spreads are our own choice."""


@dataclass(frozen=True, slots=True)
class FishTruth(Truth):
    """Truth of one frame above a tank. All pixels are those where the light arrives, after refraction.

    Attributes:
        centre_line_m: (N, K, 3) points at equal distances along each body, from head to tail; centre_line_px: (N, K, 2)
            the same in the picture.
        heading_rad: (N,) direction of the front half of the body in the picture, from +x towards +y.
        below_surface_m: (N,) depth of the body's middle under the level of the water.
        hidden_by: (N,) index of the fish that hides most of each fish, -1 for none; with ``truth="target"`` -1 for all
            but the target.
    """

    pinhole: ClassVar[bool] = False
    keypoints: ClassVar[Mapping[str, Keypoints]] = {"fish": FISH}

    centre_line_m: NDArray[np.float64] = truth_field("m", "N", CENTRE_LINE_POINTS, 3, coding="from head to tail")
    centre_line_px: NDArray[np.float64] = truth_field("px", "N", CENTRE_LINE_POINTS, 2, coding="from head to tail")
    heading_rad: NDArray[np.float64] = truth_field("rad", "N", coding="in the picture, from +x towards +y")
    below_surface_m: NDArray[np.float64] = truth_field("m", "N")
    hidden_by: NDArray[np.int64] = truth_field("1", "N", coding="index of an object, -1 for none", left_out=True)
