"""A renderer that looks through a rippled surface of water at what another renderer draws.

The ray of pixel p meets the surface at depth z_s along the optical axis and is bent there (Snell). The bent ray points
towards pixel ``p + e``, in which all rays parallel to it meet, so that what lies on it at depth w would be seen
straight on at pixel ``p + (1 - z_s / w) e``. The other renderer draws the world twice: what is above the water as the
camera sees it, and what is in it from an eye that is nearly that of the bent rays, see ``sim.render.water.trace``.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.gbuffer import GBuffer
from sim.optics import PinholeCamera, project, ray_of_pixel
from sim.render.compilation import announce_compilation
from sim.render.protocol import Renderer
from sim.render.raster import Canvas, Raster
from sim.render.refracted_rows import Refracted, new_refracted_scratch, resolve_refracted, resolve_refracted_row
from sim.render.row_stages import RowStage
from sim.render.water.rays import STEP_PX, WaterBody, WaterRays, bend_rays, find_entries
from sim.render.water.trace import Endings, Eye, eye_of, new_endings, trace, ways_of
from sim.water_surface import RippledSurface

_ROWS = RowStage(resolve_refracted_row, new_refracted_scratch)
_latest: WeakKeyDictionary[RippledSurface, tuple[object, WaterRays]] = WeakKeyDictionary()


class ThroughWater:
    """A ``Renderer`` of another one's world with water in it; see ``sim.render.protocol``.

    What is above the water or beside its rectangle is seen as it is. The inner renderer must not draw the surface.

    Attributes:
        surface: looked through, as it is at the time of each picture.
        resolving: see ``sim.render.pipeline.RowRenderer``; None if the inner renderer is not ``raster``.
    """

    def __init__(self, renderer: Renderer, surface: RippledSurface) -> None:
        """Look at the world of ``renderer``."""
        self._renderer, self.surface = renderer, surface
        self.resolving = _ROWS if isinstance(renderer, Raster) else None
        self._canvas = Canvas()
        self._ends = new_endings(0, 0, np.empty((0, 0), np.float32))
        announce_compilation(bend_rays)

    def gbuffer(
        self, camera: PinholeCamera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5
    ) -> GBuffer:
        """Return what is really seen, see ``Renderer``: depth, id and normal are those of the point on the bent ray.

        Places that the inner renderer hides behind a body, though the bent ray passes it, are filled with the surface
        beside it.

        Raises:
            ValueError: if the camera is not above the water.
        """
        if self.resolving is not None:
            seen = self.visible(camera, T_world_camera, pixel_offset=pixel_offset)
            shape = (*seen.depth_m.shape, 3)
            base_colour_rgb, normal_world = np.empty(shape, np.uint8), np.empty(shape, np.float32)
            resolve_refracted(seen, base_colour_rgb, normal_world)
            return GBuffer(base_colour_rgb, seen.depth_m, seen.instance_id, normal_world)
        eye = self._eye(camera, T_world_camera)
        straight = self._renderer.gbuffer(camera, T_world_camera, pixel_offset=pixel_offset)
        inner = self._renderer.gbuffer(*eye)
        with np.errstate(divide="ignore"):
            nearness = [np.float32(1.0) / picture.depth_m for picture in (straight, inner)]
        ends = self._trace(camera, T_world_camera, pixel_offset, eye, *nearness)
        # The straight picture is last and backwards, as its pixels have numbers below 0, which count from the end.
        colour, instance_id, normal = (
            np.concatenate([_flat(getattr(inner, name)), _flat(getattr(straight, name))[::-1]])[ends.source]
            for name in ("base_colour_rgb", "instance_id", "normal_world")
        )
        return GBuffer(colour, ends.depth_m, instance_id, normal)

    def normals(self, camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """See ``Renderer``."""
        return self.gbuffer(camera, T_world_camera).normal_world

    def visible(
        self, camera: PinholeCamera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5
    ) -> Refracted:
        """Trace the rays of all pixels, the first half of ``gbuffer``, through what ``raster`` draws.

        Returns:
            depth and ids are fresh arrays, ids not written yet; the others are overwritten by the next call.
        """
        eye = self._eye(camera, T_world_camera)
        draw = self._renderer.draw  # type: ignore[attr-defined]
        straight, inner = draw(camera, T_world_camera, pixel_offset=pixel_offset), draw(*eye, canvas=self._canvas)
        ends = self._trace(camera, T_world_camera, pixel_offset, eye, straight.nearness, inner.nearness)
        return Refracted(straight, inner, ends, ends.depth_m, np.empty(ends.depth_m.shape, np.int32))

    def _eye(self, camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> Eye:
        body = _water_body(self.surface, T_world_camera)
        rectangle_m = (*body.low_m.tolist(), *body.high_m.tolist())
        pose = np.ascontiguousarray(T_world_camera, dtype=float).tobytes()
        return eye_of(camera, pose, rectangle_m, body.level_m, body.depth_m, body.refractive_index)

    def _trace(
        self,
        camera: PinholeCamera,
        T_world_camera: NDArray[np.float64],
        pixel_offset: float,
        eye: Eye,
        straight: NDArray[np.float32],
        inner: NDArray[np.float32],
    ) -> Endings:
        rays = water_rays(self.surface, camera, T_world_camera, pixel_offset)
        depth_m = np.empty(straight.shape, np.float32)
        if self._ends.column.shape != depth_m.shape:
            self._ends = new_endings(camera.height_px, camera.width_px, depth_m)
        ends = self._ends._replace(depth_m=depth_m)
        trace(rays, ways_of(rays, eye), straight, inner, ends)
        return ends


def _flat(picture: NDArray[Any]) -> NDArray[Any]:
    """Return a picture (H, W, ...) as a line of pixels."""
    return picture.reshape(-1, *picture.shape[2:])


def water_rays(
    surface: RippledSurface, camera: PinholeCamera, T_world_camera: NDArray[np.float64], pixel_offset: float = 0.5
) -> WaterRays:
    """Return the bent rays of a picture, not to be written to. The latest ones of a surface are kept.

    Raises:
        ValueError: if the camera is not above the water.
    """
    key = (camera, T_world_camera.tobytes(), pixel_offset, surface.time_s)
    kept = _latest.get(surface)
    if kept is not None and kept[0] == key:
        return kept[1]
    body = _water_body(surface, T_world_camera)
    rows, columns = camera.height_px // STEP_PX + 2, camera.width_px // STEP_PX + 2
    nodes = np.empty((6, rows, columns), np.float32)
    position_m = T_world_camera[:3, 3].astype(float)
    rays = WaterRays(nodes, pixel_offset, position_m, _matrix(camera, T_world_camera), body)
    bend_rays(rays, _projection(camera, T_world_camera), surface.grid())
    _latest[surface] = (key, rays)
    return rays


def project_through(
    surface: RippledSurface, camera: PinholeCamera, T_world_camera: NDArray[np.float64], points_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the pixels (N, 2) at which a camera above the water sees points (N, 3), as ``sim.optics.project``.

    Points of the water are seen through its surface at ``time_s``, whatever hides them; all others straight on. Where
    ripples show a point more than once, one of the pixels is returned.

    Returns:
        pixels, right to 0.001 px; NaN behind the camera, and where no ray was found.

    Raises:
        ValueError: if the camera is not above the water.
    """
    body = _water_body(surface, T_world_camera)
    points = np.asarray(points_m, dtype=float).reshape(-1, 3)
    pixels, depth_m = project(camera, T_world_camera, points)
    within = (points[:, :2] >= surface.low_m) & (points[:, :2] <= surface.high_m)
    is_under = within.all(axis=1) & (points[:, 2] < surface.level_m) & (depth_m > 1e-6)
    found = np.ascontiguousarray(pixels[is_under])
    find_entries(
        body,
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


def _water_body(surface: RippledSurface, T_world_camera: NDArray[np.float64]) -> WaterBody:
    height_m = float(T_world_camera[2, 3])
    check("T_world_camera", height_m > surface.level_m, f"a camera above the water at {surface.level_m} m", height_m)
    return WaterBody(surface.low_m, surface.high_m, surface.level_m, surface.depth_m, surface.refractive_index)


def _matrix(camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (3, 3) from (x, y, 1) of a pixel to its ray at unit camera depth, world frame."""
    return np.ascontiguousarray(T_world_camera[:3, :3] @ ray_of_pixel(camera), dtype=float)


def _projection(camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (3, 3) from a world direction to its homogeneous pixel."""
    return np.ascontiguousarray(camera.intrinsic_matrix @ T_world_camera[:3, :3].T, dtype=float)
