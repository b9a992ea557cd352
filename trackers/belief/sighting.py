"""What one picture, through a tracker, says of where the target is on the ground."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import SIGHTING, densest_window
from trackers.types import Estimate, Looks, Observation

_ASSUMED_HEIGHT_M = 60.0
"""Of a camera that looks down without instruments."""
ASSUMED_DISTANCE_M = 3.0
"""Of a target before a camera that looks ahead, seen by a tracker that measures no depth; and where it looks."""
FARTHEST_M = 500.0
"""Rays at or above the horizon meet the ground nowhere; what lies further off counts as that."""
_FARTHEST_PX, _LOWEST_M = 1e9, 0.1
_TRIES = 24
_AHEAD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
_DOWN = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""R_world_camera of a level camera with the heading 0."""


def within_reach(pixels: object) -> NDArray[np.float64]:
    """Return pixels or lengths in pixels, of any shape, cut to what can be reckoned with: estimates know no bounds."""
    return np.clip(np.asarray(pixels, dtype=float), -_FARTHEST_PX, _FARTHEST_PX)


def distance_m(estimate: Estimate, assumed_m: float) -> float:
    """Return how far away along the camera's axis the target is, at most ``FARTHEST_M``."""
    return min(estimate.depth_m or assumed_m, FARTHEST_M)


def sighting_of(looks: Looks, observation: Observation, estimate: Estimate) -> NDArray[np.void]:
    """Return one sighting (1,) of dtype ``SIGHTING`` of a camera that looks down or ahead; the ground is z = 0."""
    sighting = np.zeros(1, SIGHTING)
    said: Any = sighting[0]
    down = looks == "down"
    R, place_m, height_m = _pose(observation, down)
    forward = -R[:2, 1] if down else R[:2, 2]
    heading_rad = np.arctan2(forward[1], forward[0])
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    camera = observation.camera
    half_px = 0.5 * np.array([camera.width_px, camera.height_px])
    reach_m = height_m if down else 1.0
    said["carrier_x_m"], said["carrier_y_m"] = place_m
    said["height_m"], said["heading_rad"] = height_m, heading_rad
    said["half_right_m"], said["half_ahead_m"] = reach_m * half_px / camera.focal_px
    if down:
        axis_m = _on_ground(R, height_m, np.zeros((1, 2)))[0]
        said["axis_ahead_m"], said["axis_right_m"] = c * axis_m[0] + s * axis_m[1], s * axis_m[0] - c * axis_m[1]
    else:
        said["axis_ahead_m"] = ASSUMED_DISTANCE_M
    position_px = within_reach(estimate.position_px)
    if not np.isfinite(position_px).all():
        return sighting
    in_picture = (position_px - half_px) / half_px
    said["picture_x"], said["picture_y"] = in_picture
    inside = float(np.abs(in_picture).max() <= 1.0)
    probability = estimate.in_view_probability
    said["in_view_probability"] = inside if probability is None else probability
    if estimate.box_xyxy is not None:
        box = within_reach(estimate.box_xyxy)
        said["length_share"] = max(box[2] - box[0], box[3] - box[1]) / camera.width_px
    tangents = ((position_px - half_px) / camera.focal_px)[None]
    if down:
        offset_m = _on_ground(R, height_m, tangents)[0]
        metres_per_pixel = height_m / camera.focal_px
    else:
        depth_m = distance_m(estimate, ASSUMED_DISTANCE_M)
        offset_m = (R @ (depth_m * np.append(tangents[0], 1.0)))[:2]
        metres_per_pixel = depth_m / camera.focal_px
    said["known"] = 1.0
    said["x_m"], said["y_m"] = place_m + offset_m
    said["densest_x_m"], said["densest_y_m"] = place_m + offset_m
    said["densest_share"] = 1.0
    if estimate.covariance_px is not None:
        said["spread_m"] = metres_per_pixel * float(np.sqrt(0.5 * np.trace(within_reach(estimate.covariance_px))))
    if estimate.particles_px is not None and down:
        _summarise(said, estimate, R, place_m, height_m, half_px, camera.focal_px)
    return sighting


def _pose(observation: Observation, down: bool) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return R_world_camera (3, 3), the place (2,) and the height as measured, or those of a level camera."""
    if observation.ego is None:
        return (_DOWN, np.zeros(2), _ASSUMED_HEIGHT_M) if down else (_AHEAD, np.zeros(2), 0.0)
    T = observation.ego.T_world_camera
    return T[:3, :3], T[:2, 3], max(float(T[2, 3]), _LOWEST_M) if down else float(T[2, 3])


def _on_ground(R: NDArray[np.float64], height_m: float, tangents: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where rays (N, 2), tangents of angles right and down, meet the ground, from under the camera (N, 2)."""
    rays = tangents @ R[:, :2].T + R[:, 2]
    steep = np.maximum(-rays[:, 2], height_m / FARTHEST_M)
    return rays[:, :2] * (height_m / steep)[:, None]


def _summarise(
    said: Any,
    estimate: Estimate,
    R: NDArray[np.float64],
    place_m: NDArray[np.float64],
    height_m: float,
    half_px: NDArray[np.float64],
    focal_px: float,
) -> None:
    """Note how far the posterior spreads, and where most of it lies."""
    assert estimate.particles_px is not None
    particles_px, count = within_reach(estimate.particles_px), len(estimate.particles_px)
    weights = np.full(count, 1.0 / count) if estimate.weights is None else np.ascontiguousarray(estimate.weights)
    # Particles that are not finite lie nowhere.
    somewhere = np.isfinite(estimate.particles_px).all(axis=1)
    if not somewhere.all():
        particles_px, weights = particles_px[somewhere], weights[somewhere]
        if not weights.sum() > 0.0:
            return
        weights = weights / weights.sum()
    particles_m = place_m + _on_ground(R, height_m, (particles_px - half_px) / focal_px)
    mean_m = weights @ particles_m
    said["spread_m"] = np.sqrt(0.5 * (weights @ ((particles_m - mean_m) ** 2)).sum())
    half_m = min(said["half_ahead_m"], said["half_right_m"])
    window = densest_window(particles_m, weights, float(half_m), _TRIES)
    said["densest_x_m"], said["densest_y_m"], said["densest_share"] = window
