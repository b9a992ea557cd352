"""Truth of a road town, in addition to the fields of every scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.semantics import CLASSES
from scenarios.truth import Truth, truth_field


@dataclass(frozen=True, slots=True)
class Light:
    """The light of one instant.

    Attributes:
        sun_direction: (3,) unit vector from the scene towards the sun, world frame.
        sun_illuminance_lx, sky_illuminance_lx: on a surface square to the sun, and from the sky on the ground.
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
        flow_px: (H, W, 2) float32, each pixel's surface point in the *previous* frame minus its current place (in
            closed loop the next camera pose is not known yet); NaN for sky; zeros on frame 0.
        semantic_map: (H, W) uint8, class of the surface seen, an index of ``semantics.CLASSES``.
        background_motion: (3, 3) homography of ground pixels (z = 0) from the previous frame to this one; identity on
            frame 0.
        light: the light.
        weather: ``clear``, ``overcast``, ``rain``, ``fog`` or ``snow``. season: ``summer`` …
        visibility_m: meteorological visibility. rain_mm_h: rate of rain. snow_cover: amount of snow on the ground.
        street_lamps_on, headlights_on: whether they burn.
    """

    passing: ClassVar[tuple[str, ...]] = ("person", "cyclist")

    on_road: bool = truth_field("1")
    turning: bool = truth_field("1")
    flow_px: NDArray[np.float32] = truth_field("px", "H", "W", 2, coding="x, y; NaN for sky", left_out=True)
    background_motion: NDArray[np.float64] = truth_field("px", 3, 3)
    light: Light = truth_field("lx")
    semantic_map: NDArray[np.uint8] = truth_field(
        "class", "H", "W", coding=", ".join(CLASSES), left_out=True, unjudged=np.empty((0, 0), np.uint8)
    )
    weather: str = truth_field("word", coding="clear, overcast, rain, fog or snow", unjudged="clear")
    season: str = truth_field("word", coding="summer, autumn, winter or spring", unjudged="summer")
    visibility_m: float = truth_field("m", coding="infinite in clear air", unjudged=math.inf)
    rain_mm_h: float = truth_field("mm/h", unjudged=0.0)
    snow_cover: float = truth_field("fraction", unjudged=0.0)
    street_lamps_on: bool = truth_field("1", unjudged=False)
    headlights_on: bool = truth_field("1", unjudged=False)
