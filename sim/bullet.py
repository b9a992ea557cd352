"""PyBullet beside a world: its renderer as a reference, and the world as a live physics simulation.

The scenes need neither: they move their bodies by plans of their own, and ``raster`` draws them. This is the only
module that imports PyBullet, and it does so when one of these is created: ``TinyRenderer`` (``--renderer pybullet``),
or ``client``, for a robot, for dynamics, or for rays cast by an engine that is not ours.
"""

from __future__ import annotations

import math
import tempfile
import threading
import weakref
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from sim.mesh import Texture, TexturedMesh
from sim.native_stderr import native_stderr_discarded
from sim.optics import Camera, invert_pose
from sim.world import Body, World

DENSITY_KGPM3 = 500.0
"""Mass over the volume of a movable body's convex hull: between a car, 150, and a person, 985."""
_WORLDS, _USERS = 2, 1
"""Collision groups: bodies held in their places pass through one another, but not through a user's bodies."""


class Engine:
    """A connection to Bullet: PyBullet's functions, bound to it, and constants. It ends when it is dropped.

    As ``pybullet_utils.bullet_client``, which prints a line to stdout for every connection.
    """

    def __init__(self) -> None:
        """Connect. Raises ImportError where PyBullet is not installed."""
        self._pybullet = _pybullet()
        number = self._pybullet.connect(self._pybullet.DIRECT)
        self._options = {"physicsClientId": number}
        self.disconnect = weakref.finalize(self, self._pybullet.disconnect, number)

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._pybullet, name)
        return partial(attribute, **self._options) if callable(attribute) else attribute


def _pybullet() -> Any:
    try:
        # It prints a line at its import, in every worker.
        with native_stderr_discarded():
            import pybullet
    except ImportError as error:
        raise ImportError(
            "pybullet: expected to be installed, for --renderer pybullet and sim.bullet alone; "
            "`pip install pybullet` on Linux x86-64 with Python 3.11, `pip install pybullet-arm64` elsewhere",
            name="pybullet",
        ) from error
    return pybullet


class TinyRenderer:
    """Draws a world with PyBullet's own renderer.

    A client of its own holds the shapes, and the textures, which are passed as files.
    """

    def __init__(self, world: World) -> None:
        self._world, self._engine = world, Engine()
        self._handles: list[int] = []
        self._poses = np.empty((0, 4, 4))
        self._texture_handles: dict[Texture, int] = {}

    def hand_over(self) -> None:
        """Pass bodies, textures and present poses to PyBullet; ``camera_image`` calls this."""
        kept, bodies, poses = len(self._handles), self._world.bodies, self._world.poses
        for index in np.flatnonzero((poses[:kept] != self._poses[:kept]).any(axis=(1, 2))):
            self._engine.resetBasePositionAndOrientation(self._handles[index], *to_bullet(poses[index]))
        for body, pose in zip(bodies[kept:], poses[kept:], strict=True):
            self._handles.append(self._add(body.mesh, pose))
        self._poses = poses.copy()

    def _add(self, mesh: TexturedMesh, T_world_body: NDArray[np.float64]) -> int:
        visual = self._engine.createVisualShape(
            self._engine.GEOM_MESH,
            vertices=_VERTICES.holding(mesh.vertices_m),
            normals=_NORMALS.holding(mesh.normals),
            # PyBullet's v grows upwards.
            uvs=_UVS.holding(np.column_stack([mesh.uv[:, 0], 1.0 - mesh.uv[:, 1]])),
            indices=_INDICES.holding(mesh.faces.ravel()),
            rgbaColor=(1, 1, 1, 1),
        )
        position, quaternion = to_bullet(T_world_body)
        handle: int = self._engine.createMultiBody(
            baseMass=0, baseVisualShapeIndex=visual, basePosition=position, baseOrientation=quaternion
        )
        if mesh.texture not in self._texture_handles:
            with tempfile.TemporaryDirectory() as folder:
                path = str(Path(folder) / "texture.png")
                cv2.imwrite(path, mesh.texture.rgb[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])
                self._texture_handles[mesh.texture] = self._engine.loadTexture(path)
        self._engine.changeVisualShape(handle, -1, textureUniqueId=self._texture_handles[mesh.texture])
        return handle

    def camera_image(
        self,
        camera: Camera,
        T_world_camera: NDArray[np.float64],
        *,
        near_m: float,
        far_m: float,
        pixel_offset: float = 0.5,
        shadows: bool = False,
        light_direction: tuple[float, float, float] = (0.0, 0.0, 1.0),
        lit: bool = False,
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.int32]]:
        """Draw the world as it is now.

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
        _, _, rgba, depth_buffer, segmentation = self._engine.getCameraImage(
            camera.width_px,
            camera.height_px,
            _opengl_view(T_world_camera),
            _opengl_projection(camera, near_m, far_m, pixel_offset),
            lightDirection=light_direction,
            lightAmbientCoeff=0.6 if lit else 1.0,
            lightDiffuseCoeff=0.35 if lit else 0.0,
            lightSpecularCoeff=0.05 if lit else 0.0,
            shadow=int(shadows),
            renderer=self._engine.ER_TINY_RENDERER,
        )
        index_of_handle = np.full(max(self._handles, default=0) + 2, -1, dtype=np.int32)
        index_of_handle[self._handles] = np.arange(len(self._handles))
        # Arrays, or tuples of numbers where PyBullet was built without NumPy.
        size = camera.height_px, camera.width_px
        return (
            np.ascontiguousarray(np.asarray(rgba, dtype=np.uint8).reshape(*size, 4)[..., :3]),
            np.asarray(depth_buffer, dtype=np.float32).reshape(size),
            index_of_handle[np.asarray(segmentation, dtype=np.int32).reshape(size)],
        )


class _Shown(NamedTuple):
    """A visual shape of a user's body, and the body of the world that draws it."""

    body: Body
    handle: int
    link: int
    T_link_shape: NDArray[np.float64]


class Client:
    """A world in Bullet, with collision shapes, masses and joints; a context manager.

    Fixed bodies have mass 0 and collide with their own triangles. Movable ones collide with their convex hulls and
    have the mass of the hull's volume at ``DENSITY_KGPM3``; one without volume, such as a sail, is as a fixed body.
    A world's people and fish are rigid parts without joints of their own, whose gait sets every pose. So each movable
    body is held in its place by a fixed joint to the world, which ``push`` moves with the scene: it cannot be shoved
    aside, and shoves what it stands in. ``release`` takes the joint away, and dynamics move the body from then on.

    Attributes:
        engine: PyBullet's functions, bound to this client: ``client.engine.loadURDF(…)``, ``.rayTest(…)``,
            ``.stepSimulation()``.
        handles: PyBullet's number of every body of the world at the time of the call.
    """

    def __init__(self, world: World, exact: bool = False) -> None:
        """See ``client``."""
        self._world, self.engine = world, Engine()
        self.engine.setGravity(0.0, 0.0, -9.81)
        self._centres_m = np.zeros((len(world.bodies), 3))
        self._joints: dict[int, int] = {}
        self._shown: list[_Shown] = []
        self._bodies = list(world.bodies)
        self.handles = [self._add(body, exact) for body in self._bodies]

    def _add(self, body: Body, exact: bool) -> int:
        vertices_m, mass_kg = body.mesh.vertices_m, 0.0
        if body.movable and not exact:
            mass_kg = _hull_volume_m3(vertices_m) * DENSITY_KGPM3
        if mass_kg > 0:
            # Bullet takes the origin for the centre of mass.
            self._centres_m[body.index] = 0.5 * (vertices_m.min(axis=0) + vertices_m.max(axis=0))
            centred_m = vertices_m - self._centres_m[body.index]
            shape = self.engine.createCollisionShape(self.engine.GEOM_MESH, vertices=_VERTICES.holding(centred_m))
        else:
            shape = self.engine.createCollisionShape(
                self.engine.GEOM_MESH,
                vertices=_VERTICES.holding(vertices_m),
                indices=_INDICES.holding(body.mesh.faces.ravel()),
                flags=self.engine.GEOM_FORCE_CONCAVE_TRIMESH,
            )
        position, quaternion = to_bullet(self._centred(body.index))
        handle: int = self.engine.createMultiBody(
            baseMass=mass_kg, baseCollisionShapeIndex=shape, basePosition=position, baseOrientation=quaternion
        )
        if mass_kg > 0:
            fixed = self.engine.JOINT_FIXED
            self._joints[body.index] = self.engine.createConstraint(
                handle, -1, -1, -1, fixed, [0, 0, 0], [0, 0, 0], position, childFrameOrientation=quaternion
            )
        self.engine.setCollisionFilterGroupMask(handle, -1, _WORLDS, ~_WORLDS)
        return handle

    def _centred(self, index: int) -> NDArray[np.float64]:
        """Return the pose (4, 4) of a body's centre of mass."""
        T_world_body = self._world.poses[index].copy()
        T_world_body[:3, 3] += T_world_body[:3, :3] @ self._centres_m[index]
        return T_world_body

    def push(self) -> None:
        """Bring every held body to where the world has it now."""
        shown = {each.body.index for each in self._shown}
        for body, handle in zip(self._bodies, self.handles, strict=True):
            if body.movable and body.index not in shown:
                position, quaternion = to_bullet(self._centred(body.index))
                joint = self._joints.get(body.index)
                if joint is not None:
                    self.engine.changeConstraint(joint, position, quaternion)
                self.engine.resetBasePositionAndOrientation(handle, position, quaternion)
                self.engine.resetBaseVelocity(handle, [0, 0, 0], [0, 0, 0])

    def release(self, body: Body) -> None:
        """Take away the joint that holds a movable body: dynamics move it, and ``pull`` shows where.

        Raises:
            ValueError: if no joint holds it.
        """
        if body.index not in self._joints:
            raise ValueError(f"body: expected one that a joint holds, got {body.name!r}")
        handle = self.handles[body.index]
        self.engine.removeConstraint(self._joints.pop(body.index))
        self.engine.setCollisionFilterGroupMask(handle, -1, _USERS, -1)
        T_link_shape = np.eye(4)
        T_link_shape[:3, 3] = -self._centres_m[body.index]
        self._shown.append(_Shown(body, handle, -1, T_link_shape))

    def show(self, handle: int, name: str, category: str = "user") -> list[Body]:
        """Add what a user's body looks like to the world, and return it: a movable body for each visual shape.

        ``pull`` moves these. Show a body before shaders and renderers of the world are made.
        """
        added: list[Body] = []
        for _, link, kind, size, file, position, quaternion, rgba in self.engine.getVisualShapeData(handle):
            mesh = self._mesh(kind, size, Path(file.decode()), rgba)
            body = self._world.add(mesh, np.eye(4), name=f"{name} {len(added)}", category=category, movable=True)
            self._shown.append(_Shown(body, handle, link, self._pose(position, quaternion)))
            added.append(body)
        self.pull()
        return added

    def pull(self) -> None:
        """Bring the bodies of the world that are shown or released to where Bullet has them now."""
        for body, handle, link, T_link_shape in self._shown:
            if link >= 0:
                pose = self._pose(*self.engine.getLinkState(handle, link, computeForwardKinematics=True)[4:6])
            else:
                inertial = self._pose(*self.engine.getDynamicsInfo(handle, -1)[3:5])
                pose = self._pose(*self.engine.getBasePositionAndOrientation(handle)) @ invert_pose(inertial)
            self._world.move(body, pose @ T_link_shape)

    def _pose(self, position: Any, quaternion: Any) -> NDArray[np.float64]:
        T = np.eye(4)
        T[:3, :3] = np.reshape(self.engine.getMatrixFromQuaternion(quaternion), (3, 3))
        T[:3, 3] = position
        return T

    def _mesh(self, kind: int, size: Any, file: Path, rgba: Any) -> TexturedMesh:
        """Return a visual shape as flat-shaded triangles of one colour."""
        if kind == self.engine.GEOM_MESH:
            shape: Any = trimesh.load(file, force="mesh")
            shape.apply_scale(size)
        elif kind == self.engine.GEOM_BOX:
            shape = trimesh.creation.box(size)
        elif kind == self.engine.GEOM_SPHERE:
            shape = trimesh.creation.icosphere(radius=size[0])
        elif kind == self.engine.GEOM_CYLINDER:
            shape = trimesh.creation.cylinder(radius=size[1], height=size[0])
        elif kind == self.engine.GEOM_CAPSULE:
            shape = trimesh.creation.capsule(radius=size[1], height=size[0])
        else:
            raise ValueError(f"shape: expected a mesh, box, sphere, cylinder or capsule, got PyBullet's kind {kind}")
        colour = np.round(255 * np.array(rgba[:3])).astype(np.uint8)
        return TexturedMesh(
            shape.triangles.reshape(-1, 3).astype(np.float32),
            np.repeat(shape.face_normals, 3, axis=0).astype(np.float32),
            np.full((3 * len(shape.faces), 2), 0.5, np.float32),
            np.arange(3 * len(shape.faces), dtype=np.int32).reshape(-1, 3),
            Texture(np.tile(colour, (2, 2, 1))),
        )

    def close(self) -> None:
        """Free Bullet's memory. A client that is dropped is closed, too."""
        self.engine.disconnect()

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def client(world: World, exact: bool = False) -> Client:
    """Return a world as a live Bullet client.

    Args:
        exact: give movable bodies, too, their own triangles in place of convex hulls, and mass 0: rays then hit what
            pictures show, but dynamics never move these bodies.

    Raises:
        ImportError: where PyBullet is not installed.
    """
    return Client(world, exact)


class _ReusedList(threading.local):
    """A reused list of numbers or points for PyBullet, which never frees the lists passed to it; one a thread.

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


_VERTICES, _NORMALS, _UVS, _INDICES = _ReusedList(), _ReusedList(), _ReusedList(), _ReusedList()


def _hull_volume_m3(points_m: NDArray[np.float32]) -> float:
    """Return the volume of the convex hull of points (N, 3), 0 if they lie in a plane."""
    try:
        return float(ConvexHull(points_m).volume)
    except QhullError:
        return 0.0


def to_bullet(T: NDArray[np.float64]) -> tuple[list[float], list[float]]:
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


def _opengl_projection(camera: Camera, near_m: float, far_m: float, pixel_offset: float) -> list[float]:
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
