"""Contact shadows of bodies on the ground, from spheres along each body.

A sphere of radius r, its centre h above a place on level ground and d away, blocks the share ``r² h / d³`` of the light
of a uniform half sphere: the cosine times the solid angle, over pi. The remaining shares of spheres are multiplied.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.mesh import TexturedMesh
from sim.optics import PinholeCamera
from sim.render.triangles import camera_view
from sim.render.visibility import NEAR_M
from sim.shaders.baked.light_grid import HEIGHTS_M, Grid
from sim.world import World

STEP_M = 0.08
_LEAST = 0.01
_MOST_SPHERES = 4


class ContactShadows:
    """Keeps a map of the share of light that moving bodies leave on the ground."""

    def __init__(self, world: World, grid: Grid) -> None:
        low_m = grid.first_m - 0.5 * grid.steps_m
        size_m = grid.steps_m * (grid.columns, grid.rows)
        columns, rows = (np.ceil(size_m / STEP_M).astype(int) + 2).tolist()
        self.first_m = low_m - 0.5 * STEP_M
        self.ground_m = float(grid.heights_m[0]) - HEIGHTS_M[0]
        self.left = np.ones((rows, columns), np.float32)
        spheres = [(body.index, *sphere) for body in world.bodies if body.movable for sphere in _spheres(body.mesh)]
        self._owner = np.array([owner for owner, _, _ in spheres], dtype=np.int64)
        self._centre_m = np.array([centre for _, centre, _ in spheres], dtype=float).reshape(-1, 3)
        self._radius_m = np.array([radius for _, _, radius in spheres], dtype=float)
        self._changed = np.zeros((len(spheres), 4), np.int64)

    def columns(
        self, heights_m: NDArray[np.float64], camera: PinholeCamera, T_world_camera: NDArray[np.float64]
    ) -> NDArray[np.int32]:
        """Return the columns (H, 2), first and after the last, of each row where the ground may be darkened.

        Args:
            heights_m: (2,), the lowest and the highest ground.
        """
        within = np.empty((camera.height_px, 2), np.int32)
        view = camera_view(camera, T_world_camera, 0.5)
        _columns_of(self._changed, self.first_m, heights_m, view, camera.width_px, within)
        return within

    def move(self, poses: NDArray[np.float64]) -> None:
        """Update the map for poses (B, 4, 4) of all bodies."""
        _draw(
            poses,
            self._owner,
            self._centre_m,
            self._radius_m,
            np.array([*self.first_m, self.ground_m]),
            self._changed,
            self.left,
        )


def _spheres(mesh: TexturedMesh) -> list[tuple[NDArray[np.float64], float]]:
    """Return centres (3,) and radii of spheres along a body's longest axis that approximate it."""
    low_m, high_m = mesh.vertices_m.min(axis=0).astype(float), mesh.vertices_m.max(axis=0).astype(float)
    half_m = 0.5 * (high_m - low_m)
    longest = int(half_m.argmax())
    thin, thick = np.delete(half_m, longest)
    radius_m = float(np.sqrt(max(thin, 1e-3) * max(thick, 1e-3)))
    count = int(np.clip(round(half_m[longest] / radius_m), 1, _MOST_SPHERES))
    reach_m = max(half_m[longest] - radius_m, 0.0)
    along = np.linspace(-reach_m, reach_m, count) if count > 1 else np.zeros(1)
    return [(0.5 * (low_m + high_m) + step_m * np.eye(3)[longest], radius_m) for step_m in along]


@njit(cache=True)
def _columns_of(
    changed: NDArray[np.int64],
    origin_m: NDArray[np.float64],
    heights_m: NDArray[np.float64],
    view: NDArray[np.float64],
    width: int,
    within: NDArray[np.int32],
) -> None:
    """Write the columns of each row (H, 2) of the box around the darkened ground in the picture.

    Args:
        changed: see ``_draw``.
        origin_m: (2,) of the first sample.
        view: the view matrix of a camera.
    """
    height = within.shape[0]
    within[:, 0], within[:, 1] = width, 0
    corners = np.empty((8, 3))
    for n in range(changed.shape[0]):
        if changed[n, 0] >= changed[n, 1]:
            continue
        left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
        for corner in range(8):
            # One more sample, as light is interpolated from both sides.
            x = origin_m[0] + STEP_M * (changed[n, 2] - 1 if corner % 2 == 0 else changed[n, 3])
            y = origin_m[1] + STEP_M * (changed[n, 0] - 1 if corner % 4 < 2 else changed[n, 1])
            z = heights_m[corner // 4]
            for k in range(3):
                corners[corner, k] = view[k, 0] * x + view[k, 1] * y + view[k, 2] * z + view[k, 3]
        # Every corner, and for those before the near plane where the ways to the others cross it.
        for corner in range(8):
            for other in range(8):
                share = 0.0
                if corners[corner, 2] < NEAR_M:
                    if corners[other, 2] < NEAR_M:
                        continue
                    share = (NEAR_M - corners[corner, 2]) / (corners[other, 2] - corners[corner, 2])
                # Numbers, not an array: making one takes longer than all else here.
                depth = corners[corner, 2] + share * (corners[other, 2] - corners[corner, 2])
                across = (corners[corner, 0] + share * (corners[other, 0] - corners[corner, 0])) / depth
                down = (corners[corner, 1] + share * (corners[other, 1] - corners[corner, 1])) / depth
                left, right, top, bottom = min(left, across), max(right, across), min(top, down), max(bottom, down)
        if not (right > 0.0 and left < width and bottom > 0.0 and top < height):
            continue
        first, last = np.int32(max(np.floor(left), 0.0)), np.int32(min(np.ceil(right) + 1.0, width))
        for row in range(int(max(np.floor(top), 0.0)), int(min(np.ceil(bottom) + 1.0, height))):
            within[row, 0], within[row, 1] = min(within[row, 0], first), max(within[row, 1], last)


@njit(cache=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _draw(
    poses: NDArray[np.float64],
    owner: NDArray[np.int64],
    centre_m: NDArray[np.float64],
    radius_m: NDArray[np.float64],
    origin_m: NDArray[np.float64],
    changed: NDArray[np.int64],
    left: NDArray[np.float32],
) -> None:
    """Write the share of light that N spheres leave.

    Args:
        origin_m: (3,) x and y of the first sample, height of the ground.
        changed: (N, 4) rows and columns (first, after the last) that each sphere darkened; light is put back there, and
            the new ones written.
    """
    rows, columns = left.shape
    for n in range(owner.shape[0]):
        left[changed[n, 0] : changed[n, 1], changed[n, 2] : changed[n, 3]] = 1.0
    for n in range(owner.shape[0]):
        pose = poses[owner[n]]
        x, y, z = pose[0, 3] - origin_m[0], pose[1, 3] - origin_m[1], pose[2, 3] - origin_m[2]
        for k in range(3):
            x += pose[0, k] * centre_m[n, k]
            y += pose[1, k] * centre_m[n, k]
            z += pose[2, k] * centre_m[n, k]
        squared = radius_m[n] ** 2
        z = max(z, 0.5 * radius_m[n])
        reach_squared = (squared * z / _LEAST) ** (2.0 / 3.0) - z * z
        changed[n] = 0
        if reach_squared <= 0.0:
            continue
        reach, x, y = np.sqrt(reach_squared) / STEP_M, x / STEP_M, y / STEP_M
        top, bottom = max(int(np.ceil(y - reach)), 0), min(int(y + reach) + 1, rows)
        first, last = max(int(np.ceil(x - reach)), 0), min(int(x + reach) + 1, columns)
        if top >= bottom or first >= last:
            continue
        changed[n, 0], changed[n, 1], changed[n, 2], changed[n, 3] = top, bottom, first, last
        strength, height = np.float32(squared * z), np.float32(z * z)
        for row in range(top, bottom):
            dy = np.float32((row - y) * STEP_M)
            for column in range(first, last):
                dx = np.float32((column - x) * STEP_M)
                d_squared = dx * dx + dy * dy + height
                taken = strength / (d_squared * np.sqrt(d_squared)) - np.float32(_LEAST)
                left[row, column] *= np.float32(1.0) - min(max(taken, np.float32(0.0)), np.float32(1.0))
