"""Meshes of people: rigid, clothed parts for the poses of ``sim.motion.gait``."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sim.mesh import Texture, TexturedMesh
from sim.meshes import person_parts as shapes
from sim.meshes.person_clothes import PATCHES, paint
from sim.meshes.person_loft import SmoothShape
from sim.meshes.person_look import PersonLook
from sim.motion.gait import part_poses
from sim.motion.skeleton import PART_NAMES, skeleton


def person_parts(look: PersonLook, rng: np.random.Generator) -> dict[str, TexturedMesh]:
    """Return a person's parts by name, in the order of ``PART_NAMES``, each in its own frame.

    Smooth-shaded, closed, 1,450 to 1,650 triangles in all, with one texture for all of them. Parts reach into their
    neighbours, so that nothing gapes where they bend. People of one size and cut share their shapes.

    Args:
        rng: of grain and folds of the clothes.
    """
    return covered(look, paint(look, rng))


def covered(look: PersonLook, texture: Texture) -> dict[str, TexturedMesh]:
    """Return a person's parts by name under another texture, whose patches lie as in ``person_clothes.PATCHES``."""
    return {
        name: TexturedMesh(shape.vertices_m, shape.normals, shape.uv, shape.faces, texture)
        for name, shape in _shapes_of(look).items()
    }


def person_size_m(look: PersonLook) -> NDArray[np.float64]:
    """Return length, width and height (3,) of a person who stands: the bounds of all parts, backpack included."""
    poses = part_poses(skeleton(look.stature_m, look.build), np.eye(4), 0.0, 0.0)
    points_m = np.concatenate(
        [shape.vertices_m @ T[:3, :3].T + T[:3, 3] for shape, T in zip(_shapes_of(look).values(), poses, strict=True)]
    )
    return np.ptp(points_m, axis=0)


def _shapes_of(look: PersonLook) -> dict[str, SmoothShape]:
    """Return the shapes by name, in the order of ``PART_NAMES``."""
    one_side = _shapes(
        look.stature_m,
        look.build,
        look.hair_style,
        look.cap_rgb is not None,
        look.legwear == "shorts",
        look.backpack_rgb is not None,
    )
    return {name: one_side[name.removeprefix("left_").removeprefix("right_")] for name in PART_NAMES}


@lru_cache(maxsize=64)
def _shapes(
    stature_m: float, build: float, hair_style: str, cap: bool, bare_shins: bool, backpack: bool
) -> dict[str, SmoothShape]:
    """Return the shapes of one side of a person: the two sides are alike."""
    bones = skeleton(stature_m, build)
    made = {
        "pelvis": shapes.pelvis(bones, build, PATCHES),
        "torso": shapes.torso(bones, build, PATCHES, backpack),
        "head": shapes.head(bones, PATCHES, hair_style, cap),
        "upper_arm": shapes.upper_arm(bones, build, PATCHES),
        "forearm": shapes.forearm(bones, build, PATCHES),
        "thigh": shapes.thigh(bones, build, PATCHES),
        "shin": shapes.shin(bones, build, PATCHES, bare_shins),
        "foot": shapes.foot(bones, PATCHES),
    }
    return {
        name: SmoothShape(
            shape.vertices_m.astype(np.float32),
            shape.normals.astype(np.float32),
            shape.uv.astype(np.float32),
            shape.faces.astype(np.int32),
        )
        for name, shape in made.items()
    }
