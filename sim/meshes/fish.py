"""Meshes of fish: rigid segments for the poses of ``sim.motion.swim``, much like a zebrafish seen from above."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from sim.mesh import TexturedMesh
from sim.meshes.fish_look import FishLook
from sim.meshes.fish_skin import EYE_UV, FIN_UV, body_uv, paint
from sim.motion.swim import SEGMENT_COUNT, SEGMENT_ENDS

PROFILE = np.array(
    [
        # share behind the snout, half width, reach up, reach down; shares of length
        (0.000, 0.012, 0.010, 0.010),
        (0.020, 0.034, 0.024, 0.022),
        (0.060, 0.051, 0.046, 0.042),
        (0.120, 0.065, 0.068, 0.066),
        (0.200, 0.076, 0.086, 0.090),
        (0.300, 0.080, 0.094, 0.105),
        (0.400, 0.074, 0.092, 0.104),
        (0.500, 0.063, 0.082, 0.094),
        (0.600, 0.050, 0.069, 0.078),
        (0.700, 0.037, 0.055, 0.060),
        (0.830, 0.020, 0.040, 0.040),
    ]
)
"""The body without fins: blunt in front, widest behind the gills, with a thin stalk before the tail fin (our reading of
photographs of zebrafish from above and from the side)."""
TAIL_REACH = 0.105
"""Half the height of the tail fin's hind edge, share of length; no part of a fish reaches farther up or down."""

_SIDES = 8
_HEAD_RINGS = (0.0, 0.02, 0.06, 0.12)
_CAP_RAD = np.deg2rad(50.0)
_EYE = (0.075, 0.045, 0.014, 0.027)
"""Share behind the snout, distance from the middle plane, height and radius of the eyes, shares of length."""


class _Shape(NamedTuple):
    vertices: NDArray[np.float64]
    normals: NDArray[np.float64]
    uv: NDArray[np.float64]
    faces: NDArray[np.int64]


def fish_segments(look: FishLook, rng: np.random.Generator) -> tuple[TexturedMesh, ...]:
    """Return a fish's segments from head to tail fin, each in its own frame (see ``sim.motion.swim.SwimPose``).

    Smooth-shaded, of closed convex pieces, about 400 triangles in all, with one texture for all of them. A segment's
    hind end is rounded about its joint, so that nothing gapes where the body bends.

    Args:
        rng: of the mottling of the skin.
    """
    texture = paint(look, rng)
    return tuple(
        TexturedMesh(
            (shape.vertices * look.length_m * np.array([1.0, look.width, 1.0])).astype(np.float32),
            _unit(shape.normals / np.array([1.0, look.width, 1.0])).astype(np.float32),
            shape.uv.astype(np.float32),
            shape.faces.astype(np.int32),
            texture,
        )
        for shape in _shapes()
    )


def half_size(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return half width and greatest reach up or down (2, ...) of the body at shares of length behind the snout.

    The tail fin counts with the width of its root.
    """
    width, up, down = (np.interp(share, PROFILE[:, 0], column) for column in PROFILE.T[1:])
    fin = np.clip((np.asarray(share) - SEGMENT_ENDS[-2]) / (1.0 - SEGMENT_ENDS[-2]), 0.0, 1.0)
    return np.stack([width, np.maximum(np.maximum(up, down), fin * TAIL_REACH)])


@lru_cache(maxsize=1)
def _shapes() -> tuple[_Shape, ...]:
    """Return the segments of a fish of length 1."""
    shapes = [_body(k) for k in range(SEGMENT_COUNT - 1)]
    shapes[0] = _joined([shapes[0], _eye(1.0), _eye(-1.0)])
    shapes[1] = _joined([shapes[1], _pectoral(1.0), _pectoral(-1.0)])
    return (*shapes, _tail_fin())


def _body(segment: int) -> _Shape:
    """Return one segment of the trunk: the hull of elliptic rings and of a ball about the hind joint."""
    front, back = SEGMENT_ENDS[segment], SEGMENT_ENDS[segment + 1]
    stations = (*_HEAD_RINGS, back) if segment == 0 else (front, back)
    rings = [_ring(share) for share in stations]
    points = [ring for ring, _ in rings]
    normals = [normal for _, normal in rings]
    for angle in (_CAP_RAD, 0.5 * np.pi):
        ring, normal = _ring(back)
        width = ring[:, 1].max()
        ring = ring * [1.0, np.cos(angle), np.cos(angle)] - [width * np.sin(angle), 0.0, 0.0]
        turned = normal * [0.0, np.cos(angle), np.cos(angle)] - [np.sin(angle), 0.0, 0.0]
        # The ball closes in one point.
        points.append(ring if angle < 1.5 else ring[:1])
        normals.append(_unit(turned) if angle < 1.5 else turned[:1])
    vertices = np.concatenate(points)
    shape = _hull(vertices, _unit(np.concatenate(normals)), body_uv(-vertices[:, 0], vertices[:, 1], vertices[:, 2]))
    return shape._replace(vertices=shape.vertices + np.array([front, 0.0, 0.0]))


def _ring(share: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a cross section (_SIDES, 3), snout at x = 0, and its normals; it begins on the middle of the back."""
    width, up, down = (np.interp(share, PROFILE[:, 0], column) for column in PROFILE.T[1:])
    angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    height = np.where(np.cos(angle) > 0, up, down)
    ring = np.column_stack([np.full(_SIDES, -share), width * np.sin(angle), height * np.cos(angle)])
    ahead = (np.interp(share + 0.02, PROFILE[:, 0], PROFILE[:, 1]) - np.interp(share - 0.02, *PROFILE.T[:2])) / 0.04
    normal = _unit(np.column_stack([np.zeros(_SIDES), np.sin(angle) / width, np.cos(angle) / height]))
    return ring, _unit(normal + np.array([ahead, 0.0, 0.0]))


def _eye(side: float) -> _Shape:
    share, aside, height, radius = _EYE
    ball = trimesh.creation.icosphere(subdivisions=0)
    vertices = np.asarray(ball.vertices) * radius + [-share, side * aside, height]
    return _Shape(vertices, np.asarray(ball.vertices), np.tile(EYE_UV, (len(vertices), 1)), np.asarray(ball.faces))


def _pectoral(side: float) -> _Shape:
    """Return the plate of a pectoral fin, spread sideways and to the rear."""
    outline = np.array([(0.005, 0.045), (-0.040, 0.045), (-0.110, 0.125), (-0.070, 0.145)]) * [1.0, side]
    plate = np.concatenate([np.column_stack([outline, np.full(4, -0.035 + z)]) for z in (-0.004, 0.004)])
    return _plate(plate)


def _tail_fin() -> _Shape:
    """Return the upright plate of the tail fin."""
    stations = ((0.0, 0.020, 0.040), (-0.05, 0.014, 0.062), (SEGMENT_ENDS[-2] - 1.0, 0.006, TAIL_REACH))
    corners = [(x, y * width, z * height) for x, width, height in stations for y in (-1, 1) for z in (-1, 1)]
    return _plate(np.array(corners))


def _plate(corners: NDArray[np.float64]) -> _Shape:
    """Return the hull of a fin's corners, which shine as one round thing."""
    away = corners - corners.mean(axis=0)
    return _hull(
        corners, _unit(away / np.maximum(np.ptp(corners, axis=0), 0.02) ** 2), np.tile(FIN_UV, (len(corners), 1))
    )


def _hull(vertices: NDArray[np.float64], normals: NDArray[np.float64], uv: NDArray[np.float64]) -> _Shape:
    """Return the convex hull of points (V, 3), which keeps what belongs to those on it."""
    hull = trimesh.convex.convex_hull(vertices, repair=True)
    kept = np.array([np.argmin(np.linalg.norm(vertices - corner, axis=1)) for corner in np.asarray(hull.vertices)])
    return _Shape(vertices[kept], normals[kept], uv[kept], np.asarray(hull.faces))


def _joined(shapes: list[_Shape]) -> _Shape:
    starts = np.cumsum([0, *(len(shape.vertices) for shape in shapes[:-1])])
    vertices, normals, uv, _ = (np.concatenate(parts) for parts in zip(*shapes, strict=True))
    return _Shape(
        vertices, normals, uv, np.concatenate([s.faces + start for s, start in zip(shapes, starts, strict=True)])
    )


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
