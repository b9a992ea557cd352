"""``colour_pf``, the plain colour particle filter of paper A, and the car's state, shared by its three filters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.kernels.boxes import box_around, box_centre, inside_picture
from trackers.kernels.histogram import ColourTemplate, hs_bins
from trackers.kernels.particles import circular_mean
from trackers.particle_filter import ParticleFilter, Posterior
from trackers.registry import register, tunable
from trackers.road_shape.background_motion import Motion, measured_motion
from trackers.types import CameraModel, EgoPose, Estimate, Observation

X, Y, SPEED, HEADING = range(4)
"""Columns of a state: position in pixels from the image centre, speed in pixels a frame, heading in radians from +x
towards +y."""

POSITION = slice(0, 2)


def image_centre(camera: CameraModel) -> NDArray[np.float64]:
    """Return the image centre (2,) in pixels from the top left corner."""
    return np.array([0.5 * camera.width_px, 0.5 * camera.height_px])


START_NOISE = 0.06
FASTEST_START = 0.35
"""See ``initial_states``."""


def initial_states(
    count: int, position_px: NDArray[np.float64], car_px: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw states (N, 4): position normal around (2,), speed uniform in [0, fastest], heading uniform.

    Reading: the paper does not define the start. One box gives neither speed nor heading; the position's standard
    deviation is 0.06 and the fastest speed 0.35 per frame, in lengths of the car (``car_px``).
    """
    states = np.empty((count, 4))
    states[:, POSITION] = rng.normal(position_px, START_NOISE * car_px, (count, 2))
    states[:, SPEED] = rng.uniform(0.0, FASTEST_START * car_px, count)
    states[:, HEADING] = rng.uniform(-np.pi, np.pi, count)
    return states


def move_on(
    states: NDArray[np.float64], motion: Motion, speed_noise_px: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the states (N, 4) of the next frame: moved by their velocity, then with the picture; no heading noise yet.

    ``(x, y)' = m((x, y) + V (cos θ, sin θ))``, ``V' = V + N(0, τV²)``, ``θ'`` the heading as turned by m. With m the
    paper's rigid motion: ``m(p) = Rot(-ω) p - (Vx, Vy)``, ``θ' = θ - ω`` (paper A, equations 2.2-2.4, 4.19-4.21). A
    negative speed is a car that drives backwards.
    """
    places_px = np.empty((2, len(states), 2))
    _places_ahead(states, places_px)
    return _states_at(motion.move(places_px), states[:, SPEED] + rng.normal(0.0, speed_noise_px, len(states)))


@njit(cache=True)
def _places_ahead(states: NDArray[np.float64], places_px: NDArray[np.float64]) -> None:
    """Write where cars are a frame later, and a pixel ahead of there (2, N, 2)."""
    for n in range(len(states)):
        x, y, speed, heading_rad = states[n]
        cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
        places_px[0, n, 0], places_px[0, n, 1] = x + speed * cosine, y + speed * sine
        places_px[1, n, 0], places_px[1, n, 1] = places_px[0, n, 0] + cosine, places_px[0, n, 1] + sine


@njit(cache=True)
def _states_at(places_px: NDArray[np.float64], speeds_px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the states (N, 4) of cars by their places and those ahead of them (2, N, 2), and speeds (N,)."""
    states = np.empty((len(speeds_px), 4))
    for n in range(len(states)):
        here, ahead = places_px[0, n], places_px[1, n]
        states[n, X], states[n, Y], states[n, SPEED] = here[0], here[1], speeds_px[n]
        states[n, HEADING] = np.arctan2(ahead[1] - here[1], ahead[0] - here[0])
    return states


class Walk(Protocol):
    """Noise of speed and heading: τV, lengths of the car per frame, and τθ."""

    @property
    def speed_noise(self) -> float: ...

    @property
    def heading_noise_rad(self) -> float: ...


@dataclass(frozen=True)
class Instant:
    """One picture's bins (H, W), its centre (2,), and the ground's motion since the last picture."""

    bins: NDArray[np.uint8]
    centre_px: NDArray[np.float64]
    motion: Motion


Parameters = TypeVar("Parameters", bound=Walk)
Observed = TypeVar("Observed", bound=Instant)


class CarModel(Generic[Parameters, Observed]):
    """What the models of the three filters share: the prior, and the motion without a road."""

    def __init__(self, parameters: Parameters, template: ColourTemplate, start_px: NDArray[np.float64]) -> None:
        """``start_px`` (2,) is the centre of the car's first box, from the image centre."""
        self._parameters = parameters
        self._template = template
        self._start_px = start_px

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """See ``initial_states``."""
        return initial_states(count, self._start_px, self._template.car_px, rng)

    def predict(self, states: NDArray[np.float64], observed: Observed, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return the next states (N, 4): ``move_on``, then ``θ' = θ + N(0, τθ²)`` with θ from ``_directed``."""
        moved = move_on(states, observed.motion, self._parameters.speed_noise * self._template.car_px, rng)
        moved[:, HEADING] = self._directed(moved, observed)
        moved[:, HEADING] += rng.normal(0.0, self._parameters.heading_noise_rad, len(states))
        return moved

    def _directed(self, moved: NDArray[np.float64], observed: Observed) -> NDArray[np.float64]:
        """Return the mean headings (N,) of the next frame: those of the moved states."""
        return moved[:, HEADING]


def place_and_heading(posterior: Posterior) -> tuple[NDArray[np.float64], float]:
    """Return the weighted means of position (2,), from the image centre, and heading."""
    position_px = posterior.weights @ posterior.states[:, POSITION]
    return position_px, circular_mean(posterior.states[:, HEADING], posterior.weights)


def car_estimate(posterior: Posterior, camera: CameraModel, size_px: NDArray[np.float64]) -> Estimate:
    """Return the estimate of a posterior over car states: weighted means before resampling.

    The box keeps its first size (2,) as the paper's rectangle does. The paper's methods give no in-view probability;
    here it is what the weights outside the picture leave of 1, which is 1 exactly if there are none.
    """
    particles_px = posterior.states[:, POSITION] + image_centre(camera)
    weights = posterior.weights
    position_px = weights @ particles_px
    outside = ~inside_picture(particles_px, camera.width_px, camera.height_px)
    return Estimate(
        position_px=position_px,
        box_xyxy=box_around(position_px, size_px),
        heading_rad=circular_mean(posterior.states[:, HEADING], weights),
        in_view_probability=float(max(1.0 - weights[outside].sum(), 0.0)),
        particles_px=particles_px,
        weights=weights,
    )


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
