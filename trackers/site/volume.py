"""The watched volume of a site, as its operator sets it (paper D, section 3.2), and its place before a camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.site.view import SiteView
from trackers.types import CameraModel, SiteSurvey


@dataclass(frozen=True, eq=False)
class PlacedVolume:
    """A watched volume in the world.

    Attributes:
        centre_m: (3,).
        axes: (3, 3), rows are the unit vectors along the depth, the width (to the left) and the height.
        size_m: (3,) depth, width, height.
    """

    centre_m: NDArray[np.float64]
    axes: NDArray[np.float64]
    size_m: NDArray[np.float64]

    def contains(self, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (N,) whether world points (N, 3) lie inside, the sides included; NaN lies outside."""
        offsets_m = (np.asarray(points_m) - self.centre_m) @ self.axes.T
        return np.asarray((np.abs(offsets_m) <= 0.5 * self.size_m).all(axis=1))

    def scatter(self, rng: np.random.Generator, n: int) -> NDArray[np.float64]:
        """Draw world points (n, 3) uniformly over the volume."""
        return self.centre_m + (rng.uniform(-0.5, 0.5, (n, 3)) * self.size_m) @ self.axes


def place(survey: SiteSurvey, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> PlacedVolume:
    """Place the watched volume: centred where the optical axis meets the ground, its depth along the line of sight.

    Raises:
        ValueError: for a pose that is none, whose optical axis does not meet the ground, or meets it straight below.
    """
    view = SiteView(camera, T_world_camera)
    [aim_m] = view.on_plane(0.5 * np.array([[camera.width_px, camera.height_px]]), 0.0)
    if not np.isfinite(aim_m).all():
        raise ValueError("T_world_camera: expected an optical axis that meets the ground, got one that does not")
    ahead = aim_m - view.place_m
    distance_m = np.hypot(ahead[0], ahead[1])
    if distance_m < 1e-6 * abs(ahead[2]):
        raise ValueError("T_world_camera: expected a horizontal line of sight, got one straight down")
    x, y = ahead[:2] / distance_m
    size_m = np.array(survey.watched_m)
    axes = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])
    return PlacedVolume(np.array([*aim_m[:2], survey.watched_bottom_m + 0.5 * size_m[2]]), axes, size_m)
