"""A tracker that answers with masks on two of three pictures."""

from __future__ import annotations

from typing import Any

import numpy as np

from trackers.regions import Rectangle
from trackers.registry import NoParameters, register
from trackers.types import Estimate


@register("fake_masked", role="baseline", summary="where the target was at first")
class FakeMasked:
    """See ``trackers.protocols.Tracker``."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._pictures = 0

    def initialise(self, observation: Any, box_xyxy: Any) -> None:
        """See ``Tracker``."""
        self._box_xyxy = np.array(box_xyxy)

    def update(self, observation: Any) -> Estimate:
        """See ``Tracker``."""
        self._pictures += 1
        middle = 0.5 * (self._box_xyxy[:2] + self._box_xyxy[2:])
        mask = Rectangle(self._box_xyxy).mask(*observation.image_rgb.shape[:2])
        return Estimate(middle, mask=mask if self._pictures % 3 else None)
