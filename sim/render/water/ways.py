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

from sim.optics import Camera, Intrinsics, intrinsic_matrix, project, rays
from sim.render.compilation import row_kernel
from sim.render.water.rays import ALONG_X as TOWARDS_X
from sim.render.water.rays import ALONG_Y as TOWARDS_Y
from sim.render.water.rays import FARTHEST_M, STEP_PX, SURFACE_DEPTH, WaterRays

ENTRY_X, ENTRY_Y, ENTRY_DEPTH, ALONG_X, ALONG_Y, SCALE, FLOOR_SHARE = range(7)
"""Planes of ways, at the nodes of ``WaterRays``: a, in pixels from the middle of the first; z; e; b; and the share
``1 - z / w`` at the floor."""
PLANES = 7
_PER_SIDE = 9
_BORDER_PX = 12
_BESIDE = 0.05


class Eye(NamedTuple):
    """The camera of the inner picture, and its pose (4, 4)."""

    camera: Camera
    T_world_camera: NDArray[np.float64]


@lru_cache(maxsize=16)
def eye_of(
    camera: Camera, pose: bytes, rectangle_m: tuple[float, ...], level_m: float, depth_m: float, index: float
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
    unit = Intrinsics(0, 0, 1.0)
    shown, seen = project(unit, T_world_eye, np.stack([entries, ends]))[0], project(camera, T_world_camera, entries)[0]
    focal_px = float(np.linalg.norm(seen - seen.mean(axis=0)) / np.linalg.norm(shown[1] - shown[1].mean(axis=0)))
    half_px = np.abs(shown).max(axis=(0, 1)) * focal_px + _BORDER_PX
    width_px, height_px = (8 * int(np.ceil(half / 4.0)) for half in half_px)
    return Eye(Intrinsics(width_px, height_px, focal_px), T_world_eye)


def _entries(
    camera: Camera,
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
    onto = np.ascontiguousarray(intrinsic_matrix(eye.camera) @ eye.T_world_camera[:3, :3].T)
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
    m, floor_m = rays.matrix, rays.water.depth_m
    # What is before the eye per unit along the rays of the camera: the pixels of both are related by one matrix.
    a, b, c = _through(onto, m[:, 0]), _through(onto, m[:, 1]), _through(onto, m[:, 2])
    at_x, at_y, at_z = _through(onto, from_eye)
    m_x, m_y, m_z = m[2, 0], m[2, 1], m[2, 2]
    for i in range(ways.shape[1]):
        y = i * STEP_PX + rays.pixel_offset
        base_x, base_y, base_z = b[0] * y + c[0], b[1] * y + c[1], b[2] * y + c[2]
        depths, towards_x, towards_y = (
            rays.nodes[SURFACE_DEPTH, i],
            rays.nodes[TOWARDS_X, i],
            rays.nodes[TOWARDS_Y, i],
        )
        entry_x, entry_y, entry_depth = ways[ENTRY_X, i], ways[ENTRY_Y, i], ways[ENTRY_DEPTH, i]
        along_x, along_y, scale, floor = ways[ALONG_X, i], ways[ALONG_Y, i], ways[SCALE, i], ways[FLOOR_SHARE, i]
        for j in range(depths.shape[0]):
            x, depth, ex, ey = np.int32(j * STEP_PX) + rays.pixel_offset, depths[j], towards_x[j], towards_y[j]
            px, py, pz = a[0] * x + base_x, a[1] * x + base_y, a[2] * x + base_z
            sx, sy, sz = at_x + depth * px, at_y + depth * py, at_z + depth * pz
            # Along the bent ray, per unit of camera depth.
            ux, uy, uz = px + a[0] * ex + b[0] * ey, py + a[1] * ex + b[1] * ey, pz + a[2] * ex + b[2] * ey
            fall = m_x * (x + ex) + m_y * (y + ey) + m_z
            misses = (depth >= FARTHEST_M) | (sz <= 0.0) | (uz <= 0.0)
            a_x, a_y = sx / sz, sy / sz
            entry_x[j], entry_y[j] = 0.0 if misses else a_x - 0.5, 0.0 if misses else a_y - 0.5
            entry_depth[j] = FARTHEST_M if misses else sz
            along_x[j], along_y[j] = 0.0 if misses else ux / uz - a_x, 0.0 if misses else uy / uz - a_y
            scale[j] = 0.0 if misses else 1.0 / uz
            floor[j] = 0.0 if misses else 1.0 - sz / (sz - floor_m / fall * uz)


@row_kernel(forceinline=True)
def _through(matrix: NDArray[np.float64], vector: NDArray[np.float64]) -> tuple[float, float, float]:
    return (
        matrix[0, 0] * vector[0] + matrix[0, 1] * vector[1] + matrix[0, 2] * vector[2],
        matrix[1, 0] * vector[0] + matrix[1, 1] * vector[1] + matrix[1, 2] * vector[2],
        matrix[2, 0] * vector[0] + matrix[2, 1] * vector[1] + matrix[2, 2] * vector[2],
    )
