"""The belief about one target during one episode: each estimate is projected onto the ground, then filtered."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.belief.kernel import BELIEF, SIGHTING, densest_window, update_beliefs
from trackers.types import CameraModel, Estimate, Looks, Observation, SteeredCamera

_ASSUMED_HEIGHT_M = 60.0
"""Height of a camera that looks down, where no pose is measured."""
ASSUMED_DISTANCE_M = 3.0
"""Distance of a target from a camera that looks ahead if the tracker measures no depth, and of its axis' point."""
FARTHEST_M = 500.0
"""Limit of distances on the ground; rays at or above the horizon get this one."""
_FARTHEST_PX, _LOWEST_M = 1e9, 0.1
_TRIES = 24
_AHEAD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
_DOWN = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""R_world_camera of a level camera with the heading 0."""


def _within_reach(pixels: object) -> list[float]:
    """Return pixels or lengths in pixels, clipped so that arithmetic with them stays finite; NaN stays."""
    numbers = np.asarray(pixels, dtype=float).ravel().tolist()
    return [min(max(number, -_FARTHEST_PX), _FARTHEST_PX) for number in numbers]


def sighting_of(looks: Looks, observation: Observation, estimate: Estimate) -> NDArray[np.void]:
    """Return the sighting (1,) of dtype ``SIGHTING`` of an estimate; the ground is z = 0.

    If the steered camera is not the watched one, picture and halves are those of the steered camera; the estimate is
    projected there over the ground, and unknown unless both poses are measured.
    """
    sighting = np.zeros(1, SIGHTING)
    record: Any = sighting[0]
    steered = observation.steered
    watched = _view(observation, looks if steered is None else "around")
    own = watched if steered is None else _view(steered, looks)
    _set_carrier(record, looks, own)
    x_px, y_px = _within_reach(estimate.position_px)
    linked = steered is None or (observation.ego is not None and steered.ego is not None)
    if not linked or math.isnan(x_px) or math.isnan(y_px):
        return sighting
    half_x_px, half_y_px = watched.half_px.tolist()
    right, down = (x_px - half_x_px) / half_x_px, (y_px - half_y_px) / half_y_px
    record["picture_x"], record["picture_y"] = right, down
    probability = estimate.in_view_probability
    inside = float(max(abs(right), abs(down)) <= 1.0)
    record["in_view_probability"] = inside if probability is None else probability
    focal_px = watched.camera.focal_px
    tangents = np.array([[(x_px - half_x_px) / focal_px, (y_px - half_y_px) / focal_px]])
    if watched.sees_ground:
        offset_m = _on_ground(watched.R, watched.height_m, tangents)[0]
        record["depth_m"] = _ground_depth_m(watched.height_m, float(watched.R[2] @ np.append(tangents, 1.0)))
        level = looks == "down" and steered is None
        reach_m = watched.height_m if level else float(np.hypot(np.hypot(*offset_m), watched.height_m))
    else:
        reach_m = record["depth_m"] = min(estimate.depth_m or ASSUMED_DISTANCE_M, FARTHEST_M)
        offset_m = (watched.R @ (reach_m * np.append(tangents, 1.0)))[:2]
    metres_per_pixel = reach_m / focal_px
    record["known"] = record["densest_share"] = 1.0
    record["x_m"], record["y_m"] = record["densest_x_m"], record["densest_y_m"] = (watched.place_m + offset_m).tolist()
    if estimate.box_xyxy is not None:
        x_min, y_min, x_max, y_max = _within_reach(estimate.box_xyxy)
        record["length_share"] = max(x_max - x_min, y_max - y_min) / watched.camera.width_px
    if steered is not None:
        _set_picture(record, own, metres_per_pixel * watched.camera.width_px)
    if estimate.covariance_px is not None:
        xx, _, _, yy = _within_reach(estimate.covariance_px)
        record["spread_m"] = metres_per_pixel * math.sqrt(0.5 * (xx + yy))
    if estimate.particles_px is not None and len(estimate.particles_px) > 0 and watched.sees_ground:
        _summarise(record, estimate, watched)
    return sighting


class _View(NamedTuple):
    """A camera with its orientation R_world_camera (3, 3), position (2,) and height, measured or assumed.

    Attributes:
        half_px: half the picture's size (2,), which is its centre too.
    """

    camera: CameraModel
    half_px: NDArray[np.float64]
    R: NDArray[np.float64]
    place_m: NDArray[np.float64]
    height_m: float
    sees_ground: bool


def _view(source: Observation | SteeredCamera, looks: Looks) -> _View:
    """Return a camera with its measured pose, or a level one."""
    half_px = 0.5 * np.array([source.camera.width_px, source.camera.height_px])
    if source.ego is None:
        assumed = (_DOWN, np.zeros(2), _ASSUMED_HEIGHT_M) if looks == "down" else (_AHEAD, np.zeros(2), 0.0)
        return _View(source.camera, half_px, *assumed, looks == "down")
    T = source.ego.T_world_camera
    height_m = float(T[2, 3]) if looks == "ahead" else max(float(T[2, 3]), _LOWEST_M)
    return _View(source.camera, half_px, T[:3, :3], T[:2, 3], height_m, looks != "ahead")


def _set_carrier(record: Any, looks: Looks, own: _View) -> None:
    """Set the carrier's pose and the optical axis' point on the ground."""
    (_, x_down, x_ahead), (_, y_down, y_ahead), (_, _, z_ahead) = own.R.tolist()
    # The optical axis in the ground plane; for one that looks around at any tilt.
    x, y = x_ahead, y_ahead
    if looks == "down":
        x, y = -x_down, -y_down
    elif looks == "around":
        x, y = x_ahead + z_ahead * x_down, y_ahead + z_ahead * y_down
    heading_rad = np.arctan2(y, x)
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    record["carrier_x_m"], record["carrier_y_m"] = own.place_m.tolist()
    record["height_m"], record["heading_rad"] = own.height_m, heading_rad
    reach_m = own.height_m if looks == "down" else 1.0
    if own.sees_ground:
        scale = own.height_m / max(-z_ahead, own.height_m / FARTHEST_M)
        x_m, y_m = x_ahead * scale, y_ahead * scale
        record["axis_ahead_m"], record["axis_right_m"] = c * x_m + s * y_m, s * x_m - c * y_m
        record["axis_depth_m"] = _ground_depth_m(own.height_m, z_ahead)
        if looks == "around":
            reach_m = float(np.hypot(np.hypot(x_m, y_m), own.height_m))
    else:
        record["axis_ahead_m"] = record["axis_depth_m"] = ASSUMED_DISTANCE_M
        if looks == "around":
            reach_m = ASSUMED_DISTANCE_M
    half_x_px, half_y_px = own.half_px.tolist()
    record["half_right_m"] = reach_m * half_x_px / own.camera.focal_px
    record["half_ahead_m"] = reach_m * half_y_px / own.camera.focal_px


def _set_picture(record: Any, own: _View, width_m: float) -> None:
    """Set the target's position in the steered camera's picture; the watched one is ``width_m`` wide at the target."""
    offset_m = np.array([*(np.array([record["x_m"], record["y_m"]]) - own.place_m), -own.height_m])
    seen_m = offset_m @ own.R
    # Points beside or behind the camera are far outside the picture, on the side to turn to.
    depth_m = max(float(seen_m[2]), 1e-3 * float(np.linalg.norm(seen_m)), 1e-9)
    record["picture_x"], record["picture_y"] = seen_m[:2] / depth_m * own.camera.focal_px / own.half_px
    record["length_share"] *= width_m / (2.0 * depth_m * own.half_px[0] / own.camera.focal_px)


def _on_ground(R: NDArray[np.float64], height_m: float, tangents: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where rays (N, 2), tangents of angles right and down, meet the ground (N, 2), from below the camera."""
    return _met(tangents @ R[:, :2].T, R[:, 2], height_m, np.zeros(2))


@njit(cache=True)
def _met(
    rays: NDArray[np.float64], axis: NDArray[np.float64], height_m: float, below_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return where rays (N, 3), which lack the optical axis (3,), meet the ground (N, 2) around ``below_m`` (2,)."""
    places_m = np.empty((len(rays), 2))
    for n in range(len(rays)):
        scale = height_m / max(-(rays[n, 2] + axis[2]), height_m / FARTHEST_M)
        places_m[n, 0] = below_m[0] + (rays[n, 0] + axis[0]) * scale
        places_m[n, 1] = below_m[1] + (rays[n, 1] + axis[1]) * scale
    return places_m


@njit(cache=True)
def _tangents(
    particles_px: NDArray[np.float64], half_px: NDArray[np.float64], focal_px: float
) -> tuple[NDArray[np.float64], bool]:
    """Return the tangents (N, 2) of angles right and down, clipped as by ``_within_reach``, NaN of a particle that is
    not finite; and whether all are.
    """
    tangents, all_good = np.empty(particles_px.shape), True
    for n in range(len(particles_px)):
        good = np.isfinite(particles_px[n, 0]) and np.isfinite(particles_px[n, 1])
        all_good &= good
        for axis in range(2):
            clipped = min(max(particles_px[n, axis], -_FARTHEST_PX), _FARTHEST_PX)
            tangents[n, axis] = (clipped - half_px[axis]) / focal_px if good else np.nan
    return tangents, all_good


@njit(cache=True)
def _squares(places_m: NDArray[np.float64], mean_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the squared distances (N, 2) from a mean along both axes."""
    squares = np.empty_like(places_m)
    for n in range(len(places_m)):
        for axis in range(2):
            away_m = places_m[n, axis] - mean_m[axis]
            squares[n, axis] = away_m * away_m
    return squares


def _ground_depth_m(height_m: float, rise: float) -> float:
    """Return the distance along the camera's axis at which a ray that rises so much meets the ground, or infinity."""
    return height_m / -rise if rise < 0.0 else np.inf


def _summarise(record: Any, estimate: Estimate, watched: _View) -> None:
    """Set the posterior's standard deviation and its densest window."""
    assert estimate.particles_px is not None
    particles_px, count = np.ascontiguousarray(estimate.particles_px, dtype=float), len(estimate.particles_px)
    weights = np.full(count, 1.0 / count) if estimate.weights is None else np.ascontiguousarray(estimate.weights)
    tangents, all_finite = _tangents(particles_px, watched.half_px, watched.camera.focal_px)
    # Particles that are not finite are left out.
    if not all_finite:
        finite = ~np.isnan(tangents[:, 0])
        tangents, weights = tangents[finite], weights[finite]
        if not weights.sum() > 0.0:
            return
        weights = weights / weights.sum()
    particles_m = _met(tangents @ watched.R[:, :2].T, watched.R[:, 2], watched.height_m, watched.place_m)
    mean_m = weights @ particles_m
    x_variance_m2, y_variance_m2 = (weights @ _squares(particles_m, mean_m)).tolist()
    record["spread_m"] = math.sqrt(0.5 * (x_variance_m2 + y_variance_m2))
    half_m = min(record["half_ahead_m"], record["half_right_m"])
    window = densest_window(particles_m, weights, float(half_m), _TRIES)
    record["densest_x_m"], record["densest_y_m"], record["densest_share"] = window


class BeliefFilter:
    """Filters a tracker's estimates to a belief.

    Attributes:
        belief: (1,) of dtype ``BELIEF``, updated in place.
        interval_s: time between the last two pictures.
    """

    def __init__(self, looks: Looks) -> None:
        self._looks: Looks = looks
        self._time_s = 0.0
        self.interval_s = 1.0
        self.belief = np.zeros(1, BELIEF)

    def update(self, observation: Observation, estimate: Estimate) -> NDArray[np.void]:
        """Update the belief with the next picture's estimate and return it (1,).

        A picture that is given again, as no later one has arrived, changes nothing.
        """
        if self.belief["frames"][0] > 0.0 and observation.time_s == self._time_s:
            return self.belief
        if observation.time_s > self._time_s:
            self.interval_s = observation.time_s - self._time_s
        self._time_s = observation.time_s
        update_beliefs(self.belief, sighting_of(self._looks, observation, estimate), self.interval_s)
        return self.belief
