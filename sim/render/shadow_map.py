"""Shadow maps: how high, towards the sun, the nearest surface lies, drawn by the rasteriser's own kernels.

A map covers a square *region* of the plane square to the sun. Regions come from a fixed lattice (sides in
powers of sqrt 2, centres a sixth of a side apart), so which region a view gets depends on the view alone and
never on the views before it, while neighbouring views mostly share one: bodies that never move are drawn once
for a region and kept.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.scene import SceneArrays, pack_geometry
from sim.render.triangles import body_may_show, project_body, row_span, set_up_triangle
from sim.world import World

NOTHING = np.float32(-1e30)
"""Height in a texel that no caster covers."""

_CENTRES_PER_SIDE = 6
_REGIONS_KEPT = 6


@dataclass(frozen=True, slots=True)
class ShadowMap:
    """Heights of shadow casters.

    Attributes:
        height_m: (N, N) float32 along the direction towards the sun; ``NOTHING`` where there is no caster, and in
            the outermost texels. Valid until the next map is made.
        light_view: (4, 4) from the world to ``(column, row, 1, height)``.
        texel_m: side of a texel.
    """

    height_m: NDArray[np.float32]
    light_view: NDArray[np.float64]
    texel_m: float


def light_axes(sun_direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rows (3, 3): right, down and towards the sun; seen from the sun, x is right and y down."""
    towards = sun_direction / np.linalg.norm(sun_direction)
    aside = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(aside, towards)
    right /= np.linalg.norm(right)
    # Forward, away from the sun, is right x down.
    return np.stack([right, np.cross(-towards, right), towards])


class ShadowCaster:
    """Draws shadow maps of a world. Bodies of category ``ground`` receive shadows and cast none."""

    def __init__(self, world: World, sun_direction: NDArray[np.float64], size: int = 1024) -> None:
        self._world = world
        self._axes = light_axes(np.asarray(sun_direction, dtype=float))
        self._size = size
        self._body_count = -1
        self._kept: OrderedDict[tuple[int, int, int], tuple[NDArray[np.float32], NDArray[np.int64]]]
        self._kept = OrderedDict()

    def covering(self, points_world_m: NDArray[np.float64]) -> ShadowMap:
        """Return the map of the region about points (N, 3), with all bodies where they are now."""
        self._pack()
        key = self._region(points_world_m)
        texel_m = _side_m(key[0]) / self._size
        light_view = self._light_view(key, texel_m)
        if key not in self._kept:
            self._keep(key, light_view)
        self._kept.move_to_end(key)
        height_m, changed = self._kept[key]
        _redraw_movers(
            self._scene,
            self._world.poses,
            light_view,
            self._movers,
            self._projected,
            height_m[0],
            height_m[1],
            changed,
        )
        return ShadowMap(height_m[1], light_view, texel_m)

    def _region(self, points_world_m: NDArray[np.float64]) -> tuple[int, int, int]:
        across = points_world_m @ self._axes[:2].T
        low, high = across.min(axis=0), across.max(axis=0)
        # The lattice may miss the middle by half a step on either side.
        needed_m = max(float((high - low).max()), 1.0) / (1.0 - 1.0 / _CENTRES_PER_SIDE)
        level = int(np.ceil(2.0 * np.log2(needed_m)))
        step_m = _side_m(level) / _CENTRES_PER_SIDE
        column, row = np.round(0.5 * (low + high) / step_m).astype(int)
        return level, int(column), int(row)

    def _light_view(self, key: tuple[int, int, int], texel_m: float) -> NDArray[np.float64]:
        step_m = _side_m(key[0]) / _CENTRES_PER_SIDE
        view = np.zeros((4, 4))
        view[:2, :3] = self._axes[:2] / texel_m
        view[:2, 3] = 0.5 * self._size - np.array(key[1:]) * step_m / texel_m
        view[2, 3] = 1.0
        view[3, :3] = self._axes[2]
        return view

    def _keep(self, key: tuple[int, int, int], light_view: NDArray[np.float64]) -> None:
        if len(self._kept) >= _REGIONS_KEPT:
            (height_m, changed) = self._kept.popitem(last=False)[1]
        else:
            height_m = np.empty((2, self._size, self._size), np.float32)
            changed = np.empty((len(self._movers), 4), np.int64)
        height_m[0] = NOTHING
        _draw_all(self._scene, self._world.poses, light_view, self._fixed, self._projected, height_m[0])
        height_m[1] = height_m[0]
        changed[:] = 0
        self._kept[key] = (height_m, changed)

    def _pack(self) -> None:
        if self._body_count == len(self._world.bodies):
            return
        bodies = self._world.bodies
        casts = [body for body in bodies if body.category != "ground"]
        self._scene: SceneArrays = pack_geometry([body.mesh for body in bodies])
        self._movers = np.array([body.index for body in casts if body.movable], dtype=np.int64)
        self._fixed = np.array([body.index for body in casts if not body.movable], dtype=np.int64)
        self._projected = np.empty((int(np.diff(self._scene.first_vertex).max(initial=0)), 4))
        self._kept.clear()
        self._body_count = len(bodies)


def _side_m(level: int) -> float:
    return float(2.0 ** (0.5 * level))


@njit(cache=True)
def _draw_all(
    scene: SceneArrays,
    poses: NDArray[np.float64],
    light_view: NDArray[np.float64],
    bodies: NDArray[np.int64],
    projected: NDArray[np.float64],
    height_m: NDArray[np.float32],
) -> None:
    changed = np.empty(4, np.int64)
    for n in range(bodies.shape[0]):
        _draw_body(scene, poses[bodies[n]], light_view, bodies[n], projected, height_m, changed)


@njit(cache=True)
def _redraw_movers(
    scene: SceneArrays,
    poses: NDArray[np.float64],
    light_view: NDArray[np.float64],
    bodies: NDArray[np.int64],
    projected: NDArray[np.float64],
    fixed_m: NDArray[np.float32],
    height_m: NDArray[np.float32],
    changed: NDArray[np.int64],
) -> None:
    """Take the movers' last shadows off ``height_m`` (their ``changed`` boxes, from ``fixed_m``); draw new
    ones.
    """
    for n in range(bodies.shape[0]):
        for row in range(changed[n, 0], changed[n, 1]):
            for column in range(changed[n, 2], changed[n, 3]):
                height_m[row, column] = fixed_m[row, column]
    for n in range(bodies.shape[0]):
        _draw_body(scene, poses[bodies[n]], light_view, bodies[n], projected, height_m, changed[n])


@njit(cache=True)
def _draw_body(
    scene: SceneArrays,
    pose: NDArray[np.float64],
    light_view: NDArray[np.float64],
    body: int,
    projected: NDArray[np.float64],
    height_m: NDArray[np.float32],
    changed: NDArray[np.int64],
) -> None:
    """Raise ``height_m`` to the body's faces that look to the sun; ``changed`` is set to the rows and columns
    (first, after the last, first, after the last) that may have changed.
    """
    size = height_m.shape[0]
    changed[0], changed[1], changed[2], changed[3] = size, 0, size, 0
    centre_m = np.empty(3)
    for k in range(3):
        centre_m[k] = pose[k, 3]
        for j in range(3):
            centre_m[k] += pose[k, j] * scene.centre_m[body, j]
    if not body_may_show(light_view, centre_m, scene.radius_m[body], size, size, 0.0):
        changed[:] = 0
        return
    start = scene.first_vertex[body]
    project_body(light_view, pose, scene.vertices_m[start : scene.first_vertex[body + 1]], projected)
    edges = np.empty((4, 3))
    plane = np.empty(3)
    for face in range(scene.first_face[body], scene.first_face[body + 1]):
        q0 = projected[scene.faces[face, 0] - start]
        q1 = projected[scene.faces[face, 1] - start]
        q2 = projected[scene.faces[face, 2] - start]
        first, last, edge_count = set_up_triangle(q0, q1, q2, 0.0, size, edges)
        for k in range(3):
            plane[k] = q0[3] * edges[0, k] + q1[3] * edges[1, k] + q2[3] * edges[2, k]
        for row in range(first, last):
            left, right = row_span(edges, edge_count, row, size)
            if left >= right:
                continue
            changed[0], changed[1] = min(changed[0], row), max(changed[1], row + 1)
            changed[2], changed[3] = min(changed[2], left), max(changed[3], right)
            base = plane[1] * row + plane[2]
            for column in range(left, right):
                value = np.float32(base + plane[0] * column)
                if value > height_m[row, column]:
                    height_m[row, column] = value
