"""The world: textured bodies at poses, owned by PyBullet. The only module that knows PyBullet."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.optics import PinholeCamera, invert_pose


@contextmanager
def _without_greeting() -> Iterator[None]:
    """Discard what native code prints to stderr meanwhile: PyBullet prints a line at its import, in every worker."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


with _without_greeting():
    import pybullet


class _LentList:
    """A reused list of numbers or points for PyBullet, which never frees the lists passed to it.

    With new lists a worker would grow by 25 MB with each town.
    """

    def __init__(self) -> None:
        self._list: list[Any] = []
        self._points: list[list[float]] = []

    def holding(self, values: NDArray[Any]) -> list[Any]:
        """Return the list with ``values`` (N,) or (N, D); until the next call."""
        if values.ndim == 1:
            self._list[:] = values.tolist()
            return self._list
        self._points += [[] for _ in range(len(values) - len(self._points))]
        for point, value in zip(self._points, values.tolist(), strict=False):
            point[:] = value
        self._list[:] = self._points[: len(values)]
        return self._list


_VERTICES, _NORMALS, _UVS, _INDICES = _LentList(), _LentList(), _LentList(), _LentList()


@dataclass(frozen=True, eq=False)
class Body:
    """One rigid body of a world.

    Attributes:
        index: in ``World.bodies``, and instance id in every picture.
        name: for people, e.g. ``"target"``.
        category: ``ground``, ``building``, ``tree``, ``kerb``, ``vehicle`` …
        mesh: its shape.
        movable: if False, the pose never changes, and renderers may cache the body.
    """

    index: int
    name: str
    category: str
    mesh: TexturedMesh
    movable: bool


class World:
    """Bodies and their poses. Use as a context manager, or call ``close``.

    PyBullet holds every body's shape. Only its own renderer needs textures, passed as files, and the present poses:
    ``camera_image`` passes them, as that is slow.
    """

    def __init__(self) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        self._handles: list[int] = []
        self._poses = np.empty((0, 4, 4))
        self._textured = 0
        self._moved: set[int] = set()
        self._texture_handles: dict[Texture, int] = {}
        self.bodies: list[Body] = []

    def add(
        self,
        mesh: TexturedMesh,
        T_world_body: NDArray[np.float64],
        *,
        name: str,
        category: str,
        movable: bool = False,
    ) -> Body:
        """Add a body and return it."""
        visual = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=_VERTICES.holding(mesh.vertices_m),
            normals=_NORMALS.holding(mesh.normals),
            # PyBullet's v grows upwards.
            uvs=_UVS.holding(np.column_stack([mesh.uv[:, 0], 1.0 - mesh.uv[:, 1]])),
            indices=_INDICES.holding(mesh.faces.ravel()),
            rgbaColor=(1, 1, 1, 1),
            physicsClientId=self._client,
        )
        position, quaternion = _to_bullet(T_world_body)
        handle = pybullet.createMultiBody(
            baseMass=0,
            baseVisualShapeIndex=visual,
            basePosition=position,
            baseOrientation=quaternion,
            physicsClientId=self._client,
        )
        body = Body(len(self.bodies), name, category, mesh, movable)
        self.bodies.append(body)
        self._handles.append(handle)
        self._poses = np.concatenate([self._poses, np.asarray(T_world_body, dtype=float)[None]])
        return body

    def remove_after(self, count: int) -> None:
        """Remove all bodies but the first ``count``.

        Until ``close`` PyBullet holds the memory of their shapes, about 100 KB a car, and its renderer's textures.
        """
        for handle in self._handles[count:]:
            pybullet.removeBody(handle, physicsClientId=self._client)
        del self.bodies[count:], self._handles[count:]
        self._poses = self._poses[:count].copy()
        self._textured = min(self._textured, count)
        self._moved = {index for index in self._moved if index < count}

    def move(self, body: Body, T_world_body: NDArray[np.float64]) -> None:
        """Set the pose (4, 4) of a movable body."""
        _require_movable(body)
        self._poses[body.index] = T_world_body
        self._moved.add(body.index)

    def move_all(self, bodies: Sequence[Body], T_world_body: NDArray[np.float64]) -> None:
        """Set the poses (B, 4, 4) of movable bodies."""
        for body in bodies:
            _require_movable(body)
        indices = [body.index for body in bodies]
        self._poses[indices] = T_world_body
        self._moved.update(indices)

    @property
    def poses(self) -> NDArray[np.float64]:
        """T_world_body of every body (B, 4, 4), in the order of ``bodies``; a view, not to be written to."""
        return self._poses

    def camera_image(
        self,
        camera: PinholeCamera,
        T_world_camera: NDArray[np.float64],
        *,
        near_m: float,
        far_m: float,
        pixel_offset: float = 0.5,
        shadows: bool = False,
        light_direction: tuple[float, float, float] = (0.0, 0.0, 1.0),
        lit: bool = False,
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.int32]]:
        """Draw with PyBullet's own renderer.

        Args:
            near_m, far_m: clipping depths.
            pixel_offset: where in a pixel it is sampled; 0.5 is its centre.
            shadows, lit: PyBullet's own shadows and shading; with both False the colours are those of the
                surfaces.
            light_direction: from the scene towards the light.

        Returns:
            rgb (H, W, 3) uint8; depth buffer (H, W) float32 in [0, 1]; body index (H, W) int32, -1 = none.
        """
        self.hand_over()
        _, _, rgba, depth_buffer, segmentation = pybullet.getCameraImage(
            camera.width_px,
            camera.height_px,
            _opengl_view(T_world_camera),
            _opengl_projection(camera, near_m, far_m, pixel_offset),
            lightDirection=light_direction,
            lightAmbientCoeff=0.6 if lit else 1.0,
            lightDiffuseCoeff=0.35 if lit else 0.0,
            lightSpecularCoeff=0.05 if lit else 0.0,
            shadow=int(shadows),
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        index_of_handle = np.full(max(self._handles, default=0) + 2, -1, dtype=np.int32)
        index_of_handle[self._handles] = np.arange(len(self._handles))
        return (
            np.ascontiguousarray(rgba[..., :3]),
            np.asarray(depth_buffer, dtype=np.float32),
            index_of_handle[segmentation],
        )

    def close(self) -> None:
        """Free PyBullet's memory; the world is unusable afterwards."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def __enter__(self) -> World:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def hand_over(self) -> None:
        """Pass textures and present poses to PyBullet; ``camera_image`` calls this."""
        for index in self._moved:
            position, quaternion = _to_bullet(self._poses[index])
            pybullet.resetBasePositionAndOrientation(
                self._handles[index], position, quaternion, physicsClientId=self._client
            )
        self._moved.clear()
        for body in self.bodies[self._textured :]:
            texture = body.mesh.texture
            if texture not in self._texture_handles:
                with tempfile.TemporaryDirectory() as folder:
                    path = str(Path(folder) / "texture.png")
                    cv2.imwrite(path, texture.rgb[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])
                    self._texture_handles[texture] = pybullet.loadTexture(path, physicsClientId=self._client)
            pybullet.changeVisualShape(
                self._handles[body.index],
                -1,
                textureUniqueId=self._texture_handles[texture],
                physicsClientId=self._client,
            )
        self._textured = len(self.bodies)


def _require_movable(body: Body) -> None:
    if not body.movable:
        raise ValueError(f"body: expected a movable one, got {body.name!r}, which was added with movable=False")


def _to_bullet(T: NDArray[np.float64]) -> tuple[list[float], list[float]]:
    """Return position and PyBullet's (x, y, z, w) quaternion of a pose.

    In plain floats: arrays of so few numbers take ten times as long, for every mover in every picture.
    """
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = np.asarray(T, dtype=float)[:3].tolist()
    trace = a + e + i
    # Shepperd's method: divide by the largest component.
    largest = max(trace, a, e, i)
    if largest == trace:
        q = [h - f, c - g, d - b, 1 + trace]
    elif largest == a:
        q = [1 + 2 * a - trace, b + d, c + g, h - f]
    elif largest == e:
        q = [b + d, 1 + 2 * e - trace, f + h, c - g]
    else:
        q = [c + g, f + h, 1 + 2 * i - trace, d - b]
    length = math.hypot(*q)
    return [x, y, z], [part / length for part in q]


def _opengl_view(T_world_camera: NDArray[np.float64]) -> list[float]:
    """Return OpenGL's column-major view matrix (camera frame there: x right, y up, z back)."""
    return (np.diag([1.0, -1.0, -1.0, 1.0]) @ invert_pose(T_world_camera)).T.ravel().tolist()


def _opengl_projection(camera: PinholeCamera, near_m: float, far_m: float, pixel_offset: float) -> list[float]:
    """Return OpenGL's column-major projection matrix.

    TinyRenderer samples a pixel at its bottom left corner; the picture is shifted by the wanted offset from there.
    """
    x = 2.0 * camera.focal_px / camera.width_px
    y = 2.0 * camera.focal_px / camera.height_px
    a = (near_m + far_m) / (near_m - far_m)
    b = 2.0 * near_m * far_m / (near_m - far_m)
    # Right and up, in units of half the picture, for a camera that looks along -z.
    right = 2.0 * pixel_offset / camera.width_px
    up = 2.0 * (1.0 - pixel_offset) / camera.height_px
    return [x, 0, 0, 0, 0, y, 0, 0, right, up, a, -1, 0, 0, b, 0]
