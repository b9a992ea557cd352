"""The eye from which the inner picture is drawn, and the ways of bent rays in that picture.

Bent rays do not meet in one point, but almost: the point nearest to them all is the eye. So what the inner picture
shows is nearly what is seen through the water, and little is hidden in it that is not hidden in the water. In it, a
bent ray enters the water at pixel a and depth z, and what lies on it at depth w is drawn at

    q(w) = a + (1 - z / w) e,    e = (pixel in which all rays parallel to the bent one meet) - a

on a straight line, at camera depth ``z_s + (w - z) b``.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.optics import PinholeCamera, project, rays
from sim.render.compilation import row_kernel
from sim.render.water_rays import ALONG_X as TOWARDS_X
from sim.render.water_rays import ALONG_Y as TOWARDS_Y
from sim.render.water_rays import FARTHEST_M, STEP_PX, SURFACE_DEPTH, WaterRays, ray

ENTRY_X, ENTRY_Y, ENTRY_DEPTH, ALONG_X, ALONG_Y, SCALE, FLOOR_SHARE = range(7)
"""Planes of ways, at the nodes of ``WaterRays``: a, in pixels from the middle of the first; z; e; b; and the share
``1 - z / w`` at the floor."""
PLANES = 7
_PER_SIDE = 9
_BORDER_PX = 12
_BESIDE = 0.05


class Eye(NamedTuple):
    """The camera of the inner picture, and its pose (4, 4)."""

    camera: PinholeCamera
    T_world_camera: NDArray[np.float64]


@lru_cache(maxsize=16)
def eye_of(
    camera: PinholeCamera, pose: bytes, rectangle_m: tuple[float, ...], level_m: float, depth_m: float, index: float
) -> Eye:
    """Return the eye of a camera at a pose ``T_world_camera.tobytes()``; the camera itself if it sees no water.

    Args:
        rectangle_m: x and y of the low and of the high corner of the water.
    """
    T_world_camera = np.frombuffer(pose).reshape(4, 4)
    position, low, high = T_world_camera[:3, 3], np.array(rectangle_m[:2]), np.array(rectangle_m[2:])
    entries = _entries(camera, T_world_camera, low, high, level_m)
    if len(entries) < 4:
        return Eye(camera, T_world_camera)
    incoming = entries - position
    incoming /= np.linalg.norm(incoming, axis=1, keepdims=True)
    bent = incoming / index
    bent[:, 2] = -np.sqrt(1.0 - (bent[:, :2] ** 2).sum(axis=1))
    # The point whose squared distances to all rays have the least sum.
    across = np.eye(3) - bent[:, :, None] * bent[:, None, :]
    place = np.linalg.solve(across.sum(axis=0), (across @ entries[:, :, None]).sum(axis=0)[:, 0])
    ends = entries + bent * (depth_m / -bent[:, 2:])
    T_world_eye = np.eye(4)
    ahead = (0.5 * (ends + entries) - place).mean(axis=0)
    ahead /= np.linalg.norm(ahead)
    right = T_world_camera[:3, 0] - (T_world_camera[:3, 0] @ ahead) * ahead
    right /= np.linalg.norm(right)
    T_world_eye[:3, :3], T_world_eye[:3, 3] = np.column_stack([right, np.cross(ahead, right), ahead]), place
    # As many pixels to the floor as the camera has.
    unit = PinholeCamera(0, 0, 1.0)
    shown, seen = project(unit, T_world_eye, np.stack([entries, ends]))[0], project(camera, T_world_camera, entries)[0]
    focal_px = float(np.linalg.norm(seen - seen.mean(axis=0)) / np.linalg.norm(shown[1] - shown[1].mean(axis=0)))
    half_px = np.abs(shown).max(axis=(0, 1)) * focal_px + _BORDER_PX
    width_px, height_px = (8 * int(np.ceil(half / 4.0)) for half in half_px)
    return Eye(PinholeCamera(width_px, height_px, focal_px), T_world_eye)


def _entries(
    camera: PinholeCamera,
    T_world_camera: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    level_m: float,
) -> NDArray[np.float64]:
    """Return places (N, 3) all over the level surface that the camera sees, those at its borders among them."""
    steps = np.linspace(0.0, 1.0, _PER_SIDE)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    size = np.array([camera.width_px, camera.height_px])
    on_water = np.column_stack([low + grid * (high - low), np.full(len(grid), level_m)])
    pixels = project(camera, T_world_camera, on_water)[0]
    on_water = on_water[((pixels >= 0) & (pixels <= size)).all(axis=1)]
    directions = rays(camera, T_world_camera, grid * size)
    falling = directions[:, 2] < -0.02
    depth = (level_m - T_world_camera[2, 3]) / directions[falling, 2]
    in_picture = T_world_camera[:3, 3] + depth[:, None] * directions[falling]
    beside = _BESIDE * (high - low)
    is_in = ((in_picture[:, :2] >= low - beside) & (in_picture[:, :2] <= high + beside)).all(axis=1)
    return np.concatenate([on_water, in_picture[is_in]])


def ways_of(rays: WaterRays, eye: Eye) -> NDArray[np.float32]:
    """Return the ways (7, R, C) float32 of the nodes' rays in the picture of an eye."""
    ways = np.empty((PLANES, *rays.nodes.shape[1:]), np.float32)
    onto = np.ascontiguousarray(eye.camera.intrinsic_matrix @ eye.T_world_camera[:3, :3].T)
    _lay_ways(rays, onto, np.ascontiguousarray(rays.position_m - eye.T_world_camera[:3, 3]), ways)
    return ways


@row_kernel(error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def _lay_ways(
    rays: WaterRays, onto: NDArray[np.float64], from_eye: NDArray[np.float64], ways: NDArray[np.float32]
) -> None:
    """Write the ways.

    Args:
        onto: (3, 3) from a place, as the eye has it before it along the world's axes, to its homogeneous pixel.
        from_eye: (3,) from the eye to the camera, world frame.
    """
    nodes, floor_m = rays.nodes, rays.water.depth_m
    for i in range(nodes.shape[1]):
        y = i * STEP_PX + rays.pixel_offset
        for j in range(nodes.shape[2]):
            x = j * STEP_PX + rays.pixel_offset
            depth = nodes[SURFACE_DEPTH, i, j]
            dx, dy, dz = ray(rays.matrix, x, y)
            px, py, pz = from_eye[0] + depth * dx, from_eye[1] + depth * dy, from_eye[2] + depth * dz
            sx, sy = (
                onto[0, 0] * px + onto[0, 1] * py + onto[0, 2] * pz,
                onto[1, 0] * px + onto[1, 1] * py + onto[1, 2] * pz,
            )
            sz = onto[2, 0] * px + onto[2, 1] * py + onto[2, 2] * pz
            # Along the bent ray, per unit of camera depth.
            bx, by, bz = ray(rays.matrix, x + nodes[TOWARDS_X, i, j], y + nodes[TOWARDS_Y, i, j])
            ux, uy = (
                onto[0, 0] * bx + onto[0, 1] * by + onto[0, 2] * bz,
                onto[1, 0] * bx + onto[1, 1] * by + onto[1, 2] * bz,
            )
            uz = onto[2, 0] * bx + onto[2, 1] * by + onto[2, 2] * bz
            if depth >= FARTHEST_M or sz <= 0.0 or uz <= 0.0:
                for plane in range(PLANES):
                    ways[plane, i, j] = 0.0
                ways[ENTRY_DEPTH, i, j] = FARTHEST_M
                continue
            a_x, a_y = sx / sz, sy / sz
            ways[ENTRY_X, i, j], ways[ENTRY_Y, i, j], ways[ENTRY_DEPTH, i, j] = a_x - 0.5, a_y - 0.5, sz
            ways[ALONG_X, i, j], ways[ALONG_Y, i, j] = ux / uz - a_x, uy / uz - a_y
            ways[SCALE, i, j] = 1.0 / uz
            ways[FLOOR_SHARE, i, j] = 1.0 - sz / (sz - floor_m / bz * uz)
