"""``mosaic_graph_pf``, our own: particles on a map where the camera's pose is measured, else in the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size
from trackers.mosaic_graph.map_tracker import MapTracker
from trackers.mosaic_graph.parameters import MosaicGraphParameters
from trackers.mosaic_graph.picture_tracker import PictureTracker
from trackers.mosaic_graph.registration import shows_ground
from trackers.mosaic_graph.road_network import ColourRoads
from trackers.registry import register, register_variant
from trackers.types import Estimate, Observation


@register(
    "mosaic_graph_pf",
    role="ours",
    summary="particles on a map of the ground and its roads; without a measured pose in the picture, with a filter",
    edition=2,
)
class MosaicGraphParticleFilter:
    """Tracks a target, in view or not, by one belief about where it may be: particles.

    The first observation decides what they move on. With a measured pose (``Observation.ego``) that shows ground at the
    target they move in metres, on a map and its roads: ``MapTracker``, for cars. Without one there is no scale, and
    often no ground: they move in the picture, which the motion of the background carries along, in sizes of the target:
    ``PictureTracker``, for a target of any kind.
    """

    Parameters = MosaicGraphParameters

    def __init__(self, parameters: MosaicGraphParameters, rng: np.random.Generator) -> None:
        self._parameters, self._rng = parameters, rng

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the target in a box (4,)."""
        parameters = self._parameters
        box_size(box_xyxy)
        is_posed = parameters.use_ego and shows_ground(observation, box_centre(box_xyxy))
        self._tracker: MapTracker | PictureTracker
        if is_posed or not parameters.use_filter:
            self._tracker = MapTracker(parameters, self._rng, observation, box_xyxy, ColourRoads())
        else:
            self._tracker = PictureTracker(parameters, self._rng, observation, box_xyxy)

    def update(self, observation: Observation) -> Estimate:
        """Take in the next picture."""
        return self._tracker.update(observation)


_ABLATIONS = (
    ("no_negative", "ours, without negative information", {"use_negative_information": False}),
    ("no_mosaic", "ours, registered from frame to frame only", {"use_mosaic": False}),
    ("no_roads", "ours, without a road graph", {"use_roads": False}),
    ("no_redetection", "ours, detection only at the particles", {"use_redetection": False}),
    ("no_ego", "ours, without measured ego motion: in the picture", {"use_ego": False}),
    ("no_filter", "ours, without that and without the filter: on a map", {"use_ego": False, "use_filter": False}),
)
for _name, _summary, _overrides in _ABLATIONS:
    register_variant(f"mosaic_graph_pf_{_name}", "mosaic_graph_pf", summary=_summary, **_overrides)
