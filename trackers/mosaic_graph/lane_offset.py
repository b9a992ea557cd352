"""Side of the street on which cars drive, and how far from its centre line: learnt online."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.kernels.crossing import CUT_M
from trackers.mosaic_graph.kernels.road_position import offset_to_right
from trackers.mosaic_graph.kernels.roads import Roads

_LANE_WIDTH_M = 3.25
"""Lanes of streets are 3.0 to 3.5 m wide (AASHTO, Policy on Geometric Design, 2011: 10 to 12 ft)."""
_SIGHTING_DEVIATION_M, _MOST_SIGHTINGS = 1.5, 150.0
_LEAST_SPEED_MPS, _LEAST_COSINE = 2.0, 0.97


@dataclass
class LaneOffset:
    """Normal distribution of the lane's offset to the right of the drawn centre line, negative for left-hand traffic.

    Its prior is the centre line with a deviation of half a lane: neither side is preferred. A sighting deviates by
    1.5 m (errors of the drawn line last for several); those more than a lane from the line tell of no lane. Old
    sightings are forgotten beyond 150.

    Attributes:
        mean_m: mean.
        sightings: number of sightings that the distribution is worth, the prior included.
    """

    mean_m: float = 0.0
    sightings: float = (_SIGHTING_DEVIATION_M / (0.5 * _LANE_WIDTH_M)) ** 2

    @property
    def spread_m(self) -> float:
        """Standard deviation."""
        return float(_SIGHTING_DEVIATION_M / np.sqrt(self.sightings))

    def learn(
        self, position_m: NDArray[np.float64], velocity_mps: NDArray[np.float64], roads: Roads, share: float
    ) -> None:
        """Learn from a car that moves along a drawn street, away from crossings.

        Args:
            position_m, velocity_mps: (2,) on the map.
            share: of a sighting that it counts as, in (0, 1].
        """
        if np.hypot(*velocity_mps) < _LEAST_SPEED_MPS:
            return
        heading_rad = float(np.arctan2(velocity_mps[1], velocity_mps[0]))
        offset_m = offset_to_right(position_m[0], position_m[1], heading_rad, roads, CUT_M, _LEAST_COSINE)
        if np.isnan(offset_m) or abs(offset_m) > _LANE_WIDTH_M:
            return
        self.mean_m += share / (self.sightings + share) * (offset_m - self.mean_m)
        self.sightings = min(self.sightings + share, _MOST_SIGHTINGS)
