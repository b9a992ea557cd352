"""Tracks a target of any kind in the picture: particles that the motion of the background carries along."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.correlation_filter.filter import CorrelationFilter, Match
from trackers.kernels.boxes import box_around, box_centre, box_size, inside_picture
from trackers.kernels.particles import geometric_median
from trackers.kernels.picture_motion import background_motion, moved_points
from trackers.mosaic_graph.match_odds import MatchOdds
from trackers.mosaic_graph.parameters import MosaicGraphParameters
from trackers.mosaic_graph.picture_model import SPEED_X, VISIBLE, Glance, PictureModel
from trackers.particle_filter import ParticleFilter, Posterior
from trackers.types import Estimate, Observation

_REACH_SIZES = 1.5
"""Half the side of the square in which one call of the filter finds the target."""
_MOST_SEARCHED, _LEFT_OUT = 8, 0.03
"""Most squares in a picture, and the share of the particles that need not lie in one."""
_HELD_SIZES, _HELD_MASS, _AWAY_S = 0.4, 0.5, 0.5
_ELSEWHERE_SIZES, _FIRST_LESSONS, _LESSON_FRAMES = 2.0, 8, 4
_TARGET_AND_RIM = 1.2
_MOST_GROWTH = 1.1
_LEAST_SIDE_PX, _LARGEST_SIDE = 2.0, 4.0
_WIDEST_PX = 480


class PictureTracker:
    """Looks with a correlation filter where the particles are, and holds the match around which they concentrate.

    A match elsewhere gives birth to particles, which must win against the present ones. The filter learns from the
    target that is held alone. While it is not, the particles spread with the target's last velocity over the
    background, also outside the picture.
    """

    def __init__(
        self,
        parameters: MosaicGraphParameters,
        rng: np.random.Generator,
        observation: Observation,
        box_xyxy: NDArray[np.float64],
    ) -> None:
        """Start the filter and the particles in a box (4,) of the first picture."""
        self._rng = rng
        self._redetects = parameters.use_redetection
        self._position_px, self._size_px = box_centre(box_xyxy), box_size(box_xyxy)
        self._look = CorrelationFilter(observation.image_rgb, box_xyxy)
        self._model = PictureModel(self._position_px, self._side_px, parameters.use_negative_information)
        self._filter = ParticleFilter(self._model, parameters.particles, rng)
        self._odds = MatchOdds()
        self._grey = _small_grey(observation.image_rgb)
        self._frame, self._time_s, self._unheld_s = 0, observation.time_s, 0.0
        for _ in range(_FIRST_LESSONS):
            self._learn_elsewhere(observation.image_rgb)

    def update(self, observation: Observation) -> Estimate:
        """Take in the next picture."""
        image_rgb = observation.image_rgb
        dt_s = max(observation.time_s - self._time_s, 1e-3)
        self._frame, self._time_s = self._frame + 1, observation.time_s
        motion = self._background_motion(image_rgb)
        searched_px = self._places(self._model.carry(self._filter.states, motion, dt_s), image_rgb)
        matches = [self._look.locate(image_rgb, place_px, self._scale) for place_px in searched_px]
        self._unheld_s += dt_s
        posterior = self._filter.step(
            Glance(
                dt_s=dt_s,
                unheld_s=self._unheld_s,
                motion=motion,
                picture_px=_extent_px(image_rgb),
                side_px=self._side_px,
                reach_px=_REACH_SIZES * self._side_px,
                searched_px=searched_px,
                found_px=np.array([match.position_px for match in matches]).reshape(-1, 2),
                log_ratios=np.array([self._odds.log_ratio(match.peak) for match in matches]),
            )
        )
        held = self._held(posterior, matches)
        if held is None:
            places = np.ascontiguousarray(posterior.states[:, :SPEED_X])
            self._position_px = geometric_median(places, posterior.weights, 8)
        else:
            self._hold(held, image_rgb)
        return self._answer(posterior, image_rgb)

    @property
    def _side_px(self) -> float:
        return float(np.sqrt(self._size_px.prod()))

    @property
    def _scale(self) -> float:
        """Size of the target relative to that of the first box."""
        return self._side_px / float(np.sqrt(self._look.size_px.prod()))

    def _background_motion(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Return the homography (3, 3) from the previous picture; the size of a target that is not held follows it."""
        (before, shrink_before), (now, shrink) = self._grey, _small_grey(image_rgb)
        self._grey = now, shrink
        target_xyxy = shrink_before * box_around(self._position_px, _TARGET_AND_RIM * self._size_px)
        small = background_motion(before, now, target_xyxy)
        motion = np.diag([1.0 / shrink, 1.0 / shrink, 1.0]) @ small @ np.diag([shrink_before, shrink_before, 1.0])
        if self._unheld_s > 0:
            corners_px = moved_points(motion, self._position_px + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
            growth = np.sqrt(abs(np.linalg.det(corners_px[1:] - corners_px[0])))
            self._resize(float(np.clip(growth, 1.0 / _MOST_GROWTH, _MOST_GROWTH)), image_rgb)
        return motion

    def _resize(self, growth: float, image_rgb: NDArray[np.uint8]) -> None:
        limits_px = _LEAST_SIDE_PX, _LARGEST_SIDE * max(_extent_px(image_rgb))
        self._size_px = self._size_px * (float(np.clip(growth * self._side_px, *limits_px)) / self._side_px)

    def _places(self, expected: NDArray[np.float64], image_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Return the middles (K, 2) of squares that hold nearly all expected states in the picture.

        While the target is not held there is one more, drawn from the whole picture.
        """
        left_px = expected[inside_picture(expected[:, :SPEED_X], *_extent_px(image_rgb)), :SPEED_X]
        places: list[NDArray[np.float64]] = []
        while len(left_px) > _LEFT_OUT * len(expected) and len(places) < _MOST_SEARCHED:
            place_px = left_px[self._rng.integers(len(left_px))]
            if not places:
                place_px = geometric_median(np.ascontiguousarray(left_px), np.ones(len(left_px)), 8)
            places.append(place_px)
            left_px = left_px[np.abs(left_px - place_px).max(axis=1) > _REACH_SIZES * self._side_px]
        if self._redetects and self._unheld_s > 0:
            places.append(self._anywhere(image_rgb))
        return np.array(places).reshape(-1, 2)

    def _anywhere(self, image_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
        return self._rng.uniform(0.0, _extent_px(image_rgb))

    def _held(self, posterior: Posterior, matches: list[Match]) -> Match | None:
        """Return the match around which the visible particles concentrate, if there is one.

        After a while without the target only a match as good as usual counts: others that are alike come by.
        """
        for match in matches:
            if self._unheld_s > _AWAY_S and not self._odds.is_usual(match.peak):
                continue
            away_px = np.linalg.norm(posterior.states[:, :SPEED_X] - match.position_px, axis=1)
            near = (away_px < _HELD_SIZES * self._side_px) & (posterior.states[:, VISIBLE] > 0)
            if posterior.weights[near].sum() > _HELD_MASS:
                return match
        return None

    def _hold(self, held: Match, image_rgb: NDArray[np.uint8]) -> None:
        """Take a match for the target, and learn from it; how the target looks, while it is not partly hidden."""
        self._position_px, self._unheld_s = held.position_px, 0.0
        self._size_px = held.scale * self._look.size_px
        self._resize(1.0, image_rgb)
        if self._odds.is_usual(held.peak):
            self._look.update(image_rgb, box_around(self._position_px, self._size_px))
        self._odds.learn_target(held.peak)
        if self._frame % _LESSON_FRAMES == 0:
            self._learn_elsewhere(image_rgb)

    def _learn_elsewhere(self, image_rgb: NDArray[np.uint8]) -> None:
        """Learn how well something else matches, at a place drawn from the picture, if it is not near the target."""
        place_px, apart_px = self._anywhere(image_rgb), _ELSEWHERE_SIZES * self._side_px
        if np.linalg.norm(place_px - self._position_px) > apart_px:
            match = self._look.locate(image_rgb, place_px, self._scale)
            if np.linalg.norm(match.position_px - self._position_px) > 0.5 * apart_px:
                self._odds.learn_other(match.peak)

    def _answer(self, posterior: Posterior, image_rgb: NDArray[np.uint8]) -> Estimate:
        particles_px = posterior.states[:, :SPEED_X].copy()
        in_view = inside_picture(particles_px, *_extent_px(image_rgb)) & (posterior.states[:, VISIBLE] > 0)
        return Estimate(
            position_px=self._position_px.copy(),
            box_xyxy=box_around(self._position_px, self._size_px),
            in_view_probability=float(np.clip(posterior.weights[in_view].sum(), 0.0, 1.0)),
            particles_px=particles_px,
            weights=posterior.weights,
        )


def _extent_px(image_rgb: NDArray[np.uint8]) -> tuple[int, int]:
    """Return width and height of a picture."""
    return image_rgb.shape[1], image_rgb.shape[0]


def _small_grey(image_rgb: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], float]:
    """Return the grey picture, at most 480 pixels long, and its size over that of the picture."""
    shrink = min(1.0, _WIDEST_PX / max(_extent_px(image_rgb)))
    grey = cv2.cvtColor(image_rgb, cv2.COLOR_RGB2GRAY)
    size = tuple(max(round(shrink * side), 1) for side in _extent_px(image_rgb))
    return (grey if shrink == 1.0 else cv2.resize(grey, size, interpolation=cv2.INTER_AREA)), shrink
