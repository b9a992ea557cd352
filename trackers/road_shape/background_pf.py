"""The background-model particle filter of paper A, section 4 (A.3), without measured motion."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre
from trackers.kernels.histogram import ColourTemplate, hs_bins
from trackers.particle_filter import ParticleFilter
from trackers.registry import register, tunable
from trackers.road_shape.background_motion import STILL, BackgroundMotionFilter, BackgroundMotionParameters
from trackers.road_shape.colour_pf import HEADING, POSITION, CarModel, car_estimate, image_centre, place_and_heading
from trackers.road_shape.existence import ExistenceMap, PixelClassifier, load_class_statistics
from trackers.road_shape.road_lines import RoadSearch
from trackers.road_shape.road_model import RoadModel
from trackers.road_shape.road_shape_pf import RoadInstant
from trackers.types import Estimate, Observation


@dataclass(frozen=True)
class BackgroundParameters:
    """Settings of ``background_pf``; the paper gives no values, all are fitted on development seeds.

    Attributes:
        particles: N of the car. motion_particles: N of the background's motion.
        colour_sharpness: lambda of the colour's weight.
        speed_noise, heading_noise_rad: standard deviations of the car's random walk per frame; speed in lengths of the
            car.
        translation_noise, rotation_noise_rad: the same of the background; translation in lengths of the car.
        class_model: name or .json path of the colour statistics of the classes road and other.
    """

    particles: int = 1000
    motion_particles: int = 1000
    colour_sharpness: float = tunable(25.0, 3.0, 300.0, log=True)
    speed_noise: float = tunable(0.004, 0.001, 0.2, log=True)
    heading_noise_rad: float = tunable(0.05, 0.01, 0.6, log=True)
    translation_noise: float = tunable(0.5, 0.05, 2.0, log=True)
    rotation_noise_rad: float = tunable(0.004, 0.0005, 0.05, log=True)
    class_model: str = "road_town_classes"


@dataclass(frozen=True)
class BackgroundInstant(RoadInstant):
    """Also the map of a car's existence probability; the motion is estimated."""

    existence: ExistenceMap


class BackgroundModel(CarModel[BackgroundParameters, BackgroundInstant]):
    """State x = (x, y, V, θ) in pixels from the image centre.

    ``(x, y)' = Rot(-ω) ((x, y) + V (cos θ, sin θ)) - (Vx, Vy)``, ``θ' = θ - ω + N``, ``V' = V + N`` (4.19-4.21).
    Weight ``exp{-λ (1 - L)} * exp(-(θ - rθ)²) * p(x)``, p the mean existence probability over the rectangle (4.22,
    4.23). Readings: rectangles outside the picture or cut by its border have the colour weight of A.2; without a known
    road the factor of its direction is left out.
    """

    def log_weights(self, states: NDArray[np.float64], observed: BackgroundInstant) -> NDArray[np.float64]:
        centres_px = states[:, POSITION] + observed.centre_px
        similarity = self._template.similarities(observed.bins, centres_px)
        log_weights = -self._parameters.colour_sharpness * (1.0 - similarity)
        log_weights += np.log(observed.existence.mean_over(centres_px, self._template.size_px))
        if observed.road is not None:
            heading = states[:, HEADING]
            _, direction = observed.road.offset_and_direction(states[:, POSITION], heading)
            log_weights -= np.square(heading - direction)
        return log_weights


@register(
    "background_pf",
    role="as-written",
    edition=2,
    summary="particle filter with pixel classes, motion from pixels (paper A.3)",
)
class BackgroundParticleFilter:
    """The filter of paper A.3; it uses no measured pose.

    The paper's numbers: the existence probabilities 1.0, 0.8 and 0.1. It gives no others; those of
    ``BackgroundParameters`` are fitted on development seeds. Readings: see ``BackgroundMotionFilter``,
    ``BackgroundModel``, ``ExistenceMap``, ``RoadModel`` and ``ColourTemplate``. The rectangle is the first box, keeps
    its size and does not turn.

    Ours: the classes have colour statistics by light, without which hardly a pixel is road (``PixelClassifier``); the
    search for corners starts at the last motion (``BackgroundMotionFilter``).

    Source: paper A (Nawata, Ikoma, Kawano, Maeda 2010), see ``trackers.papers``.
    """

    Parameters = BackgroundParameters

    def __init__(self, parameters: BackgroundParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng
        statistics = load_class_statistics(parameters.class_model)
        self._classifier = PixelClassifier(statistics.mean_rgb, statistics.variance_rgb, statistics.of_road)

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Take the template, trace the road at the car and draw the particles around it."""
        p = self._parameters
        self._template = ColourTemplate.from_box(observation.image_rgb, box_xyxy)
        start_px = box_centre(box_xyxy) - image_centre(observation.camera)
        model = BackgroundModel(p, self._template, start_px)
        self._filter = ParticleFilter[BackgroundInstant](model, p.particles, self._rng)
        walk = BackgroundMotionParameters(
            p.motion_particles, p.translation_noise * self._template.car_px, p.rotation_noise_rad
        )
        self._motion = BackgroundMotionFilter(walk, observation.image_rgb, self._rng)
        self._road = RoadModel(RoadSearch(), self._template.car_px, self._rng)
        self._believed: tuple[NDArray[np.float64], float | None] = start_px, None
        self._road.update(cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY), STILL, start_px, None)

    def update(self, observation: Observation) -> Estimate:
        """Estimate the background's motion, move the road, then predict, weight and resample the particles."""
        motion = self._motion.update(observation.image_rgb)
        grey = cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY)
        road = self._road.update(grey, motion, *self._believed)
        centre_px = image_centre(observation.camera)
        existence = ExistenceMap(observation.image_rgb, self._classifier, road, centre_px)
        instant = BackgroundInstant(hs_bins(observation.image_rgb), centre_px, motion, road, existence)
        posterior = self._filter.step(instant)
        self._believed = place_and_heading(posterior)
        return car_estimate(posterior, observation.camera, self._template.size_px)
