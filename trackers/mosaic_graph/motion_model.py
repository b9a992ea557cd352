"""Motion model and likelihood of the particle filter, and the side of the street on which cars drive."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.ground_camera import GroundCamera
from trackers.kernels.particles import detection_log_weights, spacing
from trackers.mosaic_graph.kernels import road_motion as rm
from trackers.mosaic_graph.kernels import road_position as rp
from trackers.mosaic_graph.kernels.crossing import CUT_M
from trackers.mosaic_graph.kernels.road_position import Roads, offset_to_right

_LANE_WIDTH_M = 3.25
"""Lanes of streets are 3.0 to 3.5 m wide (AASHTO, Policy on Geometric Design, 2011: 10 to 12 ft)."""
_SIGHTING_DEVIATION_M, _MOST_SIGHTINGS = 1.5, 150.0
_LEAST_SPEED_MPS, _LEAST_COSINE = 2.0, 0.97


@dataclass
class LaneOffset:
    """Normal distribution of the lane's offset to the right of the drawn centre line, negative for left-hand traffic.

    Its prior is the centre line with a deviation of half a lane: neither side is preferred. A sighting deviates by
    1.5 m (errors of the drawn line last for several); those more than a lane from the line are not used. Old
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


_AXIS_DEVIATION_RAD, _AXIS_SPACING_RAD_PER_M = 0.12, 0.3
_FREE_DRIVING_MPS, _CRUISE_PRIOR_S = 4.0, 2.0
_FASTEST_START_MPS = 14.0
"""The usual limit in towns, 50 km/h."""
_KNOWN_POSITION_M, _KNOWN_HEADING_RAD, _KNOWN_SPEED_MPS = 0.1, 0.02, 0.1
_BORN_POSITION_M, _BORN_SPEED_MPS, _BORN_HEADING_RAD, _BORN_URGE_MPS2 = 0.4, 1.0, 0.12, 1.5
_BORN_CURVE_PER_M, _BORN_TURNING, _BORN_TURNS_PER_M, _LONGEST_TURN_RAD = 0.06, 0.3, (0.05, 0.2), 1.7


@dataclass(frozen=True, eq=False)
class Birth:
    """A place where the target may be although no particle is there.

    Attributes:
        position_m (2,), heading_rad, speed_mps: of the car seen there.
        log_prior: log-probability that it is the target, before the present picture.
    """

    position_m: NDArray[np.float64]
    heading_rad: float
    speed_mps: float
    log_prior: float


@dataclass(frozen=True, eq=False)
class Instant:
    """Input of the filter for one picture.

    Attributes:
        dt_s: time since the previous picture.
        camera: of this picture; None if it shows no ground.
        roads: present estimate.
        roads_are_new: whether they were redrawn since the previous picture.
        candidates_m (J, 2), axes_rad (J,), log_ratios (J,): see ``detection_log_weights``.
        vague_m: (J,) standard deviation of each candidate, in addition to that of any detection.
        births: places of new particles.
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


@dataclass(eq=False)
class CarModel:
    """Model of a car whose states are those of ``trackers.mosaic_graph.kernels.road_motion``.

    Attributes:
        start_m: (2,) place at the start; the speed is unknown.
        axis_rad: axis at the start; the heading is one of its two directions.
        habits: of the driver.
        born_share: share of the particles replaced while there are births.
        detection_probability: that a target in full view is found in a picture, given that it was missed in the one
            before.
        miss_counts: if False, a missing detection gives no information.
        detection_deviation_m: standard deviation of a detection.
        border_m: distance to the picture's border below which a detection becomes less probable.
    """

    start_m: NDArray[np.float64]
    axis_rad: float
    habits: rm.Habits
    born_share: float
    detection_probability: float
    miss_counts: bool
    detection_deviation_m: float
    border_m: float
    _driven_s: float = field(default=_CRUISE_PRIOR_S, init=False)
    _lane: LaneOffset = field(default_factory=LaneOffset, init=False)

    def __post_init__(self) -> None:
        self._set_lane()

    def learn_speed(self, speed_mps: float, dt_s: float) -> None:
        """Move the mean desired speed towards the mean of the target's speeds in free driving."""
        if speed_mps < _FREE_DRIVING_MPS:
            return
        self._driven_s += dt_s
        mean = self.habits.cruise_mps
        self.habits = self.habits._replace(cruise_mps=mean + dt_s / self._driven_s * (speed_mps - mean))

    def learn_lane(
        self, position_m: NDArray[np.float64], velocity_mps: NDArray[np.float64], roads: Roads, share: float
    ) -> None:
        """Learn the side and the place of the lane from a moving car, see ``LaneOffset.learn``."""
        self._lane.learn(position_m, velocity_mps, roads, share)
        self._set_lane()

    def _set_lane(self) -> None:
        self.habits = self.habits._replace(lane_m=self._lane.mean_m, lane_spread_m=self._lane.spread_m)

    def sample_initial(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw states (N, COLUMNS)."""
        states = np.zeros((count, rp.COLUMNS))
        states[:, rp.X : rp.Y + 1] = self.start_m + rng.normal(0, 0.2, (count, 2))
        ahead = rng.random(count) < 0.5
        states[:, rp.HEADING] = self.axis_rad + np.pi * ahead + rng.normal(0, 0.3, count)
        states[:, rp.SPEED] = rng.uniform(0, _FASTEST_START_MPS, count)
        states[:, rp.CRUISE] = np.maximum(states[:, rp.SPEED], self._draw_cruise(count, rng))
        states[:, rp.CHOICE], states[:, rp.BOUND] = -1, np.nan
        states[:, rp.LOOK] = rng.uniform(rm.SHORTEST_LOOK_M, rm.LONGEST_LOOK_M, count)
        states[:, rp.VIGOUR] = rng.normal(0, self.habits.vigour_spread, count)
        states[:, rp.CORNERING] = rng.normal(0, self.habits.cornering_spread, count)
        return states

    def moved_to(
        self,
        states: NDArray[np.float64],
        position_m: NDArray[np.float64],
        heading_rad: float,
        speed_mps: float,
        roads: Roads,
        rng: np.random.Generator,
    ) -> NDArray[np.float64]:
        """Return states (N, COLUMNS) at one place (2,), heading and speed; what they assume of the driver stays."""
        states = states.copy()
        states[:, rp.X : rp.Y + 1] = position_m + rng.normal(0, _KNOWN_POSITION_M, (len(states), 2))
        states[:, rp.HEADING] = heading_rad + rng.normal(0, _KNOWN_HEADING_RAD, len(states))
        states[:, rp.SPEED] = np.abs(speed_mps + rng.normal(0, _KNOWN_SPEED_MPS, len(states)))
        rp.associate(states, roads, rng.random(len(states)))
        return states

    def predict(self, states: NDArray[np.float64], observed: Instant, rng: np.random.Generator) -> NDArray[np.float64]:
        """Move all states on; replace some by births."""
        states = states.copy()
        states[:, rp.LOG_PRIOR] = 0.0
        count = len(states)
        if observed.roads_are_new:
            self._associate_anew(states, observed.roads, rng)
        normals = rng.normal(size=(count, rm.NORMALS))
        rm.drive(states, observed.roads, self.habits, observed.dt_s, normals, rng.random((count, 7)))
        if observed.births:
            self._give_birth(states, observed, rng)
        return states

    def log_weights(self, states: NDArray[np.float64], observed: Instant) -> NDArray[np.float64]:
        """Return log-weights (N,): the picture's log-likelihood, and the log-prior of newborn particles."""
        positions = np.ascontiguousarray(states[:, : rp.Y + 1])
        spacing_m = spacing(positions)
        return states[:, rp.LOG_PRIOR] + detection_log_weights(
            positions,
            np.ascontiguousarray(states[:, rp.HEADING]),
            self.detectable(positions, observed.camera),
            self.miss_counts,
            observed.candidates_m,
            observed.axes_rad,
            observed.log_ratios,
            np.hypot(np.hypot(self.detection_deviation_m, spacing_m), observed.vague_m),
            float(np.hypot(_AXIS_DEVIATION_RAD, _AXIS_SPACING_RAD_PER_M * spacing_m)),
        )

    def detectable(self, positions_m: NDArray[np.float64], camera: GroundCamera | None) -> NDArray[np.float64]:
        """Return the probability (N,) of a detection of a target at each position (N, 2)."""
        if camera is None:
            return np.zeros(len(positions_m))
        pixels = camera.to_picture(positions_m)
        size = np.array([camera.model.width_px, camera.model.height_px])
        inside_px = np.minimum(pixels, size - pixels).min(axis=1)
        inside = np.nan_to_num(inside_px, nan=-1.0) * camera.metres_per_pixel() / self.border_m
        return self.detection_probability * np.clip(inside, 0.0, 1.0)

    def _associate_anew(self, states: NDArray[np.float64], roads: Roads, rng: np.random.Generator) -> None:
        """Associate every state on a road with the redrawn roads, in place; states off the road stay free."""
        on_road = states[:, rp.ON_ROAD] > 0
        driving = states[on_road]
        rp.associate(driving, roads, rng.random(len(driving)))
        states[on_road] = driving

    def _give_birth(self, states: NDArray[np.float64], observed: Instant, rng: np.random.Generator) -> None:
        """Replace randomly chosen states by births: resampling leaves the states in order."""
        each = max(1, int(self.born_share * len(states) / len(observed.births)))
        replaced = rng.permutation(len(states))
        share = each / len(states)
        for k, birth in enumerate(observed.births):
            places = replaced[k * each : (k + 1) * each]
            born = np.zeros((each, rp.COLUMNS))
            # What the filter has learnt of the driver outlives the particles.
            born[:, rp.VIGOUR], born[:, rp.CORNERING] = states[places, rp.VIGOUR], states[places, rp.CORNERING]
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
            states[places] = born

    def _draw_cruise(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.normal(self.habits.cruise_mps, self.habits.cruise_spread_mps, count)
