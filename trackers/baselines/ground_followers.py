"""Baselines on the ground: the last place seen, and constant velocity, with the camera's motion taken out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.baselines.ground_looks import ColourLook, Look, Patch, TemplateLook
from trackers.baselines.ground_search import CELLS, GroundSearch, SearchParameters
from trackers.kernels.boxes import box_centre
from trackers.light_adaptive_stereo.person_kalman import PersonKalman
from trackers.registry import register, tunable
from trackers.types import Estimate, Observation

_COLOUR_SHARE, _TEMPLATE_SHARE = 0.45, 0.6
"""Side of the compared square, in lengths of the car."""
_SPEED_MPS = 5.0
"""Standard deviation, per axis, of a velocity that is not known yet. Chosen: nearly all of a town's traffic, at up to
50 km/h, is within three."""
_MOST_SPREAD_M = 6.0
"""Most that the prediction's spread adds to the search radius. Chosen: more than a car's length, less than two."""


def _colour_look(patch: Patch) -> Look:
    return ColourLook(patch, round(_COLOUR_SHARE * CELLS))


def _template_look(patch: Patch) -> Look:
    return TemplateLook(patch, round(_TEMPLATE_SHARE * CELLS), round(_COLOUR_SHARE * CELLS))


@dataclass(frozen=True)
class HoldGroundParameters(SearchParameters):
    """Settings of ``hold_ground``.

    Attributes:
        fastest_mps: once the car is lost, the search radius grows at this speed, from the last match on. Chosen, about
            the 50 km/h that are usual in towns.
    """

    fastest_mps: float = tunable(15.0, 5.0, 40.0)


@register("hold_ground", role="baseline", summary="keeps the place on the ground where the car was last matched")
class HoldGround:
    """Returns the best match of the car's HS histogram, or the last matched place on the ground if there is none.

    It is given what ``mosaic_graph_pf`` is: pictures, first box and measured poses; without poses the picture's motion
    is estimated (``picture_motion``). A lost car is looked for within a radius that grows with time (``GroundSearch``).
    """

    Parameters = HoldGroundParameters

    def __init__(self, parameters: HoldGroundParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Take the look from the box."""
        self._search = GroundSearch(observation, box_xyxy, _colour_look, self._parameters)
        self._place_m, self._time_s = self._search.start_m, observation.time_s

    def update(self, observation: Observation) -> Estimate:
        """Return the best match, or the last one; NaN while the measured pose shows no ground."""
        seconds, self._time_s = max(observation.time_s - self._time_s, 0.0), observation.time_s
        if not self._search.follow(observation, seconds):
            return Estimate(np.full(2, np.nan))
        slack_m = self._parameters.fastest_mps * self._search.missed_s if self._search.is_lost else 0.0
        match = self._search.match(observation.image_rgb, self._place_m, slack_m)
        if match is not None:
            self._place_m = match.place_m
        box = self._search.box_xyxy(self._place_m)
        return Estimate(box_centre(box), box, in_view_probability=float(match is not None))


@dataclass(frozen=True)
class ConstantVelocityGroundParameters(SearchParameters):
    """Settings of ``constant_velocity_ground``.

    Attributes:
        acceleration_mps2: standard deviation of the acceleration along each axis.
        match_noise_m: standard deviation of a match.
        hardest_mps2: greatest acceleration a: ``a t² / 2`` and two deviations of the prediction are added to the search
            radius, t after the last match. Chosen for the growth of the radius, not as what cars can do.
    """

    acceleration_mps2: float = tunable(2.5, 0.3, 10.0, log=True)
    match_noise_m: float = tunable(0.5, 0.1, 2.0, log=True)
    hardest_mps2: float = tunable(5.0, 1.0, 15.0, log=True)


@register(
    "constant_velocity_ground",
    role="baseline",
    summary="Kalman filter of constant velocity on the ground, HS histogram, re-detection in a radius that grows",
)
class ConstantVelocityGround:
    """State (x, y, vx, vy) in metres and m/s, white acceleration (``PersonKalman``); matches as ``hold_ground``.

    It is given what ``mosaic_graph_pf`` is, see ``HoldGround``. After a re-detection it goes on with the velocity of
    before. The posterior is the filter's Gaussian, taken to the picture by the projection's derivative.
    """

    Parameters = ConstantVelocityGroundParameters
    _look = staticmethod(_colour_look)

    def __init__(self, parameters: ConstantVelocityGroundParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start at the box with velocity zero."""
        self._search = GroundSearch(observation, box_xyxy, self._look, self._parameters)
        self._filter, self._time_s = self._filter_at(self._search.start_m, np.zeros(2)), observation.time_s

    def update(self, observation: Observation) -> Estimate:
        """Predict, search, correct by the match; NaN while the measured pose shows no ground."""
        seconds, self._time_s = max(observation.time_s - self._time_s, 0.0), observation.time_s
        self._filter.predict(seconds)
        if not self._search.follow(observation, seconds):
            return Estimate(np.full(2, np.nan))
        spread_m = float(np.sqrt(0.5 * self._filter.P[:2, :2].trace()))
        slack_m = min(2.0 * spread_m, _MOST_SPREAD_M) + 0.5 * self._parameters.hardest_mps2 * self._search.missed_s**2
        match = self._search.match(observation.image_rgb, self._filter.place_m, slack_m)
        if match is not None and match.was_lost:
            self._filter = self._filter_at(match.place_m, self._filter.velocity_mps)
        elif match is not None:
            self._filter.correct(match.place_m)
        return self._answer(match is not None)

    def _filter_at(self, place_m: NDArray[np.float64], velocity_mps: NDArray[np.float64]) -> PersonKalman:
        p = self._parameters
        result = PersonKalman(place_m, p.acceleration_mps2, p.match_noise_m)
        result.x[2:] = velocity_mps
        result.P[2:, 2:] = _SPEED_MPS**2 * np.eye(2)
        return result

    def _answer(self, seen: bool) -> Estimate:
        box = self._search.box_xyxy(self._filter.place_m)
        J = self._search.view.derivative(self._filter.place_m)
        across, down = J @ self._filter.velocity_mps
        return Estimate(
            box_centre(box),
            box,
            heading_rad=float(np.arctan2(down, across)),
            in_view_probability=float(seen),
            covariance_px=J @ self._filter.P[:2, :2] @ J.T,
        )


@dataclass(frozen=True)
class TemplateGroundParameters(ConstantVelocityGroundParameters):
    """Settings of ``template_ground``, see ``ConstantVelocityGroundParameters``; similarities of ``TemplateLook``."""

    least_similarity: float = tunable(0.65, 0.2, 0.95)
    least_similarity_lost: float = tunable(0.82, 0.3, 0.95)


@register(
    "template_ground",
    role="baseline",
    summary="constant velocity on the ground, correlation with the car's first picture from above, re-detection",
)
class TemplateGround(ConstantVelocityGround):
    """``constant_velocity_ground`` that recognises the car by a template, turned to any heading, and by its colours
    (``TemplateLook``): grey cars on grey roads have weak colours, but windows and shadows.

    It is given what ``mosaic_graph_pf`` is, see ``HoldGround``.
    """

    Parameters = TemplateGroundParameters
    _look = staticmethod(_template_look)
