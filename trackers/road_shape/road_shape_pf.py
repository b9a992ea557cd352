"""The road-shape particle filter of paper A, section 3 (A.2), with measured motion."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre
from trackers.kernels.histogram import ColourTemplate, hs_bins
from trackers.particle_filter import ParticleFilter
from trackers.registry import register, tunable
from trackers.road_shape.background_motion import STILL, measured_motion
from trackers.road_shape.colour_pf import (
    HEADING,
    POSITION,
    CarModel,
    ColourParameters,
    Instant,
    car_estimate,
    image_centre,
    place_and_heading,
)
from trackers.road_shape.road_lines import RoadSearch
from trackers.road_shape.road_model import RoadCurve, RoadModel
from trackers.types import EgoPose, Estimate, Observation


@dataclass(frozen=True)
class RoadShapeParameters(ColourParameters):
    """Settings of ``road_shape_pf``: those of ``colour_pf``, and the road's share of the mixture.

    Attributes:
        road_share: 1 - alpha; the paper gives no value, fitted on development seeds.
    """

    road_share: float = tunable(0.03, 0.00001, 0.5, log=True)


@dataclass(frozen=True)
class RoadInstant(Instant):
    """Also the road, None if it is unknown."""

    road: RoadCurve | None


class RoadShapeModel(CarModel[RoadShapeParameters, RoadInstant]):
    """State x = (x, y, V, θ) in pixels from the image centre.

    Position and speed as in A.1; then ``θ' = rθ + N(0, τ'θ²)`` (3.10), rθ the road's direction at the new position.
    Weight ``alpha exp{-λ (1 - L)} + (1 - alpha) exp{-|x - S(y)|}`` (3.11, 3.12).
    Readings: the distance in 3.11 is the absolute value, in lengths of the car; without a known road θ is a random walk
    and the road's term is left out. The paper names no unit. In pixels, half a lane beside the centre line, where cars
    drive, costs a factor of e¹⁵, and the particles gather on the line: the car was then found again in half of twelve
    development runs of the paper's experiment.
    """

    def _directed(self, moved: NDArray[np.float64], observed: RoadInstant) -> NDArray[np.float64]:
        if observed.road is None:
            return super()._directed(moved, observed)
        return observed.road.offset_and_direction(moved[:, POSITION], moved[:, HEADING])[1]

    def log_weights(self, states: NDArray[np.float64], observed: RoadInstant) -> NDArray[np.float64]:
        p = self._parameters
        similarity = self._template.similarities(observed.bins, states[:, POSITION] + observed.centre_px)
        colour = -p.colour_sharpness * (1.0 - similarity)
        if observed.road is None:
            return colour
        offset, _ = observed.road.offset_and_direction(states[:, POSITION], states[:, HEADING])
        return np.logaddexp(
            np.log1p(-p.road_share) + colour, np.log(p.road_share) - np.abs(offset) / self._template.car_px
        )


@register(
    "road_shape_pf",
    role="as-written",
    edition=2,
    summary="particle filter with the road's shape, motion measured (paper A.2)",
)
class RoadShapeParticleFilter:
    """The filter of paper A.2, with the measured motion of the helicopter (none without poses).

    The paper gives no numbers; those of ``RoadShapeParameters``, ``RoadSearch`` and ``RoadEndParameters`` are fitted on
    development seeds. Readings: see ``RoadModel``, ``RoadEnd``, ``RoadShapeModel`` and ``ColourTemplate``; the road is
    searched for around the first box. The rectangle keeps the size of that box and does not turn.

    Source: paper A (Nawata, Ikoma, Kawano, Maeda 2010), see ``trackers.papers``.
    """

    Parameters = RoadShapeParameters

    def __init__(self, parameters: RoadShapeParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Take the template, trace the road at the car and draw the particles around it."""
        self._template = ColourTemplate.from_box(observation.image_rgb, box_xyxy)
        start_px = box_centre(box_xyxy) - image_centre(observation.camera)
        model = RoadShapeModel(self._parameters, self._template, start_px)
        self._filter = ParticleFilter[RoadInstant](model, self._parameters.particles, self._rng)
        self._road = RoadModel(RoadSearch(), self._template.car_px, self._rng)
        self._believed: tuple[NDArray[np.float64], float | None] = start_px, None
        self._road.update(cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY), STILL, start_px, None)
        self._ego: EgoPose | None = observation.ego

    def update(self, observation: Observation) -> Estimate:
        """Move the road, then predict, weight and resample the particles with the next picture."""
        motion = measured_motion(self._ego, observation.ego, observation.camera)
        self._ego = observation.ego
        grey = cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY)
        road = self._road.update(grey, motion, *self._believed)
        bins, centre_px = hs_bins(observation.image_rgb), image_centre(observation.camera)
        posterior = self._filter.step(RoadInstant(bins, centre_px, motion, road))
        self._believed = place_and_heading(posterior)
        return car_estimate(posterior, observation.camera, self._template.size_px)
