"""The plain colour particle filter of paper A, section 2 (A.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre
from trackers.kernels.histogram import ColourTemplate, hs_bins
from trackers.particle_filter import ParticleFilter
from trackers.registry import register, tunable
from trackers.road_shape.background_motion import measured_motion
from trackers.road_shape.car_state import POSITION, CarModel, Instant, car_estimate, image_centre
from trackers.types import EgoPose, Estimate, Observation


@dataclass(frozen=True)
class ColourParameters:
    """Settings of ``colour_pf``, and of ``road_shape_pf`` alike. The paper gives no values; all are fitted on
    development seeds, once for both methods, so that they differ by the road alone.

    Attributes:
        particles: N.
        colour_sharpness: λ of the weight.
        speed_noise: τV, lengths of the car per frame.
        heading_noise_rad: τθ, with a road τ'θ around its direction.
    """

    particles: int = 1000
    colour_sharpness: float = tunable(30.0, 3.0, 300.0, log=True)
    speed_noise: float = tunable(0.03, 0.003, 0.2, log=True)
    heading_noise_rad: float = tunable(0.15, 0.01, 1.0, log=True)


class ColourModel(CarModel[ColourParameters, Instant]):
    """State x = (x, y, V, θ) in pixels from the image centre.

    ``x' = x + V cos θ, y' = y + V sin θ`` (2.2, 2.3), then moved with the ground in the picture;
    ``V' = V + N(0, τV²)`` (2.4), ``θ' = θ + N(0, τθ²)`` (2.5); weight ``exp{-λ (1 - L)}`` (2.8).
    """

    def log_weights(self, states: NDArray[np.float64], observed: Instant) -> NDArray[np.float64]:
        similarity = self._template.similarities(observed.bins, states[:, POSITION] + observed.centre_px)
        return -self._parameters.colour_sharpness * (1.0 - similarity)


@register("colour_pf", role="as-written", edition=2, summary="plain colour particle filter (paper A.1)")
class ColourParticleFilter:
    """The filter of paper A.1, with the *measured* motion of the helicopter (none without poses).

    Readings: the helicopter's motion moves the picture of flat ground as in A.2, so that only the road differs in the
    comparison; for the same reason a rectangle outside the picture or cut by its border is weighted as in A.2. The
    rectangle keeps the size of the first box and does not turn.

    Source: paper A (Nawata, Ikoma, Kawano, Maeda 2010), see ``trackers.papers``.
    """

    Parameters = ColourParameters

    def __init__(self, parameters: ColourParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Take the template from the box and draw the particles around it."""
        self._template = ColourTemplate.from_box(observation.image_rgb, box_xyxy)
        start_px = box_centre(box_xyxy) - image_centre(observation.camera)
        model = ColourModel(self._parameters, self._template, start_px)
        self._filter = ParticleFilter[Instant](model, self._parameters.particles, self._rng)
        self._ego: EgoPose | None = observation.ego

    def update(self, observation: Observation) -> Estimate:
        """Predict, weight and resample the particles with the next picture."""
        motion = measured_motion(self._ego, observation.ego, observation.camera)
        self._ego = observation.ego
        instant = Instant(hs_bins(observation.image_rgb), image_centre(observation.camera), motion)
        return car_estimate(self._filter.step(instant), observation.camera, self._template.size_px)
