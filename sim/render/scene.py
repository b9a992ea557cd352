"""A world's shapes as flat arrays for kernels."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from sim.mesh import TexturedMesh
from sim.render.textures import TexturePool, TextureStore
from sim.world import World


class SceneArrays(NamedTuple):
    """The shapes of B bodies, in their own frames: V vertices and F faces in all.

    Attributes:
        vertices_m: (V, 3) float32.
        normals: (V, 3) float32.
        uv: (V, 2) float32.
        faces: (F, 3) int32, indices into the arrays above, counter-clockwise seen from outside.
        face_is_flat: (F,) bool, all three corners have the same normal.
        first_vertex, first_face: (B + 1,) int32, where each body's share begins.
        centre_m: (B, 3) float64, centre of the bounding sphere.
        radius_m: (B,) float64.
        texture: (B,) int32, index into the pool.
        first_chunk: (B + 1,) int32. Each body's faces are in chunks of ``CHUNK``, the last one of fewer.
        chunk_middle_m, chunk_half_m: (C, 3) float64, middles of the chunks' bounds, and half the bounds' sizes.
        chunk_vertices: (C, 2) int32, first vertex of a chunk and the one after its last.
    """

    vertices_m: NDArray[np.float32]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32]
    faces: NDArray[np.int32]
    face_is_flat: NDArray[np.bool_]
    first_vertex: NDArray[np.int32]
    first_face: NDArray[np.int32]
    centre_m: NDArray[np.float64]
    radius_m: NDArray[np.float64]
    texture: NDArray[np.int32]
    first_chunk: NDArray[np.int32]
    chunk_middle_m: NDArray[np.float64]
    chunk_half_m: NDArray[np.float64]
    chunk_vertices: NDArray[np.int32]


CHUNK = 24
"""Faces that are culled together."""


def pack_scene(world: World) -> tuple[SceneArrays, TexturePool]:
    """Return the present shapes and textures of all bodies of ``world``, without poses.

    Each is packed once, those of the bodies of its original for all copies.
    """
    with _packing:
        return _packed(world).scene(world)


def pack_shapes(world: World) -> SceneArrays:
    """Return the shapes of ``pack_scene`` alone; every texture index is 0."""
    with _packing:
        return _packed(world).shapes(world)


class _Packed:
    """What was packed of one world so far."""

    def __init__(self, original: World | None) -> None:
        self._count, self._shapes, self._store = 0, _NO_SHAPES, TextureStore()
        if original is not None:
            packed = _packed(original)
            self._count, self._shapes, self._store = len(original.bodies), packed.shapes(original), packed._store

    def shapes(self, world: World) -> SceneArrays:
        added = world.bodies[self._count :]
        if added:
            self._shapes = _appended(self._shapes, pack_geometry([body.mesh for body in added]))
            self._count = len(world.bodies)
        return self._shapes

    def scene(self, world: World) -> tuple[SceneArrays, TexturePool]:
        textures = list(dict.fromkeys(body.mesh.texture for body in world.bodies))
        index_of = {texture: index for index, texture in enumerate(textures)}
        texture = np.array([index_of[body.mesh.texture] for body in world.bodies], dtype=np.int32)
        return self.shapes(world)._replace(texture=texture), self._store.pool(textures)


_packed_worlds: WeakKeyDictionary[World, _Packed] = WeakKeyDictionary()
_packing = threading.Lock()
"""Copies of a world may be packed by several threads."""


def _packed(world: World) -> _Packed:
    if world not in _packed_worlds:
        _packed_worlds[world] = _Packed(world.original)
    return _packed_worlds[world]


def _appended(scene: SceneArrays, added: SceneArrays) -> SceneArrays:
    """Return the shapes of one scene's bodies and after them those of another."""
    vertices = scene.first_vertex[-1]
    pairs: Iterator[Any] = zip(scene, added, strict=True)
    joined = SceneArrays(*map(np.concatenate, pairs))
    return joined._replace(
        faces=np.concatenate([scene.faces, added.faces + vertices]),
        chunk_vertices=np.concatenate([scene.chunk_vertices, added.chunk_vertices + vertices]),
        **{
            name: np.concatenate([getattr(scene, name), getattr(added, name)[1:] + getattr(scene, name)[-1]])
            for name in ("first_vertex", "first_face", "first_chunk")
        },
    )


def pack_geometry(meshes: list[TexturedMesh]) -> SceneArrays:
    """Return the shapes of bodies with these meshes; every texture index is 0."""
    first_vertex = np.cumsum([0] + [len(mesh.vertices_m) for mesh in meshes]).astype(np.int32)
    first_face = np.cumsum([0] + [len(mesh.faces) for mesh in meshes]).astype(np.int32)
    normals = _joined([mesh.normals for mesh in meshes], 3, np.float32)
    faces = _joined([mesh.faces + start for mesh, start in zip(meshes, first_vertex, strict=False)], 3, np.int32)
    corners = normals[faces]
    centre_m = np.array([0.5 * (mesh.vertices_m.min(0) + mesh.vertices_m.max(0)) for mesh in meshes], dtype=float)
    radius_m = [
        np.linalg.norm(mesh.vertices_m - centre, axis=1).max() for mesh, centre in zip(meshes, centre_m, strict=True)
    ]
    vertices_m = _joined([mesh.vertices_m for mesh in meshes], 3, np.float32)
    first_chunk = np.cumsum([0] + [-(-len(mesh.faces) // CHUNK) for mesh in meshes]).astype(np.int32)
    chunk_middle_m, chunk_half_m, chunk_vertices = _chunks(vertices_m, faces, first_face, first_chunk)
    return SceneArrays(
        vertices_m,
        normals,
        _joined([mesh.uv for mesh in meshes], 2, np.float32),
        faces,
        np.abs(corners - corners[:, :1]).max(axis=(1, 2), initial=0.0) < 1e-4,
        first_vertex,
        first_face,
        centre_m.reshape(-1, 3),
        np.array(radius_m, dtype=float),
        np.zeros(len(meshes), dtype=np.int32),
        first_chunk,
        chunk_middle_m,
        chunk_half_m,
        chunk_vertices,
    )


def _chunks(
    vertices_m: NDArray[np.float32],
    faces: NDArray[np.int32],
    first_face: NDArray[np.int32],
    first_chunk: NDArray[np.int32],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32]]:
    """Return ``chunk_middle_m``, ``chunk_half_m`` and ``chunk_vertices``."""
    if not len(faces):
        return np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 2), np.int32)
    body = np.repeat(np.arange(len(first_chunk) - 1), np.diff(first_chunk))
    starts = first_face[body] + CHUNK * (np.arange(len(body)) - first_chunk[body])
    corners = vertices_m[faces]
    low = np.minimum.reduceat(corners.min(axis=1), starts).astype(float)
    high = np.maximum.reduceat(corners.max(axis=1), starts).astype(float)
    first = np.minimum.reduceat(faces.min(axis=1), starts)
    last = np.maximum.reduceat(faces.max(axis=1), starts)
    return 0.5 * (low + high), 0.5 * (high - low), np.column_stack([first, last + 1]).astype(np.int32)


def _joined(parts: list[NDArray], columns: int, kind: type) -> NDArray:
    return np.concatenate([np.empty((0, columns), kind), *parts]).astype(kind)


_NO_SHAPES = pack_geometry([])
