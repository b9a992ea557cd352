"""Baselines for a stereo pair: constant velocity, the nearest person within a gate, and colours to find a lost one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre, box_size
from trackers.kernels.histogram import bhattacharyya, histogram_of, hs_bins
from trackers.light_adaptive_stereo.candidates import Candidate, CandidateParameters, candidate_in_box
from trackers.light_adaptive_stereo.matching import StereoMatcher, baseline_m
from trackers.light_adaptive_stereo.person_kalman import PersonKalman
from trackers.light_adaptive_stereo.stereo_view import first_mounting, see, usual_depth_m
from trackers.registry import register, tunable
from trackers.types import Estimate, Observation

_LEAST_DEPTH_M = 0.1


@dataclass(frozen=True)
class StereoNearestParameters:
    """Settings of ``stereo_nearest``.

    Attributes:
        acceleration_mps2: standard deviation of a person's acceleration over the ground.
        place_noise_m: standard deviation of a candidate's position.
        gate_m: greatest distance from the prediction.
        fastest_mps: the gate grows at this speed, from the last match on.
        predicted_s: how long a target without a match is answered from the prediction; then it is lost.
    """

    acceleration_mps2: float = tunable(1.5, 0.3, 10.0, log=True)
    place_noise_m: float = tunable(0.1, 0.02, 0.5, log=True)
    gate_m: float = tunable(0.5, 0.2, 2.0, log=True)
    fastest_mps: float = tunable(2.0, 0.5, 5.0, log=True)
    predicted_s: float = tunable(0.7, 0.1, 3.0, log=True)


@register(
    "stereo_nearest",
    role="baseline",
    summary="stereo; constant velocity over the ground, and the nearest person within a gate that grows",
    suites=("stereo",),
)
class StereoNearest:
    """Takes the candidate nearest to the prediction of a Kalman filter in the frame of odometry.

    It is given what ``stereo_people`` is: the pair, the odometry's poses and the first box; its candidates are those of
    paper B (``see``). Without poses its places move with the robot, and its camera is level, at the height
    that the first box shows.
    """

    Parameters = StereoNearestParameters

    def __init__(self, parameters: StereoNearestParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._candidates = CandidateParameters()
        self._matcher = StereoMatcher()

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the candidate in the box, or on the box itself if there is none."""
        baseline_m(observation.camera)
        box_size(box_xyxy)
        self._time_s, self._unseen_s = observation.time_s, 0.0
        self._height_m = self._candidates.usual_height_m
        self._mounting = first_mounting(observation, box_xyxy, self._matcher, self._candidates.usual_height_m)
        view, self.elsewhere_cpu_s = see(observation, self._matcher, self._mounting, self._candidates)
        first = candidate_in_box(view.candidates if view else [], box_xyxy)
        if first is not None:
            place_m = first.place_m
            self._learn(observation, first)
        else:
            depth_m = usual_depth_m(observation.camera, box_xyxy, self._candidates.usual_height_m)
            place_m = self._mounting.place_at(box_centre(box_xyxy), depth_m, observation.camera)[:2]
        self._start_filter(_to_ground(observation, place_m[None])[0])

    def update(self, observation: Observation) -> Estimate:
        """Return the target among the candidates of the next pair, for a while its predicted place, then NaN."""
        seconds, self._time_s = max(observation.time_s - self._time_s, 0.0), observation.time_s
        self._unseen_s += seconds
        self._filter.predict(seconds)
        if self._is_lost:
            self._filter.stand_still()
        view, self.elsewhere_cpu_s = see(observation, self._matcher, self._mounting, self._candidates)
        found = self._find(observation, view.candidates) if view is not None and view.candidates else None
        if found is None:
            return self._predicted(observation)
        self._take(observation, found)
        return Estimate(found.centre_px, found.box_xyxy.copy(), in_view_probability=1.0, depth_m=found.depth_m)

    @property
    def _is_lost(self) -> bool:
        return self._unseen_s > self._parameters.predicted_s

    def _find(self, observation: Observation, candidates: list[Candidate]) -> Candidate | None:
        """Return the best candidate within the gate."""
        p = self._parameters
        places_m = _to_ground(observation, np.array([candidate.place_m for candidate in candidates]))
        away_m = np.linalg.norm(places_m - self._filter.place_m, axis=1)
        gate_m = p.gate_m + p.fastest_mps * self._unseen_s
        costs = np.where(away_m <= gate_m, self._costs(observation, candidates, away_m / gate_m), np.inf)
        best = int(np.argmin(costs))
        return candidates[best] if np.isfinite(costs[best]) else None

    def _costs(
        self, observation: Observation, candidates: list[Candidate], away: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the cost (N,) of candidates that are ``away`` by shares of the gate; infinite for one not to take."""
        return away

    def _learn(self, observation: Observation, found: Candidate) -> None:
        """Learn the look of the target's candidate."""

    def _take(self, observation: Observation, found: Candidate) -> None:
        place_m = _to_ground(observation, found.place_m[None])[0]
        if self._is_lost:
            self._start_filter(place_m)
        else:
            self._filter.correct(place_m)
        self._unseen_s = 0.0
        if not found.top_cut:
            self._height_m = found.height_m
        self._learn(observation, found)

    def _start_filter(self, place_m: NDArray[np.float64]) -> None:
        self._filter = PersonKalman(place_m, self._parameters.acceleration_mps2, self._parameters.place_noise_m)

    def _predicted(self, observation: Observation) -> Estimate:
        place_m = _to_robot(observation, self._filter.place_m)
        box, depth_m = self._mounting.standing_box(
            place_m, self._candidates.usual_width_m, self._height_m, observation.camera
        )
        if self._is_lost or depth_m <= _LEAST_DEPTH_M:
            return Estimate(np.full(2, np.nan), in_view_probability=0.0)
        return Estimate(box_centre(box), box, in_view_probability=0.5, depth_m=depth_m)


@dataclass(frozen=True)
class StereoColourGateParameters(StereoNearestParameters):
    """Settings of ``stereo_colour_gate``, see ``StereoNearestParameters``.

    Attributes:
        colour_weight: weight of ``1 - similarity`` of the HS histograms against the distance as a share of the gate.
        least_similarity: of a lost target's candidate.
        learning: share of the histogram that each match replaces.
    """

    colour_weight: float = tunable(1.0, 0.0, 5.0)
    least_similarity: float = tunable(0.75, 0.3, 0.98)
    learning: float = tunable(0.05, 0.005, 0.5, log=True)


@register(
    "stereo_colour_gate",
    role="baseline",
    summary="stereo_nearest with an adaptive colour histogram, by which a lost person is found again",
    suites=("stereo",),
)
class StereoColourGate(StereoNearest):
    """``stereo_nearest`` that weighs distance and colours, and takes a lost target's candidate by colours alone.

    Its HS histogram follows the light slowly; the camera's settings are not used.
    """

    Parameters = StereoColourGateParameters

    def __init__(self, parameters: StereoColourGateParameters, rng: np.random.Generator) -> None:
        super().__init__(parameters, rng)
        self._colours = parameters

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``StereoNearest``; without a candidate in the box, the first match gives the colours."""
        self._histogram: NDArray[np.float64] | None = None
        super().initialise(observation, box_xyxy)

    def _costs(
        self, observation: Observation, candidates: list[Candidate], away: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        if self._histogram is None:
            return away
        p, bins = self._colours, self._bins(observation)
        similarities = np.array([bhattacharyya(histogram_of(bins[c.pixels]), self._histogram) for c in candidates])
        if self._is_lost:
            return np.where(similarities >= p.least_similarity, 1.0 - similarities, np.inf)
        return away + p.colour_weight * (1.0 - similarities)

    def _learn(self, observation: Observation, found: Candidate) -> None:
        now = histogram_of(self._bins(observation)[found.pixels])
        before = now if self._histogram is None else self._histogram
        self._histogram = before + self._colours.learning * (now - before)

    def _bins(self, observation: Observation) -> NDArray[np.uint8]:
        return hs_bins(self._matcher.smaller(observation.image_rgb)).ravel()


def _robot_pose(observation: Observation) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return rotation (2, 2) and origin (2,) of the robot's frame in the frame of odometry; those of rest without."""
    if observation.ego is None:
        return np.eye(2), np.zeros(2)
    T = observation.ego.T_world_camera
    cosine, sine = T[:2, 2] / max(float(np.hypot(*T[:2, 2])), 1e-9)
    return np.array([[cosine, -sine], [sine, cosine]]), T[:2, 3]


def _to_ground(observation: Observation, places_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places (N, 2) of the robot's frame in the frame of odometry."""
    rotation, origin_m = _robot_pose(observation)
    return places_m @ rotation.T + origin_m


def _to_robot(observation: Observation, place_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a place (2,) of the frame of odometry in the robot's frame."""
    rotation, origin_m = _robot_pose(observation)
    return rotation.T @ (place_m - origin_m)
