"""The default renderer: a z-buffer rasteriser for one core, compiled by numba.

Before a camera at rest only what moved is drawn again. Bodies that did not move since the picture before are drawn on a
*layer* that is kept; each picture is a copy of it on which the others are drawn. Where nothing at all moved, the
picture before is the picture. The result equals that of drawing everything, bit by bit.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.gbuffer import GBuffer
from sim.optics import Camera
from sim.render.attributes import Drawn, Visible, new_resolve_scratch, normals_of, resolve_picture, resolve_row
from sim.render.compilation import announce_compilation
from sim.render.row_stages import RowStage
from sim.render.scene import SceneArrays, pack_scene
from sim.render.textures import TexturePool
from sim.render.triangles import camera_view
from sim.render.visibility import NOTHING, draw_bodies, new_triangle_table
from sim.world import World

_SETTLED = 4
"""A body that comes to rest is drawn on the layer after this number of pictures: the layer is drawn anew for it."""


class Canvas:
    """Draws one world from changing views.

    Attributes:
        pictures_of_all: how many pictures were drawn without a layer, or with a new one.
    """

    def __init__(self) -> None:
        self.pictures_of_all = 0
        self._nearness = np.empty((0, 0), np.float32)
        self._triangle = np.empty((0, 0), np.int32)
        self._table = new_triangle_table(0)
        self._projected = np.empty((0, 4))
        self._view = np.empty((0, 0))
        self._poses = np.empty((0, 4, 4))
        self._rested = np.empty(0, np.int64)
        self._in_layer = np.empty(0, np.bool_)
        self._layer: tuple[NDArray[np.float32], NDArray[np.int32], int] | None = None

    def draw(
        self,
        scene: SceneArrays,
        textures: TexturePool,
        poses: NDArray[np.float64],
        view: NDArray[np.float64],
        shape: tuple[int, int],
    ) -> Drawn:
        """Find the nearest triangle of every pixel of a picture (H, W).

        Args:
            scene: the same object until shapes are added.
            poses: T_world_body (B, 4, 4).
            view: the view matrix of a camera.

        Returns:
            arrays that the next call overwrites.
        """
        if not self._fits(scene, shape) or view.tobytes() != self._view.tobytes():
            self._forget_layer(view, poses)
            self._draw_all(scene, textures)
        elif not np.array_equal(poses, self._poses):
            self._note_motion(poses)
            self._draw_moved(scene, textures)
        return Drawn(textures, self._table, self._nearness, self._triangle)

    def _fits(self, scene: SceneArrays, shape: tuple[int, int]) -> bool:
        """Make room for a picture; return whether there was."""
        faces = len(scene.faces)
        fits = self._nearness.shape == shape and len(self._table.whole) == faces + 1
        fits &= len(self._poses) == len(scene.radius_m)
        if not fits:
            self._nearness, self._triangle = np.empty(shape, np.float32), np.empty(shape, np.int32)
            largest = int(np.diff(scene.first_vertex).max(initial=0))
            self._table, self._projected = new_triangle_table(faces), np.empty((largest, 4))
        return fits

    def _forget_layer(self, view: NDArray[np.float64], poses: NDArray[np.float64]) -> None:
        self._view, self._poses, self._layer = view.copy(), poses.copy(), None
        self._rested = np.full(len(poses), _SETTLED)

    def _note_motion(self, poses: NDArray[np.float64]) -> None:
        """Count for how long bodies have rested; drop the layer if it is not what is at rest."""
        moved = (poses != self._poses).any(axis=(1, 2))
        self._poses[moved] = poses[moved]
        self._rested = np.where(moved, 0, self._rested + 1)
        settled = ~self._in_layer & (self._rested == _SETTLED) if self._layer is not None else False
        if self._layer is None or (moved & self._in_layer).any() or np.any(settled):
            self._layer, self._in_layer = None, self._rested >= _SETTLED

    def _draw_all(self, scene: SceneArrays, textures: TexturePool) -> None:
        self.pictures_of_all += 1
        self._nearness[:], self._triangle[:] = 0.0, NOTHING
        self._draw(scene, textures, np.arange(len(self._poses)), NOTHING + 1)

    def _draw_moved(self, scene: SceneArrays, textures: TexturePool) -> None:
        if self._layer is None:
            self.pictures_of_all += 1
            self._nearness[:], self._triangle[:] = 0.0, NOTHING
            rows = self._draw(scene, textures, np.flatnonzero(self._in_layer), NOTHING + 1)
            self._layer = self._nearness.copy(), self._triangle.copy(), rows
        self._nearness[:], self._triangle[:], rows = self._layer
        self._draw(scene, textures, np.flatnonzero(~self._in_layer), rows)

    def _draw(self, scene: SceneArrays, textures: TexturePool, bodies: NDArray[np.int64], kept: int) -> int:
        """Draw bodies over what there is; return the number of triangles then."""
        return int(
            draw_bodies(
                scene,
                textures,
                self._poses,
                self._view,
                self._projected,
                bodies,
                kept,
                self._table,
                self._nearness,
                self._triangle,
            )
        )


@njit(cache=True, error_model="numpy")
def _invert(nearness: NDArray[np.float32], depth_m: NDArray[np.float32]) -> None:
    for row in range(nearness.shape[0]):
        for column in range(nearness.shape[1]):
            depth_m[row, column] = np.float32(1.0) / nearness[row, column]


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
        _invert(drawn.nearness, depth_m)
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
