"""The default renderer: a z-buffer rasteriser for one core, compiled by numba."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.optics import Camera
from sim.render.attributes import Drawn, Visible, new_resolve_scratch, normals_of, resolve_picture, resolve_row
from sim.render.canvas import Canvas
from sim.render.compilation import announce_compilation
from sim.render.row_stages import RowStage
from sim.render.scene import SceneArrays, pack_scene
from sim.render.textures import TexturePool
from sim.render.view import camera_view
from sim.render.visibility import draw_bodies
from sim.world import World


class Raster:
    """Draws a world. Bodies may be added and moved between pictures; shapes and textures are packed once. What did not
    move before a camera at rest is not drawn again.

    Attributes:
        resolving: see ``sim.render.pipeline.RowRenderer``.
    """

    resolving = RowStage(resolve_row, new_resolve_scratch)

    def __init__(self, world: World) -> None:
        self._world = world
        self._body_count = -1
        self._canvas = Canvas()
        self._scene: SceneArrays
        self._textures: TexturePool
        announce_compilation(draw_bodies)

    def gbuffer(self, camera: Camera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5) -> GBuffer:
        """Draw the world as it is now.

        Args:
            T_world_camera: (4, 4) rigid pose.
            pixel_offset: where in a pixel it is sampled; 0.5 is its centre.

        Returns:
            Fresh arrays; see ``GBuffer``.
        """
        seen = self.visible(camera, T_world_camera, pixel_offset=pixel_offset)
        shape = (*seen.depth_m.shape, 3)
        base_colour_rgb, normal_world = np.empty(shape, np.uint8), np.empty(shape, np.float32)
        resolve_picture(seen, base_colour_rgb, normal_world)
        return GBuffer(base_colour_rgb, seen.depth_m, seen.instance_id, normal_world)

    def normals(self, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the normals of ``gbuffer`` alone, in a fresh array."""
        drawn = self.draw(camera, T_world_camera)
        normal_world = np.empty((*drawn.triangle.shape, 3), np.float32)
        normals_of(drawn, normal_world)
        return normal_world

    def visible(self, camera: Camera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5) -> Visible:
        """Find the nearest triangle of every pixel, the first half of ``gbuffer``.

        Returns:
            depth and ids are fresh arrays, ids not written yet; the others are overwritten by the next call.
        """
        drawn = self.draw(camera, T_world_camera, pixel_offset=pixel_offset)
        shape = drawn.nearness.shape
        depth_m, instance_id = np.empty(shape, np.float32), np.empty(shape, np.int32)
        with np.errstate(divide="ignore"):
            np.divide(np.float32(1.0), drawn.nearness, out=depth_m)
        return Visible(*drawn, depth_m, instance_id)

    def draw(
        self,
        camera: Camera,
        T_world_camera: NDArray[np.float64],
        *,
        pixel_offset: float = 0.5,
        canvas: Canvas | None = None,
    ) -> Drawn:
        """Find the nearest triangle of every pixel, as ``visible``.

        Args:
            canvas: None for the renderer's own.

        Returns:
            arrays that the next call with this canvas overwrites.
        """
        self._pack()
        on = self._canvas if canvas is None else canvas
        view, shape = camera_view(camera, T_world_camera, pixel_offset), (camera.height_px, camera.width_px)
        return on.draw(self._scene, self._textures, self._world.poses, view, shape)

    def _pack(self) -> None:
        if self._body_count != len(self._world.bodies):
            self._scene, self._textures = pack_scene(self._world)
            self._body_count = len(self._world.bodies)
