"""The reference renderer: PyBullet's own TinyRenderer."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.bullet import TinyRenderer
from sim.gbuffer import SKY, GBuffer
from sim.optics import Camera, intrinsic_matrix
from sim.render.visibility import NEAR_M
from sim.world import World

_FAR_M = 2000.0


class PybulletRenderer:
    """Draws a world with PyBullet.

    Colours are unlit and each pixel shows one texel (PyBullet does not interpolate). Normals are derived from the depth
    of a pixel and its neighbours of the same body. So they are never smoothed, and uncertain on edges.
    """

    def __init__(self, world: World) -> None:
        self._drawing = TinyRenderer(world)

    def gbuffer(self, camera: Camera, T_world_camera: NDArray[np.float64], *, pixel_offset: float = 0.5) -> GBuffer:
        """Draw the world as it is now; see ``sim.render.protocol.Renderer``."""
        near_m, far_m = NEAR_M, _FAR_M
        colour_rgb, buffer, instance_id = self._drawing.camera_image(
            camera, T_world_camera, near_m=near_m, far_m=far_m, pixel_offset=pixel_offset
        )
        # OpenGL: buffer = (far / (far - near)) (1 - near / depth).
        depth_m = far_m * near_m / (far_m - (far_m - near_m) * buffer.astype(np.float64))
        nothing = instance_id == SKY
        depth_m[nothing] = np.inf
        colour_rgb[nothing] = 0
        normal_world = np.empty((*depth_m.shape, 3), np.float32)
        K_inverse = np.linalg.inv(intrinsic_matrix(camera))
        K_inverse[:, 2] += pixel_offset * (K_inverse[:, 0] + K_inverse[:, 1])
        normals_from_depth(depth_m, instance_id, T_world_camera[:3, :3] @ K_inverse, normal_world)
        return GBuffer(colour_rgb, depth_m.astype(np.float32), instance_id, normal_world)

    def normals(self, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """See ``Renderer``."""
        return self.gbuffer(camera, T_world_camera).normal_world


@njit(cache=True)
def normals_from_depth(
    depth_m: NDArray[np.float64],
    instance_id: NDArray[np.int32],
    ray_of_pixel: NDArray[np.float64],
    normal_world: NDArray[np.float32],
) -> None:
    """Write ``n ~ dP/dcolumn x dP/drow`` with ``P = depth * ray_of_pixel @ (column, row, 1)``, turned to
    the camera.

    A pixel without neighbours of its body gets the direction to the camera; one without a body gets 0.
    """
    along, down, normal = np.empty(3), np.empty(3), np.empty(3)
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            if instance_id[row, column] == SKY:
                normal_world[row, column] = 0.0
                continue
            here = _point(depth_m, ray_of_pixel, row, column)
            has_along = _slope(depth_m, instance_id, ray_of_pixel, row, column, 0, 1, along)
            has_down = _slope(depth_m, instance_id, ray_of_pixel, row, column, 1, 0, down)
            if has_along and has_down:
                for k in range(3):
                    normal[k] = along[(k + 1) % 3] * down[(k + 2) % 3] - along[(k + 2) % 3] * down[(k + 1) % 3]
            else:
                normal[:] = here
            away = normal[0] * here[0] + normal[1] * here[1] + normal[2] * here[2] > 0.0
            length = np.sqrt((normal * normal).sum())
            for k in range(3):
                normal_world[row, column, k] = (-normal[k] if away else normal[k]) / length


@njit(cache=True)
def _point(
    depth_m: NDArray[np.float64], ray_of_pixel: NDArray[np.float64], row: int, column: int
) -> NDArray[np.float64]:
    ray = ray_of_pixel[:, 0] * column + ray_of_pixel[:, 1] * row + ray_of_pixel[:, 2]
    return ray * depth_m[row, column]


@njit(cache=True)
def _slope(
    depth_m: NDArray[np.float64],
    instance_id: NDArray[np.int32],
    ray_of_pixel: NDArray[np.float64],
    row: int,
    column: int,
    row_step: int,
    column_step: int,
    slope: NDArray[np.float64],
) -> bool:
    """Write the change of P by one step; False if neither neighbour belongs to the same body.

    The result is the mean slope of both sides. If they differ by more than a fifth of a pixel's width on the surface,
    there is an edge, and the flatter side counts.
    """
    here = _point(depth_m, ray_of_pixel, row, column)
    body = instance_id[row, column]
    rows, columns = depth_m.shape
    has_after = row + row_step < rows and column + column_step < columns
    has_after = has_after and instance_id[row + row_step, column + column_step] == body
    has_before = row >= row_step and column >= column_step
    has_before = has_before and instance_id[row - row_step, column - column_step] == body
    if has_after and has_before:
        after = _point(depth_m, ray_of_pixel, row + row_step, column + column_step) - here
        before = here - _point(depth_m, ray_of_pixel, row - row_step, column - column_step)
        z = depth_m[row, column]
        rise = depth_m[row + row_step, column + column_step] - z
        fall = z - depth_m[row - row_step, column - column_step]
        pixel_m = z * np.sqrt((ray_of_pixel[:, 0] * ray_of_pixel[:, 0]).sum())
        if abs(rise - fall) <= 0.2 * pixel_m:
            slope[:] = 0.5 * (after + before)
        else:
            slope[:] = after if abs(rise) < abs(fall) else before
    elif has_after:
        slope[:] = _point(depth_m, ray_of_pixel, row + row_step, column + column_step) - here
    elif has_before:
        slope[:] = here - _point(depth_m, ray_of_pixel, row - row_step, column - column_step)
    return has_after or has_before
