"""A reference with unfair knowledge: the true road graph and the true state at the exit; no picture after it.

Its error while the car is outside is the irreducible part of a tracker's error: the driver's route and speed, and
whether the car leaves the road, cannot be known.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from benchmarks.judges.frame_out.oracle_routes import RouteFan
from scenarios.loop import LoopTracker, given
from scenarios.road_town.plan import EXCURSION_ALONG_M, EXCURSION_ASIDE_M, STOP_S
from scenarios.road_town.presets import STANDARD
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.route import aside_share
from scenarios.road_town.traffic import (
    ACCELERATION_MPS2,
    BRAKING_MPS2,
    HALTS_BELOW_MPS,
    HARDEST_BRAKING_MPS2,
    LATERAL_ACCELERATION_MPS2,
    PASSED_STOP_M,
    SLOWEST_LIMIT_MPS,
    STANDSTILL_GAP_M,
    TIME_GAP_S,
)
from scenarios.scenario import Episode, Frame
from scenarios.truth import Truth
from sim.optics import project
from trackers.kernels.particles import geometric_median
from trackers.types import Estimate, Start

_HELD_UP_WITHIN_S = 4.0
_PROPOSALS_PER_PARTICLE = 12
_BRAKING_REACH_M = np.arange(0.0, 22.0, 2.0)[:, None]
_RECENT_FRAMES = 5
_MEDIAN_STEPS = 40


@dataclass(frozen=True)
class OracleParameters:
    """The reference's model of drivers: those of the scenario's preset ``standard``.

    Attributes:
        particles: number of guesses.
        cruise_mps: range of speeds on a free straight.
        stop_share, stop_s: share of crossings where a car halts, and how long.
        off_road_share: prior share of guesses with a way off the road. Half of them may be on it already, the others
            leave the road ``leaves_within_m`` metres from the exit.
        aside_m, along_m: ranges of such a way's sideways distance and length.
        slows_off_road: whether it knows how slowly this scenario's drivers leave the road, which no map contains.
        held_up_share: share of guesses in which another car slows this one down, from a time within the next 4 s on,
            to any speed.
        acceleration_noise_mps2, acceleration_noise_s: standard deviation and correlation time of the residual of the
            driver model.
        place_sigma_m, heading_sigma_rad, acceleration_sigma_mps2: standard deviations of the fit to the state at the
            exit.
    """

    particles: int = 600
    cruise_mps: tuple[float, float] = STANDARD.cruise_mps
    stop_share: float = STANDARD.stop_share
    stop_s: tuple[float, float] = STOP_S
    off_road_share: float = 0.3
    leaves_within_m: tuple[float, float] = (-4.0, 25.0)
    aside_m: tuple[float, float] = EXCURSION_ASIDE_M
    along_m: tuple[float, float] = EXCURSION_ALONG_M
    slows_off_road: bool = False
    held_up_share: float = 0.2
    acceleration_noise_mps2: float = 0.8
    acceleration_noise_s: float = 1.0
    place_sigma_m: float = 0.4
    heading_sigma_rad: float = 0.08
    acceleration_sigma_mps2: float = 0.6


class _Guesses(SimpleNamespace):
    """K guesses of the car's further drive. Every attribute is an array (K,)."""

    def chosen(self, index: NDArray[np.int64]) -> _Guesses:
        return _Guesses(**{name: values[index] for name, values in vars(self).items()})

    def aside_share(self, arc_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the sideways share (..., K) of a way off the road at arc lengths (..., K)."""
        return aside_share(arc_m, self.leave_m, self.along_m)


class OracleMap:
    """Answers with the truth while any of the car is in the picture; outside with guesses from the map and the exit.

    A guess is a route over the graph (branching at every crossing), a driver's speeds on it (slowing for bends,
    halts at crossings, held up by others) and perhaps a way off the road. Guesses are weighted once, by the likelihood
    of place, heading and acceleration at the exit. The estimate is their geometric median.
    """

    Parameters = OracleParameters

    def __init__(self, parameters: OracleParameters, road_map: RoadMap, target: str, rng: np.random.Generator) -> None:
        """``target``: name of the car."""
        self._parameters, self._map, self._target, self._rng = parameters, road_map, target, rng
        self._poses: list[NDArray[np.float64]] = []
        self._speeds: list[float] = []
        self._time_s = 0.0
        self._guesses: _Guesses | None = None

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """Keep the state on the first frame."""
        self._remember(frame.truth)
        return given(start)

    def update(self, frame: Frame) -> Estimate:
        """Return the car's place from the truth or from the guesses."""
        truth = frame.truth
        passed_s = truth.time_s - self._time_s
        target = truth.index_of(self._target)
        if truth.state[target] != "out":
            self._guesses = None
            self._remember(truth)
            return Estimate(
                truth.position_px[target].copy(),
                truth.box_xyxy[target].copy(),
                in_view_probability=float(truth.visible_fraction[target]),
            )
        if self._guesses is None:
            # The state at the exit is that of the first frame outside.
            self._remember(truth)
            self._fan = RouteFan(self._map, np.array(self._poses))
            self._guesses = self._first_guesses(passed_s)
        else:
            self._drive(self._guesses, passed_s)
        self._time_s = truth.time_s
        return self._estimate(frame, self._places(self._guesses))

    def _remember(self, truth: Truth) -> None:
        target = truth.index_of(self._target)
        self._poses.append(truth.T_world_object[target])
        self._speeds.append(float(truth.speed_mps[target]))
        self._time_s = truth.time_s

    def _first_guesses(self, frame_s: float) -> _Guesses:
        p, rng, fan = self._parameters, self._rng, self._fan
        count = p.particles * _PROPOSALS_PER_PARTICLE
        route = rng.choice(len(fan.prior), size=count, p=fan.prior)
        arc_m = fan.nearest_arc_m[route] + rng.normal(0.0, p.place_sigma_m, count)
        off_road = rng.random(count) < p.off_road_share
        leaves_in_m = rng.uniform(*p.leaves_within_m, count)
        held_up = rng.random(count) < p.held_up_share
        on_it = rng.random(count) < 0.5
        halts = rng.random(count) < p.stop_share
        fastest_seen = max(self._speeds)
        guesses = _Guesses(
            route=route,
            arc_m=arc_m,
            speed_mps=np.full(count, self._speeds[-1]),
            cruise_mps=rng.uniform(*p.cruise_mps, count).clip(fastest_seen),
            stop_at_m=np.where(halts, fan.next_crossing_m(route, arc_m), np.inf),
            wait_s=rng.uniform(*p.stop_s, count),
            leave_m=arc_m + np.where(on_it, rng.uniform(-p.along_m[1], 0.0, count), leaves_in_m),
            along_m=rng.uniform(*p.along_m, count),
            aside_m=rng.uniform(*p.aside_m, count) * rng.choice([-1.0, 1.0], count) * off_road,
            held_up_in_s=np.where(held_up, rng.uniform(0.0, _HELD_UP_WITHIN_S, count), np.inf),
            held_up_mps=rng.uniform(0.0, p.cruise_mps[1], count),
            noise_mps2=rng.normal(0.0, p.acceleration_noise_mps2, count),
        )
        log_weight = self._fit(guesses, frame_s)
        weight = np.exp(log_weight - log_weight.max())
        return guesses.chosen(rng.choice(count, size=p.particles, p=weight / weight.sum()))

    def _fit(self, guesses: _Guesses, frame_s: float) -> NDArray[np.float64]:
        """Return the log-likelihood (K,) of the state at the exit: place, heading and recent acceleration."""
        p, pose = self._parameters, self._poses[-1]
        distance_m = np.linalg.norm(self._places(guesses) - pose[:2, 3], axis=1)
        heading = np.arctan2(pose[1, 0], pose[0, 0])
        turned = np.angle(np.exp(1j * (self._headings(guesses) - heading)))
        recent = self._speeds[-_RECENT_FRAMES:]
        observed_mps2 = (recent[-1] - recent[0]) / (frame_s * max(len(recent) - 1, 1))
        misfit = (self._acceleration_mps2(guesses) - observed_mps2) / p.acceleration_sigma_mps2
        # Other cars make drivers brake where no route explains it: acceleration alone rules out no guess.
        by_acceleration = np.log(np.exp(-0.5 * misfit**2) + 0.02)
        return -0.5 * (distance_m / p.place_sigma_m) ** 2 - 0.5 * (turned / p.heading_sigma_rad) ** 2 + by_acceleration

    def _drive(self, guesses: _Guesses, passed_s: float) -> None:
        p = self._parameters
        kept = np.exp(-passed_s / p.acceleration_noise_s)
        fresh = self._rng.normal(0.0, p.acceleration_noise_mps2, len(guesses.arc_m))
        guesses.noise_mps2 = kept * guesses.noise_mps2 + np.sqrt(1.0 - kept**2) * fresh
        guesses.held_up_in_s = guesses.held_up_in_s - passed_s
        before = guesses.speed_mps
        moving = before > 0.1
        after = np.maximum(before + (self._acceleration_mps2(guesses) + guesses.noise_mps2 * moving) * passed_s, 0.0)
        guesses.arc_m = guesses.arc_m + 0.5 * (before + after) * passed_s
        guesses.speed_mps = after
        gap_m = guesses.stop_at_m - guesses.arc_m
        waiting = (after < HALTS_BELOW_MPS) & (gap_m < 2 * STANDSTILL_GAP_M)
        guesses.wait_s = guesses.wait_s - passed_s * waiting
        guesses.stop_at_m = np.where((guesses.wait_s <= 0) | (gap_m < -PASSED_STOP_M), np.inf, guesses.stop_at_m)

    def _acceleration_mps2(self, guesses: _Guesses) -> NDArray[np.float64]:
        """Return the intelligent driver model of the scenario: ``a = A (1 - (v / limit)^4 - (wanted gap / gap)^2)``."""
        limit = np.minimum(self._fan.limit_mps(guesses.route, guesses.arc_m), guesses.cruise_mps)
        if self._parameters.slows_off_road:
            limit = np.minimum(limit, _aside_limit_mps(guesses))
        limit = np.where(guesses.held_up_in_s <= 0, np.minimum(limit, guesses.held_up_mps), limit)
        wanted_m = STANDSTILL_GAP_M + guesses.speed_mps * TIME_GAP_S
        free_m = np.maximum(guesses.stop_at_m - guesses.arc_m, 0.0) + STANDSTILL_GAP_M
        share = (guesses.speed_mps / np.maximum(limit, 0.5)) ** 4 + (wanted_m / free_m) ** 2
        return np.clip(ACCELERATION_MPS2 * (1 - share), -HARDEST_BRAKING_MPS2, ACCELERATION_MPS2)

    def _places(self, guesses: _Guesses) -> NDArray[np.float64]:
        place, heading = self._fan.at(guesses.route, guesses.arc_m)
        left = np.column_stack([-np.sin(heading), np.cos(heading)])
        return place + (guesses.aside_m * guesses.aside_share(guesses.arc_m))[:, None] * left

    def _headings(self, guesses: _Guesses) -> NDArray[np.float64]:
        _, heading = self._fan.at(guesses.route, guesses.arc_m)
        rise = guesses.aside_share(guesses.arc_m + 0.5) - guesses.aside_share(guesses.arc_m - 0.5)
        return heading + np.arctan(guesses.aside_m * rise)

    def _estimate(self, frame: Frame, places_m: NDArray[np.float64]) -> Estimate:
        truth = frame.truth
        target = truth.index_of(self._target)
        height_m = truth.T_world_object[target, 2, 3] + 0.5 * truth.size_m[target, 2]
        best_m = geometric_median(places_m, np.full(len(places_m), 1.0 / len(places_m)), _MEDIAN_STEPS)
        points = np.column_stack([np.vstack([best_m, places_m]), np.full(len(places_m) + 1, height_m)])
        pixels, _ = project(frame.camera, truth.T_world_camera, points)
        return Estimate(pixels[0], in_view_probability=0.0, particles_px=pixels[1:])


def _aside_limit_mps(guesses: _Guesses) -> NDArray[np.float64]:
    """Return the speed (K,) that the bends of a way off the road allow, here and in reach of the brakes."""
    step = _BRAKING_REACH_M[1, 0] - _BRAKING_REACH_M[0, 0]
    ahead_m = guesses.arc_m + _BRAKING_REACH_M
    before, here, after = (guesses.aside_share(ahead_m + offset) for offset in (-step, 0.0, step))
    curvature = np.abs(guesses.aside_m * (before - 2 * here + after)) / step**2
    squared = np.maximum(LATERAL_ACCELERATION_MPS2 / np.maximum(curvature, 1e-6), SLOWEST_LIMIT_MPS**2)
    return np.sqrt((squared + 2 * BRAKING_MPS2 * _BRAKING_REACH_M).min(axis=0))


@dataclass(frozen=True, kw_only=True)
class MapOracle(TrackerSpec):
    """Knows the road graph and the state at the exit; gets no picture until the car is back."""

    role: str = "oracle"
    suites: tuple[str, ...] = ("frame-out",)
    module: str = OracleMap.__module__

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``."""
        assert named.scenario is not None
        return OracleMap(self.parameters, RoadMap(episode.map_of().graph), named.scenario.target, rng)


ORACLES = (
    MapOracle(
        name="oracle_map",
        summary="knows the road graph and the state at the exit; no picture until the car is back",
        parameters=OracleParameters(),
    ),
    MapOracle(
        name="oracle_driver",
        summary="oracle_map that also knows the driver model: an upper bound",
        parameters=OracleParameters(slows_off_road=True),
    ),
)
