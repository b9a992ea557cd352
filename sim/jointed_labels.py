"""Labels of bodies made of several rigid parts (people), as ``sim.labels`` for single bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.labels import body_view, cover
from sim.mesh import TexturedMesh
from sim.optics import Camera, invert_pose, principal_point


class JointedShape(NamedTuple):
    """The parts' shapes as one: V vertices, each in the frame of its part.

    Attributes:
        vertices_m: (V, 3) float32. part: (V,) int32. faces: (F, 3) int32.
    """

    vertices_m: NDArray[np.float32]
    part: NDArray[np.int32]
    faces: NDArray[np.int32]


class PartPoints(NamedTuple):
    """K points of a body of several parts.

    Attributes:
        part: (K,) index of the part that carries each. place_m: (K, 3) in that part's frame.
    """

    part: NDArray[np.int64]
    place_m: NDArray[np.float64]


_SEARCHED = 64
"""Pixels searched at once for parts of bodies."""
NEAREST_M = 0.15
"""Least depth before the camera: nearer vertices have no bounded projection."""


@dataclass(frozen=True, slots=True)
class SeenBody:
    """Visible part of one body.

    Attributes:
        box_xyxy: (4,) around all its vertices in the unbounded picture; NaN if one is nearer than ``NEAREST_M``.
        visible_fraction: share of its own pixels, drawn alone on an unbounded picture, that are seen; 0 where the box
            is NaN.
        hidden_by: id of the body that covers most of its pixels in the picture, -1 if none does.
        hidden_fraction: share of its own pixels that show one of the hiders in the picture.
    """

    box_xyxy: NDArray[np.float64]
    visible_fraction: float
    hidden_by: int
    hidden_fraction: float


def joined(meshes: Sequence[TexturedMesh]) -> JointedShape:
    """Return the parts' shapes as one."""
    first = np.cumsum([0] + [len(mesh.vertices_m) for mesh in meshes])
    return JointedShape(
        np.concatenate([mesh.vertices_m for mesh in meshes]),
        np.repeat(np.arange(len(meshes), dtype=np.int32), np.diff(first)),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, first, strict=False)]).astype(np.int32),
    )


def places_of(points: PartPoints, T_world_part: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the places (K, 3) of points in the world, with the poses (P, 4, 4) of the parts."""
    poses = T_world_part[points.part]
    placed: NDArray[np.float64] = np.einsum("kij,kj->ki", poses[:, :3, :3], points.place_m) + poses[:, :3, 3]
    return placed


def enclosing_bounds(
    shape: JointedShape, part_poses: NDArray[np.float64], T_world_body: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the bounds (2, 3) of a body as it is posed: least and greatest x, y, z of its vertices, in its own frame.

    Args:
        part_poses: (P, 4, 4), T_world_part. T_world_body: (4, 4).
    """
    return _bounds(shape, invert_pose(T_world_body) @ part_poses)


def seen_body(
    shape: JointedShape,
    part_poses: NDArray[np.float64],
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    instance_map: NDArray[np.int32],
    instance_id: int,
    *,
    hiders: NDArray[np.int64],
    pixel_offset: float = 0.5,
    shift_px: NDArray[np.float64] | None = None,
) -> SeenBody:
    """Return the visible part of a body in a picture.

    Args:
        part_poses: (P, 4, 4), T_world_part.
        instance_map: (H, W) with one id for all parts of a body.
        hiders: ids of the bodies that ``hidden_by`` may name.
        pixel_offset: where in a pixel the map was sampled.
        shift_px: (P, 2) by which each part is seen beside its place in a pinhole camera, through water; None = nowhere.
    """
    centre_x, centre_y = principal_point(camera)
    counts = np.zeros(len(hiders) + 2, np.int64)
    box = _count_pixels(
        shape,
        part_poses,
        camera.focal_px,
        centre_x,
        centre_y,
        T_world_camera,
        instance_map,
        instance_id,
        hiders,
        pixel_offset,
        np.zeros((len(part_poses), 2)) if shift_px is None else shift_px,
        counts,
    )
    most = int(np.argmax(counts[2:])) if len(hiders) else 0
    hidden_by = int(hiders[most]) if len(hiders) and counts[2 + most] > 0 else -1
    own, hidden = max(counts[0], 1), counts[2:].sum()
    return SeenBody(box, min(1.0, float(counts[1] / own)), hidden_by, float(hidden / own))


def seen_bodies(
    shapes: Sequence[JointedShape],
    part_poses: Sequence[NDArray[np.float64]],
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    instance_map: NDArray[np.int32],
    instance_id: NDArray[np.int64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return boxes (N, 4), visible fractions (N,) and bounds (N, 2, 3) of bodies, N >= 1, all at once.

    The same as ``seen_body`` with no hiders and ``enclosing_bounds``, the first part's frame being the body's.

    Args:
        part_poses: (P, 4, 4) of each. instance_id: (N,).
    """
    centre_x, centre_y = principal_point(camera)
    firsts = np.zeros((3, len(shapes) + 1), np.int64)
    firsts[0, 1:] = np.cumsum([len(shape.vertices_m) for shape in shapes])
    firsts[1, 1:] = np.cumsum([len(shape.faces) for shape in shapes])
    firsts[2, 1:] = np.cumsum([len(poses) for poses in part_poses])
    together = JointedShape(*(np.concatenate(each) for each in zip(*shapes, strict=True)))
    count = len(shapes)
    counts, boxes, bounds = np.zeros((count, 2), np.int64), np.empty((count, 4)), np.empty((count, 2, 3))
    _count_all(
        together,
        firsts,
        np.concatenate(part_poses),
        camera.focal_px,
        centre_x,
        centre_y,
        T_world_camera,
        instance_map,
        instance_id,
        boxes,
        bounds,
        counts,
    )
    return boxes, np.minimum(1.0, counts[:, 1] / np.maximum(counts[:, 0], 1)), bounds


@njit(cache=True)
def merge_parts(instance_map: NDArray[np.int32], whole: NDArray[np.int32], first_part: int) -> None:
    """Write the ids ``whole`` (B,) of the bodies that parts belong to over the parts' in a map (H, W), C-contiguous.

    Args:
        first_part: the least id of a part; those below stay what they are.
    """
    ids = instance_map.reshape(-1)
    for start in range(0, ids.shape[0], _SEARCHED):
        end = min(start + _SEARCHED, ids.shape[0])
        # Vector code, which passes over pixels without parts.
        greatest = np.int32(-1)
        for k in range(start, end):
            greatest = max(greatest, ids[k])
        if greatest >= first_part:
            for k in range(start, end):
                if ids[k] >= first_part:
                    ids[k] = whole[ids[k]]


@njit(cache=True)
def _bounds(shape: JointedShape, T_body_part: NDArray[np.float64]) -> NDArray[np.float64]:
    bounds = np.empty((2, 3))
    bounds[0], bounds[1] = np.inf, -np.inf
    for n in range(shape.vertices_m.shape[0]):
        T = T_body_part[shape.part[n]]
        x, y, z = shape.vertices_m[n]
        for axis in range(3):
            place = T[axis, 0] * x + T[axis, 1] * y + T[axis, 2] * z + T[axis, 3]
            bounds[0, axis] = min(bounds[0, axis], place)
            bounds[1, axis] = max(bounds[1, axis], place)
    return bounds


@njit(cache=True)
def _count_pixels(
    shape: JointedShape,
    part_poses: NDArray[np.float64],
    focal_px: float,
    centre_x: float,
    centre_y: float,
    T_world_camera: NDArray[np.float64],
    instance_map: NDArray[np.int32],
    instance_id: int,
    hiders: NDArray[np.int64],
    pixel_offset: float,
    shift_px: NDArray[np.float64],
    counts: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Return the body's box (4,); count its own pixels, drawn alone, and those of them that show it and each hider.

    Args:
        counts: (2 + hiders,) zeros; they stay so where the box is NaN or beyond the picture.
    """
    pixels = np.empty((shape.vertices_m.shape[0], 2))
    box = _project(shape, part_poses, focal_px, centre_x, centre_y, T_world_camera, shift_px, pixels)
    height, width = instance_map.shape
    # Comparisons with NaN are false.
    if not (box[2] > 0 and box[3] > 0 and box[0] < width and box[1] < height):
        return box
    x, y = int(np.floor(box[0])), int(np.floor(box[1]))
    for n in range(pixels.shape[0]):
        pixels[n, 0] -= x + pixel_offset
        pixels[n, 1] -= y + pixel_offset
    covered = np.zeros((int(np.ceil(box[3])) - y + 1, int(np.ceil(box[2])) - x + 1), dtype=np.bool_)
    cover(pixels, shape.faces, covered)
    wanted = np.empty(hiders.shape[0] + 1, np.int64)
    wanted[0], wanted[1:] = instance_id, hiders
    _count(covered, x, y, instance_map, wanted, counts)
    return box


@njit(cache=True)
def _count_all(
    shape: JointedShape,
    firsts: NDArray[np.int64],
    T_world_part: NDArray[np.float64],
    focal_px: float,
    centre_x: float,
    centre_y: float,
    T_world_camera: NDArray[np.float64],
    instance_map: NDArray[np.int32],
    instance_id: NDArray[np.int64],
    boxes: NDArray[np.float64],
    bounds: NDArray[np.float64],
    counts: NDArray[np.int64],
) -> None:
    """Write what ``_count_pixels`` and ``_bounds`` find of each of N bodies.

    Args:
        firsts: (3, N + 1) where the vertices, faces and parts of each begin.
    """
    no_hiders = np.empty(0, np.int64)
    for n in range(instance_id.shape[0]):
        vertices, parts = slice(firsts[0, n], firsts[0, n + 1]), slice(firsts[2, n], firsts[2, n + 1])
        faces = shape.faces[firsts[1, n] : firsts[1, n + 1]]
        one = JointedShape(shape.vertices_m[vertices], shape.part[vertices], faces)
        poses = T_world_part[parts]
        boxes[n] = _count_pixels(
            one,
            poses,
            focal_px,
            centre_x,
            centre_y,
            T_world_camera,
            instance_map,
            instance_id[n],
            no_hiders,
            0.5,
            np.zeros((poses.shape[0], 2)),
            counts[n],
        )
        bounds[n] = _bounds(one, _seen_from_first(poses))


@njit(cache=True)
def _seen_from_first(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return poses (P, 4, 4) in the frame of the first."""
    seen = np.zeros_like(poses)
    for part in range(poses.shape[0]):
        for i in range(3):
            for k in range(3):
                for j in range(3):
                    seen[part, i, j] += poses[0, k, i] * poses[part, k, j]
                seen[part, i, 3] += poses[0, k, i] * (poses[part, k, 3] - poses[0, k, 3])
        seen[part, 3, 3] = 1.0
    return seen


@njit(cache=True)
def _count(
    covered: NDArray[np.bool_],
    x: int,
    y: int,
    instance_map: NDArray[np.int32],
    wanted: NDArray[np.int64],
    counts: NDArray[np.int64],
) -> None:
    """Count the covered pixels (first of ``counts``), and those in the picture that show each of the ids ``wanted``
    (the others); ``covered`` begins at column x, row y of the map.
    """
    height, width = instance_map.shape
    left, right = max(x, 0), min(x + covered.shape[1], width)
    for i in range(covered.shape[0]):
        line, row = covered[i], y + i
        total = 0
        for j in range(line.shape[0]):
            total += line[j]
        counts[0] += total
        if row < 0 or row >= height:
            continue
        # Neighbours mostly show the same body: the wanted ids are searched once for all of them.
        column = left
        while column < right:
            seen, count = instance_map[row, column], 0
            while column < right and instance_map[row, column] == seen:
                count += line[column - x]
                column += 1
            for k in range(wanted.shape[0]):
                if seen == wanted[k]:
                    counts[1 + k] += count


@njit(cache=True)
def _project(
    shape: JointedShape,
    part_poses: NDArray[np.float64],
    focal_px: float,
    centre_x: float,
    centre_y: float,
    T_world_camera: NDArray[np.float64],
    shift_px: NDArray[np.float64],
    pixels: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Write where the vertices are seen (V, 2); return their bounds (4,), NaN if one is too near or unseen."""
    box = np.array([np.inf, np.inf, -np.inf, -np.inf])
    views = np.empty((part_poses.shape[0], 3, 4))
    for part in range(part_poses.shape[0]):
        views[part] = body_view(focal_px, centre_x, centre_y, T_world_camera, part_poses[part])
    for n in range(shape.vertices_m.shape[0]):
        view = views[shape.part[n]]
        x, y, z = shape.vertices_m[n]
        depth_m = view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3]
        if depth_m < NEAREST_M:
            return np.full(4, np.nan)
        for axis in range(2):
            pixel = (view[axis, 0] * x + view[axis, 1] * y + view[axis, 2] * z + view[axis, 3]) / depth_m
            pixel += shift_px[shape.part[n], axis]
            if not np.isfinite(pixel):
                return np.full(4, np.nan)
            pixels[n, axis] = pixel
            box[axis], box[axis + 2] = min(box[axis], pixel), max(box[axis + 2], pixel)
    return box
