"""A tracker that answers with masks: the best match of the first picture of the car, and GrabCut around it.

    frameout bench frame-out --modules examples/grab_cut.py --trackers grab_cut hold --preset quick --seeds 0:2 \\
        --metric j_and_f mask_iou contour_accuracy kept_rate --out results/masks

While the car is outside nothing matches, and the answer is NaN.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from trackers.regions import Mask, estimate_of
from trackers.registry import register, tunable
from trackers.types import Estimate


@dataclass(frozen=True)
class Parameters:
    """``least_match``: correlation from which on the car is there. ``margin``: of the window, in sizes of the box."""

    least_match: float = tunable(0.6, 0.2, 0.95)
    margin: float = tunable(0.5, 0.2, 1.5)


@register("grab_cut", role="external", summary="the best match of the first picture, and GrabCut around it")
class GrabCut:
    """See ``trackers.protocols.Tracker``."""

    Parameters = Parameters

    def __init__(self, parameters, rng):
        self._parameters = parameters

    def initialise(self, observation, box_xyxy):
        height, width = observation.image_rgb.shape[:2]
        x0, y0, x1, y1 = np.clip(np.round(box_xyxy), 0, (width, height, width, height)).astype(int)
        self._template = observation.image_rgb[y0:y1, x0:x1]

    def update(self, observation):
        picture = observation.image_rgb
        scores = cv2.matchTemplate(picture, self._template, cv2.TM_CCOEFF_NORMED)
        _, best, _, corner = cv2.minMaxLoc(scores)
        if best < self._parameters.least_match:
            return Estimate(np.full(2, np.nan), in_view_probability=0.0)
        size = np.array(self._template.shape[1::-1])
        margin = np.ceil(self._parameters.margin * size).astype(int)
        low = np.maximum(np.array(corner) - margin, 0)
        high = np.minimum(np.array(corner) + size + margin, picture.shape[1::-1])
        window = np.ascontiguousarray(picture[low[1] : high[1], low[0] : high[0]])
        labels = np.zeros(window.shape[:2], np.uint8)
        cv2.setRNGSeed(0)
        cv2.grabCut(
            window, labels, (*(corner - low), *size), np.zeros((1, 65)), np.zeros((1, 65)), 3, cv2.GC_INIT_WITH_RECT
        )
        mask = np.zeros(picture.shape[:2], bool)
        mask[low[1] : high[1], low[0] : high[0]] = (labels == cv2.GC_FGD) | (labels == cv2.GC_PR_FGD)
        if not mask.any():
            mask[corner[1] : corner[1] + size[1], corner[0] : corner[0] + size[0]] = True
        return estimate_of(Mask(mask), *mask.shape)
