"""A surveyed site before a camera at rest: its geometry in the picture, the watched volume, and readings of pictures.

World: the camera's navigation frame, metres, z up, ground at z = 0. Camera frame: x right, y down, z forward.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, Estimate, Observation, SiteSurvey

_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_ROTATION_TOLERANCE = 1e-6
_LEAST_DEPTH_M = 0.1
"""Nearer points are taken as behind the camera: their pixels would run to infinity."""


class SiteView:
    """Pinhole geometry of one camera in one pose.

    Attributes:
        camera: intrinsics.
        T_world_camera: (4, 4) pose.
        place_m: (3,) the camera's place.
    """

    def __init__(self, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> None:
        """Raise ValueError for a matrix that is no pose: other than (4, 4), not finite, or without a rotation."""
        pose = np.array(T_world_camera, dtype=np.float64)
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise ValueError(f"T_world_camera: expected a (4, 4) matrix of finite numbers, got {pose.tolist()}")
        R = pose[:3, :3]
        if np.abs(R).max() > 2.0 or np.abs(R @ R.T - np.eye(3)).max() > _ROTATION_TOLERANCE or np.linalg.det(R) < 0:
            raise ValueError(
                f"T_world_camera: expected a rotation in its first three rows and columns, got {R.tolist()}"
            )
        pose.flags.writeable = False
        self.camera, self.T_world_camera, self.place_m = camera, pose, pose[:3, 3]
        self._middle_px = 0.5 * np.array([camera.width_px, camera.height_px])

    def project(self, points_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return pixels (N, 2) and depths (N,) along the optical axis of world points (N, 3).

        ``p = Rᵀ (X − C)``; ``u = f p_x / p_z + W / 2``, ``v = f p_y / p_z + H / 2``; depth ``p_z``. Both are NaN for
        points behind the camera or nearer than 0.1 m.
        """
        seen = (np.asarray(points_m, dtype=np.float64) - self.place_m) @ self.T_world_camera[:3, :3]
        depth_m = np.where(seen[:, 2] >= _LEAST_DEPTH_M, seen[:, 2], np.nan)
        return self.camera.focal_px * seen[:, :2] / depth_m[:, None] + self._middle_px, depth_m

    def rays(self, px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the directions (N, 3) in the world, 1 long along the optical axis, seen at pixels (N, 2)."""
        offsets = (np.asarray(px, dtype=np.float64) - self._middle_px) / self.camera.focal_px
        return np.column_stack([offsets, np.ones(len(offsets))]) @ self.T_world_camera[:3, :3].T

    def on_plane(self, px: NDArray[np.float64], z_m: float) -> NDArray[np.float64]:
        """Return the points (N, 3) of the horizontal plane at ``z_m`` seen at pixels (N, 2); NaN where it is not."""
        rays = self.rays(px)
        towards = np.where(rays[:, 2] == 0.0, np.nan, rays[:, 2])
        depth_m = (z_m - self.place_m[2]) / towards
        return self.place_m + rays * np.where(depth_m >= _LEAST_DEPTH_M, depth_m, np.nan)[:, None]

    def place_of(self, estimate: Estimate) -> NDArray[np.float64]:
        """Return the place (3,) of an estimate in the world; NaN if it has no position or no depth."""
        if estimate.depth_m is None:
            return np.full(3, np.nan)
        ray: NDArray[np.float64] = self.rays(estimate.position_px[None])[0]
        return self.place_m + ray * estimate.depth_m

    def estimate_of(
        self, centre_m: NDArray[np.float64], size_m: NDArray[np.float64], heading_rad: float
    ) -> Estimate | None:
        """Return the estimate of an upright box: projected centre and region, depth of the centre.

        Args:
            centre_m: (3,) its centre in the world.
            size_m: (3,) length, width and height.
            heading_rad: direction of its length in the world's XY plane, from +x towards +y.

        Returns:
            None if a part of it lies behind the camera.
        """
        c, s = np.cos(heading_rad), np.sin(heading_rad)
        corners_m = (_CORNERS * size_m) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + centre_m
        px, depth_m = self.project(np.vstack([centre_m, corners_m]))
        if not np.isfinite(px).all():
            return None
        box_xyxy = np.concatenate([px[1:].min(axis=0), px[1:].max(axis=0)])
        return Estimate(px[0], box_xyxy, depth_m=float(depth_m[0]))


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


@dataclass(frozen=True, eq=False)
class Site:
    """A surveyed site, a camera at rest over it, and the volume that it watches."""

    survey: SiteSurvey
    view: SiteView
    volume: PlacedVolume


class Surveyed:
    """The part of a ``SiteTracker`` that takes in the survey."""

    _survey: SiteSurvey | None = None

    def survey(self, site: SiteSurvey) -> None:
        """See ``SiteTracker``."""
        self._survey = site

    def _site_of(self, camera: CameraModel, observations: Iterable[Observation]) -> Site | None:
        """Return the site by the first of ``observations`` whose measured pose can be used; None if there is none.

        A pose can be used if its optical axis meets the ground ahead, see ``place``.

        Raises:
            ValueError: before ``survey``.
        """
        known = self._known()
        for observation in observations:
            if observation.ego is not None:
                try:
                    return placed(known, camera, observation.ego.T_world_camera)
                except ValueError:
                    continue  # The instruments failed on this picture.
        return None

    def _known(self) -> SiteSurvey:
        if self._survey is None:
            raise ValueError("site: expected a survey of the site before the start, got none")
        return self._survey


def placed(survey: SiteSurvey, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> Site:
    """Return the site before a camera. Raises ValueError as ``place``."""
    return Site(survey, SiteView(camera, T_world_camera), place(survey, camera, T_world_camera))


def shows_water(survey: SiteSurvey, view: SiteView) -> NDArray[np.bool_]:
    """Return where a picture (H, W) shows water when it is at its mean level, and what is afloat there."""
    rows, columns = np.mgrid[0 : view.camera.height_px, 0 : view.camera.width_px] + 0.5
    on_water = view.on_plane(np.column_stack([columns.ravel(), rows.ravel()]), survey.mean_water_m)
    return np.nan_to_num(off_edge_m(survey, on_water), nan=-1.0).reshape(rows.shape) > 0.0


def stood_on(survey: SiteSurvey, view: SiteView, px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points (N, 3) of the quay, its wall or the mean water that are seen at pixels (N, 2).

    NaN where neither plane is seen. Of a quay that hides its own wall from the camera nothing else is known.
    """
    on_quay, on_water = view.on_plane(px, 0.0), view.on_plane(px, survey.mean_water_m)
    off_m, far_off_m = (off_edge_m(survey, each) for each in (on_quay, on_water))
    # Between the edge and the water the line of sight meets the wall.
    share = np.divide(off_m, off_m - far_off_m, out=np.ones_like(off_m), where=(off_m > 0) & (far_off_m < 0))
    share[off_m <= 0.0] = 0.0
    points: NDArray[np.float64] = on_quay + share[:, None] * (on_water - on_quay)
    return points


def off_edge_m(survey: SiteSurvey, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far (N,) points (N, 2 or 3) lie off the quay's edge, towards the water; negative on the quay.

    Off an edge with corners this is the distance to the nearest of its sides. A point lies on water if a line from it
    to far out, seawards, crosses the edge an even number of times.
    """
    level_m = np.asarray(points_m, dtype=np.float64)[:, :2]
    off_m: NDArray[np.float64] = (level_m - np.array(survey.edge_m)) @ np.array(survey.seaward)
    if not survey.outline_m:
        return off_m
    corners, out = np.array(survey.outline_m), np.array(survey.seaward)
    along = np.array([-out[1], out[0]])
    at, off = level_m @ along, level_m @ out
    nearest, crossed = np.full(len(level_m), np.inf), np.zeros(len(level_m), np.int64)
    for a, b in pairwise(corners):
        side = b - a
        share = np.clip((level_m - a) @ side / (side @ side), 0.0, 1.0)
        nearest = np.minimum(nearest, np.hypot(*(level_m - a - share[:, None] * side).T))
        (a_at, a_off), (b_at, b_off) = ((each @ along, each @ out) for each in (a, b))
        between = (at >= min(a_at, b_at)) & (at < max(a_at, b_at))
        met = a_off + (at - a_at) / np.where(between, b_at - a_at, 1.0) * (b_off - a_off)
        crossed += between & (met > off)
    ends = corners @ along
    beside = (at < ends.min()) | (at >= ends.max())
    is_water = np.where(beside, off_m > 0.0, crossed % 2 == 0)
    signed: NDArray[np.float64] = np.where(np.isfinite(nearest), np.where(is_water, nearest, -nearest), np.nan)
    return signed


Picture = NDArray[np.float32]

_MEDIAN_TO_SIGMA = 1.4826
_LEAST_NOISE = 0.5
"""Counts; a picture is rounded to whole ones."""
_SINGLE = 1.5
"""Noise beside that of what a median filter of 3 x 3 pixels takes away."""


def reading_of(observation: Observation, use_counts: bool) -> Picture:
    """Return the counts (H, W), or the 8 bits if there are none or they are not wanted."""
    counts = observation.counts
    if counts is not None and use_counts and counts.shape == observation.image_rgb.shape[:2]:
        return counts.astype(np.float32)
    grey: Picture = observation.image_rgb[..., 0].astype(np.float32)
    return grey


def noise_of(pictures: Picture) -> Picture:
    """Return the standard deviation (H, W) of each pixel from one picture (T, H, W) to the next, T >= 1.

    1.48 times the median absolute step, over the root of 2; what all pixels step together is left out. It is at least
    half a count. One picture alone has one noise, that of its fine structure.
    """
    if len(pictures) == 1:
        fine = pictures[0] - cv2.medianBlur(pictures[0], 3)
        sigma = _MEDIAN_TO_SIGMA * float(np.median(np.abs(fine))) * _SINGLE
        return np.full(fine.shape, max(sigma, _LEAST_NOISE), np.float32)
    steps = np.diff(pictures.reshape(len(pictures), -1), axis=0)
    steps -= np.median(steps[:, ::7], axis=1)[:, None]
    np.abs(steps, out=steps)
    sigma = _MEDIAN_TO_SIGMA / np.sqrt(2.0) * np.partition(steps, len(steps) // 2, axis=0)[len(steps) // 2]
    smooth = cv2.blur((sigma**2).reshape(pictures.shape[1:]), (3, 3))
    noise: Picture = np.sqrt(np.maximum(smooth, _LEAST_NOISE**2)).astype(np.float32)
    return noise
