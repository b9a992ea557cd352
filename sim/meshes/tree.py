"""Broad-leaved trees: a trunk and a crown of a few lumps."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets

Rgb = tuple[int, int, int]
FOLIAGE_RGB: tuple[Rgb, ...] = ((66, 92, 44), (82, 104, 52), (58, 82, 46), (96, 112, 58), (74, 96, 62), (88, 98, 46))
"""Mean colours of the kinds of foliage."""

BARK_RGB = (92, 76, 60)
TEXELS = 64
BARK_TEXELS = 8
"""The bottom rows of a tree's texture are bark."""


def tree(
    radius_m: float, height_m: float, rng: np.random.Generator, foliage: tuple[Rgb, ...] = FOLIAGE_RGB
) -> TexturedMesh:
    """Return a tree on the origin, of 4 or 5 lumps and at most 180 triangles.

    Args:
        radius_m: of the crown, > 0; no leaf is farther from the axis.
        height_m: of its top above the ground, > radius_m.
        foliage: colours of its leaves, of which one is drawn; of other seasons in the order of these.

    Raises:
        ValueError: if a size is impossible.
    """
    if not radius_m > 0:
        raise ValueError(f"radius_m: expected a length > 0 m, got {radius_m}")
    if not height_m > radius_m:
        raise ValueError(f"height_m: expected more than radius_m = {radius_m}, got {height_m}")
    facets = Facets()
    crown_low_m = max(0.25 * height_m, height_m - 2.2 * radius_m)
    _add_trunk(facets, 0.09 * radius_m + 0.06, crown_low_m + 0.3 * (height_m - crown_low_m))
    for lump_m, faces in _crown(radius_m, crown_low_m, height_m, rng):
        for triangle in lump_m[faces]:
            facets.polygon(triangle, _leaf_uv(triangle, radius_m, rng))
    kind = int(rng.integers(len(foliage)))
    return facets.mesh(_bark_and_leaves(kind, foliage[kind]))


def bare_tree(leafy: TexturedMesh, rng: np.random.Generator) -> TexturedMesh:
    """Return a tree without leaves in the place of one that has them: a trunk, limbs, and twigs on these.

    Twigs are far thinner than a pixel of a picture from the air; those drawn stand for several each.
    """
    bark = (0.5, 1.0 - 0.5 * BARK_TEXELS / TEXELS)
    (x0, y0, _), (x1, y1, height_m) = leafy.bounds_m
    radius_m = 0.25 * (x1 - x0 + y1 - y0)
    facets = Facets()
    fork_m = 0.3 * height_m
    _add_trunk(facets, 0.07 * radius_m + 0.06, fork_m)
    turn = rng.uniform(0.0, 2.0 * np.pi)
    for limb in range(_LIMBS):
        angle = turn + limb * _GOLDEN_RAD
        reach_m = radius_m * rng.uniform(0.35, 0.8) * (1.0 if limb else 0.15)
        start = np.array([0.0, 0.0, fork_m * rng.uniform(0.75, 1.0)])
        end = np.array([reach_m * np.cos(angle), reach_m * np.sin(angle), height_m * rng.uniform(0.6, 0.9)])
        _add_branch(facets, start, end, 0.05 * radius_m, bark)
        for _ in range(_TWIGS):
            away = angle + rng.normal(0.0, 0.8)
            out_m = radius_m * rng.uniform(0.3, 0.55)
            base = start + rng.uniform(0.35, 1.0) * (end - start)
            tip = base + np.array([out_m * np.cos(away), out_m * np.sin(away), height_m * rng.uniform(0.02, 0.2)])
            tip[:2] *= min(1.0, radius_m / max(float(np.hypot(*tip[:2])), 1e-9))
            tip[2] = min(tip[2], height_m)
            _add_branch(facets, base, tip, 0.026 * radius_m, bark)
    return facets.mesh(leafy.texture)


_LIMBS, _TWIGS, _GOLDEN_RAD = 8, 7, 2.39996


def _add_branch(
    facets: Facets, start: NDArray[np.float64], end: NDArray[np.float64], radius_m: float, uv: tuple[float, float]
) -> None:
    """Add a three-sided spike."""
    along = (end - start) / np.linalg.norm(end - start)
    aside = np.cross(along, (0.0, 0.0, 1.0) if abs(along[2]) < 0.9 else (1.0, 0.0, 0.0))
    aside /= np.linalg.norm(aside)
    up = np.cross(aside, along)
    ring = [start + radius_m * (np.cos(a) * aside + np.sin(a) * up) for a in 2.0 * np.pi / 3.0 * np.arange(3)]
    for k in range(3):
        facets.polygon([ring[(k + 1) % 3], ring[k], end], uv)


def _crown(
    radius_m: float, low_m: float, high_m: float, rng: np.random.Generator
) -> list[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Return the lumps' vertices and faces: a large one in the middle and small ones around it.

    All are built in a crown of unit radius and height 1 first.
    """
    count = int(rng.integers(3, 5))
    turn = rng.uniform(0.0, 2.0 * np.pi)
    lumps = [_lump(1, (0.0, 0.0, 0.55), (0.8, 0.8, 0.45), rng)]
    for k in range(count):
        angle = turn + 2.0 * np.pi * (k + rng.uniform(-0.2, 0.2)) / count
        away, size = rng.uniform(0.42, 0.55), rng.uniform(0.4, 0.5)
        centre = (away * np.cos(angle), away * np.sin(angle), rng.uniform(0.3, 0.75))
        lumps.append(_lump(0, centre, (size, size, 0.6 * size), rng))
    everything = np.concatenate([vertices for vertices, _ in lumps])
    widest = np.linalg.norm(everything[:, :2], axis=1).max()
    bottom, top = everything[:, 2].min(), everything[:, 2].max()
    return [
        (
            np.column_stack(
                [
                    vertices[:, :2] * (radius_m / widest),
                    low_m + (vertices[:, 2] - bottom) * ((high_m - low_m) / (top - bottom)),
                ]
            ),
            faces,
        )
        for vertices, faces in lumps
    ]


def _lump(
    subdivisions: int, centre: tuple[float, float, float], radii: tuple[float, float, float], rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    spin = trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3]
    bumps = rng.uniform(0.8, 1.15, size=(len(ball.vertices), 1))
    return ball.vertices @ spin.T * bumps * radii + centre, np.asarray(ball.faces)


def _add_trunk(facets: Facets, radius_m: float, top_m: float) -> None:
    angles = np.arange(5) * (2.0 * np.pi / 5)
    outline = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [
        np.column_stack([outline * radius, np.full(5, height)])
        for radius, height in ((radius_m, 0.0), (0.6 * radius_m, top_m))
    ]
    bark = (0.5, 1.0 - 0.5 * BARK_TEXELS / TEXELS)
    facets.loft(rings, lambda segment, side: bark, bark, bark)


def _leaf_uv(triangle_m: NDArray[np.float64], radius_m: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return a piece of the foliage (3, 2) for a face, at a place and turn of its own.

    A crown's diameter is as wide as the texture.
    """
    edges = triangle_m[1:] - triangle_m[0]
    along = edges[0] / np.linalg.norm(edges[0])
    across = edges[1] - (edges[1] @ along) * along
    across /= np.linalg.norm(across)
    flat = np.array([[0.0, 0.0], [edges[0] @ along, 0.0], [edges[1] @ along, edges[1] @ across]])
    angle = rng.uniform(0.0, 2.0 * np.pi)
    turned = flat @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    turned /= 2.0 * radius_m
    # Above the bark, and a texel away from it.
    limits = np.array([1.0, 1.0 - (BARK_TEXELS + 1) / TEXELS])
    turned *= min(1.0, float((limits / np.ptp(turned, axis=0)).min()))
    room = np.maximum(limits - np.ptp(turned, axis=0), 0.0)
    return turned - turned.min(axis=0) + rng.random(2) * room


@cache
def _bark_and_leaves(kind: int, rgb: Rgb) -> Texture:
    """Return foliage of one kind and colour: clumps in light and shade, with single leaves; the same one every time."""
    rng = np.random.Generator(np.random.PCG64(kind))
    clumps = cv2.resize(rng.normal(size=(20, 20)), (TEXELS, TEXELS), interpolation=cv2.INTER_CUBIC)
    leaves = rng.normal(size=(TEXELS, TEXELS))
    light = 1.0 + 0.16 * clumps + 0.13 * leaves
    warm = 0.05 * cv2.resize(rng.normal(size=(10, 10)), (TEXELS, TEXELS), interpolation=cv2.INTER_CUBIC)
    tint = np.stack([1.0 + warm, np.ones_like(warm), 1.0 - warm], axis=-1)
    picture = np.array(rgb) * light[..., None] * tint
    picture[-BARK_TEXELS:] = np.array(BARK_RGB) * (1.0 + 0.08 * rng.normal(size=(BARK_TEXELS, TEXELS, 1)))
    return Texture(np.clip(picture, 0, 255).astype(np.uint8))
