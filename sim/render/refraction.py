"""A renderer that looks through a rippled surface of water at what another renderer draws.

The ray of pixel p meets the surface at depth z_s along the optical axis and is bent there (Snell). What lies on the
bent ray at depth w, the inner renderer draws at pixel

    q(w) = p + (1 - z_s / w) e,    e = (pixel in which all rays parallel to the bent one meet) - p

on a straight line from p. So the point seen is the first one on that line where the inner depth map is not beyond w.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import GBuffer
from sim.optics import PinholeCamera, project, ray_of_pixel
from sim.render.compilation import announce_compilation
from sim.render.protocol import Renderer
from sim.render.refraction_kernels import Water, WaterRays, bend_rays, find_entries, widest_shift, warp
from sim.water_surface import RippledSurface

STEP_PX = 4
"""Rays are bent at every fourth pixel of every fourth row, and interpolated between."""


class ThroughWater:
    """A ``Renderer`` of another one's world with water in it; see ``sim.render.protocol``.

    What is above the water or beside its rectangle is seen as it is. The inner renderer must not draw the surface.
    """

    def __init__(self, renderer: Renderer, surface: RippledSurface) -> None:
        """Look at the world of ``renderer`` through the surface as it is at the time of each picture."""
        self._renderer, self.surface = renderer, surface
        announce_compilation(warp)

    def gbuffer(
        self, camera: PinholeCamera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5
    ) -> GBuffer:
        """Return what is really seen, see ``Renderer``: depth, id and normal are those of the point on the bent ray.

        Places that the inner renderer hides behind a body, though the bent ray passes it, get the surface beside it.

        Raises:
            ValueError: if the camera is not above the water.
        """
        rays = water_rays(self.surface, camera, T_world_camera, pixel_offset)
        margin_x, margin_y = margins_px(rays, camera)
        wide = PinholeCamera(camera.width_px + 2 * margin_x, camera.height_px + 2 * margin_y, camera.focal_px)
        inner = self._renderer.gbuffer(wide, T_world_camera, pixel_offset=pixel_offset)
        shape = (camera.height_px, camera.width_px)
        seen = GBuffer(
            np.empty((*shape, 3), np.uint8),
            np.empty(shape, np.float32),
            np.empty(shape, np.int32),
            np.empty((*shape, 3), np.float32),
        )
        warp(rays, inner, margin_x, margin_y, seen)
        return seen


def water_rays(
    surface: RippledSurface, camera: PinholeCamera, T_world_camera: NDArray[np.float64], pixel_offset: float = 0.5
) -> WaterRays:
    """Return the bent rays of a picture, in fresh arrays.

    Raises:
        ValueError: if the camera is not above the water.
    """
    water = _water(surface, T_world_camera)
    rows, columns = (-(-(side - 1) // STEP_PX) + 1 for side in (camera.height_px, camera.width_px))
    nodes = np.empty((6, rows, columns), np.float32)
    matrix = _matrix(camera, T_world_camera)
    grid = surface.grid()
    rays = WaterRays(nodes, STEP_PX, pixel_offset, T_world_camera[:3, 3].astype(float), matrix, water)
    bend_rays(rays, _projection(camera, T_world_camera), grid)
    return rays


def margins_px(rays: WaterRays, camera: PinholeCamera) -> tuple[int, int]:
    """Return columns on either side and rows above and below that the inner picture needs beyond the outer one."""
    widest = widest_shift(rays, camera.width_px, camera.height_px)
    return tuple(0 if shift <= 0.5 else 8 * int(np.ceil((shift + 1.0) / 8.0)) for shift in widest)  # type: ignore[return-value]


def project_through(
    surface: RippledSurface,
    camera: PinholeCamera,
    T_world_camera: NDArray[np.float64],
    points_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the pixels (N, 2) at which a camera above the water sees points (N, 3), as ``sim.optics.project``.

    Points of the water are seen through its surface at ``time_s``, whatever hides them; all others straight on. Where
    ripples show a point more than once, one of the pixels is returned.

    Returns:
        pixels, right to 0.001 px; NaN behind the camera, and where no ray was found.

    Raises:
        ValueError: if the camera is not above the water.
    """
    water = _water(surface, T_world_camera)
    points = np.asarray(points_m, dtype=float).reshape(-1, 3)
    pixels, depth_m = project(camera, T_world_camera, points)
    within = (points[:, :2] >= surface.low_m) & (points[:, :2] <= surface.high_m)
    is_under = within.all(axis=1) & (points[:, 2] < surface.level_m) & (depth_m > 1e-6)
    found = np.ascontiguousarray(pixels[is_under])
    find_entries(
        water,
        surface.waves,
        surface.time_s,
        T_world_camera[:3, 3].astype(float),
        _matrix(camera, T_world_camera),
        _projection(camera, T_world_camera),
        depth_m[is_under],
        found,
    )
    pixels[is_under] = found
    return pixels


def _water(surface: RippledSurface, T_world_camera: NDArray[np.float64]) -> Water:
    height_m = float(T_world_camera[2, 3])
    check("T_world_camera", height_m > surface.level_m, f"a camera above the water at {surface.level_m} m", height_m)
    return Water(surface.low_m, surface.high_m, surface.level_m, surface.depth_m, surface.refractive_index)


def _matrix(camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (3, 3) from (x, y, 1) of a pixel to its ray at unit camera depth, world frame."""
    return np.ascontiguousarray(T_world_camera[:3, :3] @ ray_of_pixel(camera), dtype=float)


def _projection(camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (3, 3) from a world direction to its homogeneous pixel."""
    return np.ascontiguousarray(camera.intrinsic_matrix @ T_world_camera[:3, :3].T, dtype=float)
