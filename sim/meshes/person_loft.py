"""Smooth closed shapes lofted over rounded cross sections, such as limbs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Station = tuple[float, float, float, float, float]
"""(z, x of the centre, reach ahead, reach behind, half width) of one cross section, all in the same unit."""


class SmoothShape(NamedTuple):
    """A part of a mesh, with normals of its own at every vertex.

    Attributes:
        vertices_m, normals: (V, 3).
        uv: (V, 2) in the texture.
        faces: (F, 3) indices of vertices, counter-clockwise seen from outside.
    """

    vertices_m: NDArray[Any]
    normals: NDArray[Any]
    uv: NDArray[Any]
    faces: NDArray[Any]


class Patch(NamedTuple):
    """A rectangle of a texture in shares of its sides: left, top, right and bottom edge."""

    left: float
    top: float
    right: float
    bottom: float


def rings(stations: Sequence[Station], sides: int, unit_m: float, squareness: float = 2.0) -> NDArray[np.float64]:
    """Return cross sections (S, N, 3): superellipses ``|x / a|^n + |y / b|^n = 1``, n = 2 for ellipses.

    Points go round counter-clockwise seen from above, from straight behind (where a seam shows least in front) on to
    the right-hand side and the front.
    """
    angle = np.pi + 2.0 * np.pi * np.arange(sides) / sides
    cosine, sine = np.cos(angle), np.sin(angle)
    along = np.sign(cosine) * np.abs(cosine) ** (2.0 / squareness)
    across = np.sign(sine) * np.abs(sine) ** (2.0 / squareness)
    z, centre, ahead, behind, half_width = (np.array(column)[:, None] for column in zip(*stations, strict=True))
    x = centre + np.where(along > 0, ahead, behind) * along
    return unit_m * np.stack([x, half_width * across, np.broadcast_to(z, x.shape)], axis=-1)


def loft(
    rings_m: NDArray[np.float64], top_m: float, bottom_m: float, patch: Patch, *, upright: bool = False
) -> SmoothShape:
    """Return a closed skin over rings (S, N, 3) from top to bottom, counter-clockwise seen from above.

    Args:
        top_m, bottom_m: how far the tips lie beyond the middle of the first and of the last ring; 0 closes it plane,
            less makes it hollow.
        patch: of the texture, wound once around: its left edge at point 0, its top at the top.
        upright: the texture's rows are evenly spaced in height, not along the skin.
    """
    count, sides = rings_m.shape[:2]
    tips = rings_m[[0, -1]].mean(axis=1)
    tips[:, 2] += (top_m, -bottom_m)
    skin = np.concatenate([np.tile(tips[:1], (1, sides, 1)), rings_m, np.tile(tips[1:], (1, sides, 1))])
    normals = _normals(skin)
    steps = np.diff(skin, axis=0)
    lengths = np.abs(steps[..., 2].mean(axis=1)) if upright else np.linalg.norm(steps, axis=2).mean(axis=1)
    u = np.tile(np.arange(sides + 1) / sides, (count + 2, 1))
    # Each triangle at a tip has a tip of its own, in its middle.
    u[[0, -1]] = np.minimum(u[[0, -1]] + 0.5 / sides, 1.0)
    v = np.repeat((np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum())[:, None], sides + 1, axis=1)
    size = np.array([patch.right - patch.left, patch.bottom - patch.top])
    uv = np.array([patch.left, patch.top]) + np.stack([u, v], axis=-1) * size
    # The first column comes again at the right edge of the texture.
    return SmoothShape(
        np.concatenate([skin, skin[:, :1]], axis=1).reshape(-1, 3),
        np.concatenate([normals, normals[:, :1]], axis=1).reshape(-1, 3),
        uv.reshape(-1, 2),
        _faces(count + 2, sides),
    )


def _faces(rows: int, sides: int) -> NDArray[np.int64]:
    """Return triangles over rows of ``sides + 1`` points of which the first and the last are tips."""
    row, side = np.meshgrid(np.arange(rows - 1), np.arange(sides), indexing="ij")
    upper = row * (sides + 1) + side
    lower = upper + sides + 1
    falling = np.stack([upper, lower, lower + 1], axis=-1)[:-1]
    rising = np.stack([upper, lower + 1, upper + 1], axis=-1)[1:]
    return np.concatenate([falling.reshape(-1, 3), rising.reshape(-1, 3)])


def _normals(skin_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit normals (S, N, 3): of every point the mean of those of the four faces around it, by area."""
    following = np.roll(skin_m, -1, axis=1)
    # Twice the area of the quadrilaterals between two rings and two columns, as vectors outwards.
    area = np.cross(skin_m[1:] - following[:-1], following[1:] - skin_m[:-1])
    around = area + np.roll(area, 1, axis=1)
    total = np.zeros_like(skin_m)
    total[:-1] += around
    total[1:] += around
    total[0], total[-1] = area[0].sum(axis=0), area[-1].sum(axis=0)
    return total / np.linalg.norm(total, axis=2, keepdims=True)


def joined(shapes: Sequence[SmoothShape]) -> SmoothShape:
    """Return several shapes as one."""
    starts = np.cumsum([0, *(len(shape.vertices_m) for shape in shapes[:-1])])
    return SmoothShape(
        np.concatenate([shape.vertices_m for shape in shapes]),
        np.concatenate([shape.normals for shape in shapes]),
        np.concatenate([shape.uv for shape in shapes]),
        np.concatenate([shape.faces + start for shape, start in zip(shapes, starts, strict=True)]),
    )
