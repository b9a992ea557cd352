"""``correlation_filter``: a general tracker, which knows how its target looks and nothing else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.correlation_filter.filter import CorrelationFilter
from trackers.kernels.boxes import box_around, box_centre
from trackers.registry import NoParameters, register
from trackers.types import Estimate, Observation

_LEAST_SIDE_PX = 4.0
"""Of the box, unless the first one has a shorter side."""
_HIDDEN_BELOW = 0.3
"""Sharpness of a match below which the target is hidden, relative to the usual one."""
_LEAST_SHARPNESS = 4.0
"""Of any match, a little more than on pictures without a structure."""
_USUAL_RATE, _USUAL_FADE = 0.1, 0.98
"""How fast the usual sharpness follows that of a match, and falls on each picture on which the target is hidden."""
_SEARCH_GROWTH, _WIDEST_SEARCH = 0.1, 2.0
"""How much ``search`` grows on each picture on which the target is hidden, and how far."""


@register(
    "correlation_filter", role="baseline", summary="discriminative correlation filter, a general tracker", edition=3
)
class CorrelationFilterTracker:
    """``CorrelationFilter`` around the last place.

    Where its response has no clear peak the target is taken to be hidden: the box stays, nothing is learnt (Wang, Liu,
    Huang, Large margin object tracking with circulant feature maps, CVPR 2017, section 3.4, gates learning in this
    way), and it is looked for further and further away. The estimate is always inside the picture.
    """

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._scale, self._search = 1.0, 1.0
        self._usual = _LEAST_SHARPNESS / _HIDDEN_BELOW

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Learn the target in the box."""
        self._filter = CorrelationFilter(observation.image_rgb, box_xyxy)
        self._position_px = box_centre(box_xyxy)

    def update(self, observation: Observation) -> Estimate:
        """Return the place of the best match, and learn the target there; the last place where it is hidden."""
        size_px = self._filter.size_px
        match = self._filter.locate(observation.image_rgb, self._position_px, self._scale, self._search)
        in_view_probability = min(max(match.sharpness, 0.0) / max(self._usual, _LEAST_SHARPNESS), 1.0)
        if match.sharpness < max(_HIDDEN_BELOW * self._usual, _LEAST_SHARPNESS):
            self._usual *= _USUAL_FADE
            self._search = min(self._search + _SEARCH_GROWTH, _WIDEST_SEARCH)
        else:
            self._usual += _USUAL_RATE * (match.sharpness - self._usual)
            self._search = 1.0
            picture = np.array([observation.camera.width_px, observation.camera.height_px])
            self._position_px = np.clip(match.position_px, 0.0, picture)
            least = min(_LEAST_SIDE_PX / float(size_px.min()), 1.0)
            self._scale = float(np.clip(match.scale, least, max(float((picture / size_px).min()), least)))
            self._filter.update(observation.image_rgb, box_around(self._position_px, self._scale * size_px))
        return Estimate(
            self._position_px.copy(),
            box_around(self._position_px, self._scale * size_px),
            in_view_probability=in_view_probability,
        )
