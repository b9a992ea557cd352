"""Conversion of the particles on the map to an estimate in pixels of the present picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.ground_camera import CAR_HEIGHT_M, CENTRE_HEIGHT_M, GroundCamera
from trackers.kernels.weights import circular_mean
from trackers.mosaic_graph.kernels import road_position as rp
from trackers.particle_filter import Posterior
from trackers.types import Estimate


def answer(
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
