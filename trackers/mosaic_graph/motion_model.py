"""How the target moves and what a picture says of it: the model given to the package's particle loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.posterior import detection_log_weights
from trackers.mosaic_graph.ground_camera import GroundCamera
from trackers.mosaic_graph.kernels import road_motion as rm
from trackers.mosaic_graph.kernels import road_position as rp
from trackers.mosaic_graph.kernels.roads import Roads

_AXIS_DEVIATION_RAD, _AXIS_SPACING_RAD_PER_M = 0.12, 0.3
_FREE_DRIVING_MPS, _CRUISE_PRIOR_S = 4.0, 2.0
_BORN_POSITION_M, _BORN_SPEED_MPS, _BORN_HEADING_RAD, _BORN_URGE_MPS2 = 0.4, 1.0, 0.12, 1.5
_BORN_CURVE_PER_M, _BORN_TURNING, _BORN_TURNS_PER_M, _LONGEST_TURN_RAD = 0.06, 0.3, (0.05, 0.2), 1.7


@dataclass(frozen=True, eq=False)
class Birth:
    """A place where the target may be although no particle is there.

    Attributes:
        position_m (2,), heading_rad, speed_mps: of the car seen there.
        log_prior: log of the probability that it is the target, by all but the present picture.
    """

    position_m: NDArray[np.float64]
    heading_rad: float
    speed_mps: float
    log_prior: float


@dataclass(frozen=True, eq=False)
class Instant:
    """What the filter is told of one picture.

    Attributes:
        dt_s: time since the last one.
        camera: of this picture; None if it shows no ground.
        roads: as believed now.
        roads_are_new: whether they were drawn anew since the last instant.
        candidates_m (J, 2), axes_rad (J,), log_ratios (J,): see ``detection_log_weights``.
        vague_m: (J,) standard deviation of the candidates beside that of any detection.
        births: see there.
    """

    dt_s: float
    camera: GroundCamera | None
    roads: Roads
    roads_are_new: bool
    candidates_m: NDArray[np.float64]
    axes_rad: NDArray[np.float64]
    log_ratios: NDArray[np.float64]
    vague_m: NDArray[np.float64]
    births: tuple[Birth, ...]


class CarModel:
    """Particles are states of ``trackers.mosaic_graph.kernels.road_motion``."""

    def __init__(
        self,
        start_m: NDArray[np.float64],
        axis_rad: float,
        habits: rm.Habits,
        *,
        born_share: float,
        detection_probability: float,
        miss_counts: bool,
        detection_deviation_m: float,
        border_m: float,
    ) -> None:
        """Begin with a car at ``start_m`` (2,) of unknown speed, heading along ``axis_rad`` or against it.

        Args:
            born_share: share of the particles that is given to births while there are any.
            detection_probability: that a target in full view is found in a picture, given that it was
                missed in the one before.
            miss_counts: False takes a miss for no information.
            detection_deviation_m: standard deviation of a detection.
            border_m: distance from the picture's border within which a target is not counted on to be found.
        """
        self._start_m, self._axis_rad, self._habits = start_m, axis_rad, habits
        self._born_share = born_share
        self._detection_probability = detection_probability
        self._miss_counts = miss_counts
        self._detection_deviation_m = detection_deviation_m
        self._border_m = border_m
        self._driven_s = _CRUISE_PRIOR_S

    def learn_speed(self, speed_mps: float, dt_s: float) -> None:
        """Let the speed wished for follow the target's own habit: the mean of its speeds in free driving."""
        if speed_mps < _FREE_DRIVING_MPS:
            return
        self._driven_s += dt_s
        mean = self._habits.cruise_mps
        self._habits = self._habits._replace(cruise_mps=mean + dt_s / self._driven_s * (speed_mps - mean))

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw states (N, COLUMNS)."""
        states = np.zeros((count, rp.COLUMNS))
        states[:, rp.X : rp.Y + 1] = self._start_m + rng.normal(0, 0.2, (count, 2))
        ahead = rng.random(count) < 0.5
        states[:, rp.HEADING] = self._axis_rad + np.pi * ahead + rng.normal(0, 0.3, count)
        states[:, rp.SPEED] = rng.uniform(0, 14.0, count)
        states[:, rp.CRUISE] = np.maximum(states[:, rp.SPEED], self._draw_cruise(count, rng))
        states[:, rp.CHOICE], states[:, rp.BOUND] = -1, np.nan
        states[:, rp.LOOK] = rng.uniform(rm.SHORTEST_LOOK_M, rm.LONGEST_LOOK_M, count)
        return states

    def predict(self, states: NDArray[np.float64], observed: Instant, rng: np.random.Generator) -> NDArray[np.float64]:
        """Drive all states on; some make room for births."""
        states = states.copy()
        states[:, rp.LOG_PRIOR] = 0.0
        count = len(states)
        if observed.roads_are_new:
            self._associate_anew(states, observed.roads, rng)
        rm.drive(
            states, observed.roads, self._habits, observed.dt_s, rng.normal(size=(count, 7)), rng.random((count, 7))
        )
        if observed.births:
            self._give_birth(states, observed, rng)
        return states

    def log_weights(self, states: NDArray[np.float64], observed: Instant) -> NDArray[np.float64]:
        """Return log-weights (N,): what the picture says, and the prior of those just born."""
        positions = np.ascontiguousarray(states[:, : rp.Y + 1])
        spacing_m = _spacing_m(positions)
        return states[:, rp.LOG_PRIOR] + detection_log_weights(
            positions,
            np.ascontiguousarray(states[:, rp.HEADING]),
            self.detectable(positions, observed.camera),
            self._miss_counts,
            observed.candidates_m,
            observed.axes_rad,
            observed.log_ratios,
            np.hypot(np.hypot(self._detection_deviation_m, spacing_m), observed.vague_m),
            float(np.hypot(_AXIS_DEVIATION_RAD, _AXIS_SPACING_RAD_PER_M * spacing_m)),
        )

    def detectable(self, positions_m: NDArray[np.float64], camera: GroundCamera | None) -> NDArray[np.float64]:
        """Return the probability (N,) that a target at each position would have been found."""
        if camera is None:
            return np.zeros(len(positions_m))
        pixels = camera.to_picture(positions_m)
        size = np.array([camera.model.width_px, camera.model.height_px])
        inside_px = np.minimum(pixels, size - pixels).min(axis=1)
        inside = np.nan_to_num(inside_px, nan=-1.0) * camera.metres_per_pixel() / self._border_m
        return self._detection_probability * np.clip(inside, 0.0, 1.0)

    def _associate_anew(self, states: NDArray[np.float64], roads: Roads, rng: np.random.Generator) -> None:
        """Find the place on roads that were drawn anew of every state that is on one. Who was off the road stays so."""
        on_road = states[:, rp.ON_ROAD] > 0
        driving = states[on_road]
        rp.associate(driving, roads, rng.random(len(driving)))
        states[on_road] = driving

    def _give_birth(self, states: NDArray[np.float64], observed: Instant, rng: np.random.Generator) -> None:
        """Put births in the place of states drawn at random: resampling leaves them in order."""
        each = max(1, int(self._born_share * len(states) / len(observed.births)))
        victims = rng.permutation(len(states))
        share = each / len(states)
        for k, birth in enumerate(observed.births):
            born = np.zeros((each, rp.COLUMNS))
            born[:, rp.X : rp.Y + 1] = birth.position_m + rng.normal(0, _BORN_POSITION_M, (each, 2))
            born[:, rp.HEADING] = birth.heading_rad + rng.normal(0, _BORN_HEADING_RAD, each)
            born[:, rp.SPEED] = np.abs(birth.speed_mps + rng.normal(0, _BORN_SPEED_MPS, each))
            born[:, rp.CRUISE] = np.maximum(born[:, rp.SPEED], self._draw_cruise(each, rng))
            born[:, rp.LOG_PRIOR] = birth.log_prior - np.log(share)
            born[:, rp.URGE] = rng.normal(0, _BORN_URGE_MPS2, each)
            side, turning = rng.choice([-1.0, 1.0], each), rng.random(each) < _BORN_TURNING
            born[:, rp.TURN] = turning * side * rng.uniform(0, _LONGEST_TURN_RAD, each)
            turns = side * rng.uniform(*_BORN_TURNS_PER_M, each)
            born[:, rp.CURVE] = np.where(turning, turns, rng.normal(0, _BORN_CURVE_PER_M, each))
            born[:, rp.CHOICE], born[:, rp.BOUND] = -1, np.nan
            born[:, rp.LOOK] = rng.uniform(rm.SHORTEST_LOOK_M, rm.LONGEST_LOOK_M, each)
            rp.associate(born, observed.roads, rng.random(each))
            states[victims[k * each : (k + 1) * each]] = born

    def _draw_cruise(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.normal(self._habits.cruise_mps, self._habits.cruise_spread_mps, count)


def _spacing_m(positions_m: NDArray[np.float64]) -> float:
    """Return how far apart particles (N, 2) are: each stands for its neighbourhood, and where they are thinly
    spread hardly one lies as near to the target as a detection is good. ``sqrt(2 pi sqrt(det cov) / N)``.
    """
    if len(positions_m) < 2:
        return 0.0
    determinant = float(np.linalg.det(np.cov(positions_m.T)))
    return float(np.sqrt(2.0 * np.pi * np.sqrt(max(determinant, 0.0)) / len(positions_m)))
