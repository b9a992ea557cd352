"""Tracks a car on the ground: a mosaic, its road graph, and particles that move on it, in view or not."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import WIDTH_TO_LENGTH, apparent_length_px, box_centre
from trackers.kernels.ground_camera import CAR_HEIGHT_M, CENTRE_HEIGHT_M, TYPICAL_LENGTH_M, GroundCamera
from trackers.kernels.particles import circular_mean, geometric_median
from trackers.mosaic_graph.detector import Detector, look_first
from trackers.mosaic_graph.kernels import road_motion as rm
from trackers.mosaic_graph.kernels import road_position as rp
from trackers.mosaic_graph.kernels.road_position import Roads
from trackers.mosaic_graph.mosaic import SHRINK, Mosaic, standing_ground
from trackers.mosaic_graph.motion_model import Birth, CarModel, Instant
from trackers.mosaic_graph.parameters import MosaicGraphParameters
from trackers.mosaic_graph.registration import Registered, Registration
from trackers.mosaic_graph.road_network import NO_ROADS
from trackers.mosaic_graph.sightings import FASTEST_MPS, LastSeen, Sighting, Sightings, may_be_target, renewal, surprise
from trackers.particle_filter import ParticleFilter, Posterior
from trackers.types import Estimate, Observation

_SHORTEST_M, _LONGEST_M = 3.2, 7.0
_LEAST_LENGTH_PX = 2.0
_REDRAW_FRAMES = 10
_DRIVEN_DELAY_FRAMES = 18
_LOCK_RADIUS_M, _LOCK_MASS = 2.5, 0.8
_VAGUE_IF_CUT = 0.25
_SURE_FRAMES = 4
_LOOK_AT_PARTICLES = 4
_SHAPE_RATE, _SURE_LOG_RATIO = 0.04, 2.0
_SHARE_OF_OTHERS = 0.25


class RoadSource(Protocol):
    """Where roads come from, see ``RoadFinder``, which is one.

    Attributes:
        has_learnt: whether it knows roads; if not, it is told that those before and behind the car are.
    """

    @property
    def has_learnt(self) -> bool: ...

    def learn(self, driven_m: NDArray[np.float64]) -> None:
        """Take in a map point (2,) that the target has left."""
        ...

    def draw(self, mosaic: Mosaic, centre_m: NDArray[np.float64]) -> Roads:
        """Return the roads about a map point (2,)."""
        ...


class MapTracker:
    """Tracks a car in coordinates of the ground, which the mosaic defines.

    It learns online the colours of roads, the side of the traffic and the place of its lane, the target's usual speed
    and style of driving, and looks; ``Habits`` names the sources of what it assumes at first.
    """

    def __init__(
        self,
        parameters: MosaicGraphParameters,
        rng: np.random.Generator,
        observation: Observation,
        box_xyxy: NDArray[np.float64],
        road_source: RoadSource,
    ) -> None:
        """Start the mosaic with the first picture, and the particles in the box (4,).

        Args:
            road_source: draws the roads.
        """
        self._p = p = parameters
        self._rng = rng
        model = observation.camera
        longest_px = max(float(np.hypot(model.width_px, model.height_px)), _LEAST_LENGTH_PX)
        length_px = float(np.clip(apparent_length_px(box_xyxy), _LEAST_LENGTH_PX, longest_px))
        self._registration = Registration(
            observation, box_centre(box_xyxy), TYPICAL_LENGTH_M / length_px, use_ego=p.use_ego, use_mosaic=p.use_mosaic
        )
        first, camera = self._registration.first, self._registration.camera
        metres_per_pixel = camera.metres_per_pixel()
        length_m = float(np.clip(length_px * metres_per_pixel, _SHORTEST_M, _LONGEST_M))
        self._size_m = (length_m, WIDTH_TO_LENGTH * length_m)
        self._detector = Detector(self._size_m, p.candidates)
        target = look_first(self._detector, first, box_xyxy, length_m)
        self._car = self._model(target.position_m, target.axis_rad)
        self._filter = ParticleFilter(self._car, p.particles, self._rng)
        self._mosaic = Mosaic(SHRINK * metres_per_pixel)
        self._mosaic.add(first.small_rgb, camera, standing_ground(camera, None, target.position_m, length_m))
        self._road_source = road_source
        self._roads = NO_ROADS
        self._sightings = Sightings()
        self._driven: deque[NDArray[np.float64]] = deque([target.position_m], maxlen=_DRIVEN_DELAY_FRAMES)
        self._frame, self._time_s = 0, observation.time_s
        self._last = LastSeen(target.position_m, FASTEST_MPS, 0.0)
        self._target: Sighting | None = None
        self._held_frames = 0

    @property
    def camera(self) -> GroundCamera:
        """Pose of the camera on the map at the latest picture that showed ground."""
        return self._registration.camera

    def correct(self, position_m: NDArray[np.float64], heading_rad: float, speed_mps: float) -> None:
        """Move the particles to a place (2,) on the map, heading and speed that are known from elsewhere.

        What they assume of the driver stays.
        """
        self._filter.states = self._car.moved_to(
            self._filter.states, position_m, heading_rad, speed_mps, self._roads, self._rng
        )
        self._last = LastSeen(position_m, speed_mps, 0.0)

    def update(self, observation: Observation) -> Estimate:
        """Take in the next picture."""
        dt_s = max(observation.time_s - self._time_s, 1e-3)
        self._frame, self._time_s = self._frame + 1, observation.time_s
        self._last = replace(self._last, since_s=self._last.since_s + dt_s)
        registered = self._registration.register(observation, self._mosaic)
        if registered is None:
            return self._drive_on(dt_s)
        cues = self._detector.cues(registered)
        candidates = self._detector.search(registered, cues, self._expected(dt_s))
        self._sightings.update(candidates, dt_s)
        new_roads = self._draw_roads()
        posterior = self._filter.step(self._instant(dt_s, registered.camera, new_roads))
        position_m = geometric_median(np.ascontiguousarray(posterior.states[:, : rp.Y + 1]), posterior.weights, 8)
        target = self._locked(posterior, position_m)
        self._held_frames = self._held_frames + 1 if target is not None and target is self._target else 0
        self._target = target
        self._learn(registered, posterior, target, dt_s)
        place_m = None if target is None else target.position_m
        standing = standing_ground(registered.camera, cues.difference, place_m, self._size_m[0])
        self._mosaic.add(registered.small_rgb, registered.camera, standing)
        if target is not None:
            position_m = target.candidate.position_m
        return _answer(registered.camera, posterior, position_m, self._size_m)

    def _drive_on(self, dt_s: float) -> Estimate:
        """Predict the particles for a picture without ground; the estimate has no position in it."""
        self._sightings.update([], dt_s)
        self._filter.step(self._instant(dt_s, None, False))
        self._target, self._held_frames = None, 0
        return Estimate(np.full(2, np.nan))

    def _model(self, start_m: NDArray[np.float64], axis_rad: float) -> CarModel:
        p = self._p
        habits = rm.Habits(
            cruise_spread_mps=p.cruise_spread_mps,
            cruise_rate=p.cruise_rate,
            urge_spread=p.urge_spread_mps2,
            curve_spread_per_m=p.curve_spread_per_m,
            unseen_turns_per_m=p.unseen_turns_per_m,
            speed_noise=p.speed_noise,
            leave_rate=p.leave_rate,
            turn_weight=p.turn_weight,
        )
        return CarModel(
            start_m,
            axis_rad,
            habits,
            born_share=0.1,
            detection_probability=p.detection_probability,
            miss_counts=p.use_negative_information,
            detection_deviation_m=p.detection_deviation_m,
            border_m=0.5 * self._size_m[0],
        )

    def _expected(self, dt_s: float) -> list[tuple[NDArray[np.float64], float]]:
        """Return expected places (2,) and headings: of the mean particle, of sightings; if lost, of some particles."""
        states = self._filter.states
        places = self._sightings.expected(dt_s)
        if np.linalg.norm(states[:, : rp.Y + 1].std(axis=0)) < _LOCK_RADIUS_M:
            heading = self._mean_heading()
            velocity = states[:, rp.SPEED].mean() * np.array([np.cos(heading), np.sin(heading)])
            places.insert(0, (states[:, : rp.Y + 1].mean(axis=0) + dt_s * velocity, heading))
        if self._target is None:
            some = states[self._rng.integers(len(states), size=_LOOK_AT_PARTICLES)]
            places += [(state[: rp.Y + 1], float(state[rp.HEADING])) for state in some]
        return places

    def _instant(self, dt_s: float, camera: GroundCamera | None, new_roads: bool) -> Instant:
        seen = self._sightings.seen()
        return Instant(
            dt_s=dt_s,
            camera=camera,
            roads=self._roads,
            roads_are_new=new_roads,
            candidates_m=np.array([s.candidate.position_m for s in seen]).reshape(-1, 2),
            axes_rad=np.array([s.candidate.axis_rad if s.candidate.is_whole else np.nan for s in seen]),
            log_ratios=np.array([s.log_ratio if s is self._target else s.news for s in seen]),
            vague_m=np.array([_VAGUE_IF_CUT * (1.0 - s.candidate.covered) * self._size_m[0] for s in seen]),
            births=self._births(seen),
        )

    def _births(self, seen: list[Sighting]) -> tuple[Birth, ...]:
        """Return births on the target's sighting, and on others that may be the target."""
        births = []
        if self._target in seen and self._target.candidate.is_whole:
            births.append(renewal(self._target, self._mean_heading(), self._p.renewal))
        if self._p.use_redetection:
            others = [s for s in seen if s is not self._target and may_be_target(s, self._last)]
            births += [surprise(s, self._last, self._p.surprise) for s in others]
        return tuple(births)

    def _mean_heading(self) -> float:
        headings_rad = self._filter.states[:, rp.HEADING]
        return circular_mean(headings_rad, np.full(len(headings_rad), 1.0 / len(headings_rad)))

    def _draw_roads(self) -> bool:
        """Redraw the roads on every tenth picture; return whether they were redrawn."""
        if not self._p.use_roads or self._frame % _REDRAW_FRAMES != 5:
            return False
        states = self._filter.states
        position_m = states[:, : rp.Y + 1].mean(axis=0)
        if not self._road_source.has_learnt:
            heading = self._mean_heading()
            along = np.array([np.cos(heading), np.sin(heading)])
            for ahead_m in (-1.0, 1.0):
                self._road_source.learn(position_m + ahead_m * (0.5 * self._size_m[0] + 2.0) * along)
        self._roads = self._road_source.draw(self._mosaic, position_m)
        return True

    def _locked(self, posterior: Posterior, position_m: NDArray[np.float64]) -> Sighting | None:
        """Return the sighting around which the particles concentrate, if there is one."""
        offset = posterior.states[:, : rp.Y + 1] - position_m
        near = np.hypot(offset[:, 0], offset[:, 1]) < _LOCK_RADIUS_M
        if posterior.weights[near].sum() < _LOCK_MASS:
            return None
        sighting = self._sightings.nearest(position_m, 0.5 * self._size_m[0])
        return sighting if sighting is not None and sighting.log_ratio > 0 else None

    def _learn(self, registered: Registered, posterior: Posterior, target: Sighting | None, dt_s: float) -> None:
        if target is not None:
            speed_mps = float(np.linalg.norm(target.velocity_mps))
            if self._held_frames >= _SURE_FRAMES:
                self._last = LastSeen(target.position_m, speed_mps, 0.0)
            self._sightings.rule_out_others(target)
            self._car.learn_speed(speed_mps, dt_s)
            self._learn_lane(target)
            on_road = float(posterior.weights @ posterior.states[:, rp.ON_ROAD])
            left_m = self._driven[0]
            if np.linalg.norm(left_m - target.position_m) > self._size_m[0] and (
                on_road > 0.5 or not self._roads.graph.edge_count
            ):
                self._road_source.learn(left_m)
            self._driven.append(target.position_m)
            self._detector.likeness.learn_target(target.candidate.measures)
            for other in self._sightings.seen():
                if other is not target:
                    self._detector.likeness.learn_rest(other.candidate.measures)
            seen = target.candidate
            if seen.log_ratio > _SURE_LOG_RATIO:
                self._detector.learn(registered, seen.position_m, seen.axis_rad, _SHAPE_RATE)
        if self._frame % 5 == 0:
            self._detector.learn_rest(registered, None if target is None else target.position_m)

    def _learn_lane(self, target: Sighting) -> None:
        """Learn the lane from the target, and from others that move: they keep to the same side."""
        for sighting in self._sightings.seen():
            if sighting is target and self._held_frames >= _SURE_FRAMES:
                self._car.learn_lane(sighting.position_m, sighting.velocity_mps, self._roads, 1.0)
            elif sighting is not target and sighting.age > _SURE_FRAMES:
                self._car.learn_lane(sighting.position_m, sighting.velocity_mps, self._roads, _SHARE_OF_OTHERS)


def _answer(
    camera: GroundCamera, posterior: Posterior, position_m: NDArray[np.float64], size_m: tuple[float, float]
) -> Estimate:
    """Return the estimate of a car of ``size_m`` (length, width) at ``position_m`` (2,) on the map.

    The probability of being in view is the weight of the particles inside the picture: a missing detection there has
    already reduced it.
    """
    states, weights = posterior.states, posterior.weights
    heading_rad = circular_mean(states[:, rp.HEADING], weights)
    particles_px = camera.to_picture(states[:, : rp.Y + 1], CENTRE_HEIGHT_M)
    # Particles behind a tilted camera have no pixel.
    ahead = np.isfinite(particles_px).all(axis=1)
    size_px = np.array([camera.model.width_px, camera.model.height_px])
    inside = ahead & (particles_px >= 0).all(axis=1) & (particles_px <= size_px).all(axis=1)
    along = np.array([np.cos(heading_rad), np.sin(heading_rad)])
    ends_px = camera.to_picture(np.stack([position_m, position_m + along]), CENTRE_HEIGHT_M)
    direction_px = ends_px[1] - ends_px[0]
    box_xyxy = _box_px(camera, position_m, heading_rad, size_m)
    kept = weights * ahead
    has_particles = kept.sum() > 0
    return Estimate(
        position_px=ends_px[0],
        box_xyxy=box_xyxy if np.isfinite(box_xyxy).all() else None,
        heading_rad=float(np.arctan2(direction_px[1], direction_px[0])) if np.isfinite(direction_px).all() else None,
        in_view_probability=float(np.clip(weights[inside].sum(), 0.0, 1.0)),
        particles_px=particles_px[ahead] if has_particles else None,
        weights=kept[ahead] / kept.sum() if has_particles else None,
    )


def _box_px(
    camera: GroundCamera, position_m: NDArray[np.float64], heading_rad: float, size_m: tuple[float, float]
) -> NDArray[np.float64]:
    """Return the amodal box (4,) of a car at a place on the map."""
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    corners = 0.5 * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * np.array(size_m)
    on_map = corners @ np.array([[c, s], [-s, c]]) + position_m
    pixels = np.vstack([camera.to_picture(on_map, height_m) for height_m in (0.0, CAR_HEIGHT_M)])
    return np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])
