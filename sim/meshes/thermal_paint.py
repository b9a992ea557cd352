"""Thermal looks of meshes: textures that say which part of its body a surface is, and how its temperature varies.

Red is the index of the part, green the variation of temperature within the part (``NO_VARIATION`` is none), blue is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.mesh import Texture, TexturedMesh
from sim.meshes.car_parts import Swatch
from sim.meshes.facets import palette, swatch_uv
from sim.meshes.person import PATCHES, covered
from sim.meshes.person_parts import PersonLook
from sim.meshes.vehicle import vehicle

NO_VARIATION = 128
KELVIN_PER_LEVEL = 4.0 / 127.0
"""Of green."""


class PersonPart(IntEnum):
    """Parts of a person."""

    SKIN = 0
    HAIR = 1
    TOP = 2
    LEGS = 3
    SHOES = 4
    BACKPACK = 5


class CarPart(IntEnum):
    """Parts of a car; the wheel is what is inside the tyre, next to the brake."""

    BODY = 0
    BONNET = 1
    ROOF = 2
    GLASS = 3
    TYRE = 4
    WHEEL = 5
    UNDERSIDE = 6
    TRIM = 7


def parts_palette(count: int) -> Texture:
    """Return a texture of ``count`` parts without variation; ``facets.swatch_uv`` says where they are."""
    return palette([(part, NO_VARIATION, 0) for part in range(count)])


def varied(part: int, variation_k: NDArray[np.float64]) -> Texture:
    """Return the texture of one part whose temperature varies by ``variation_k`` (h, w), within 4 K.

    Raises:
        ValueError: for a part outside 0 to 15.
    """
    check("part", 0 <= part <= 15, "0 to 15", part)
    picture = np.zeros((*variation_k.shape, 3), np.uint8)
    picture[..., 0] = part
    picture[..., 1] = np.clip(np.round(NO_VARIATION + variation_k / KELVIN_PER_LEVEL), 1, 255)
    return Texture(picture, smooth=True)


def blotches(
    shape: tuple[int, int], sizes_and_spreads: Sequence[tuple[float, float]], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return a sum of smooth noises (h, w), each of a size in texels and a standard deviation."""
    total = np.zeros(shape)
    for size, spread in sizes_and_spreads:
        rows, columns = (max(2, round(side / size)) for side in shape)
        noise = rng.standard_normal((rows, columns)).astype(np.float32)
        field = cv2.resize(noise, shape[::-1], interpolation=cv2.INTER_CUBIC).astype(float)
        total += spread * field / field.std()
    return total


def thermal_person(look: PersonLook, rng: np.random.Generator) -> dict[str, TexturedMesh]:
    """Return a person's parts by name, as ``person.person_parts``; clothes lie closer here, wider there."""
    return covered(look, _clothes(look, rng))


_PERSON_TEXELS = (112, 128)
_PART_OF_PATCH = {
    "torso": PersonPart.TOP,
    "head": PersonPart.SKIN,
    "neck": PersonPart.SKIN,
    "ear": PersonPart.SKIN,
    "hand": PersonPart.SKIN,
    "pelvis": PersonPart.LEGS,
    "thigh": PersonPart.LEGS,
    "shin": PersonPart.LEGS,
    "upper_arm": PersonPart.TOP,
    "forearm": PersonPart.TOP,
    "foot": PersonPart.SHOES,
    "backpack": PersonPart.BACKPACK,
    "hair": PersonPart.HAIR,
    "cap": PersonPart.HAIR,
    "skirt": PersonPart.LEGS,
    "bag": PersonPart.BACKPACK,
}
_HAIRLINE, _NAPE = 0.35, 0.75
"""Shares of the head's height, from its top, above which hair covers its front and its back."""


def _clothes(look: PersonLook, rng: np.random.Generator) -> Texture:
    height, width = _PERSON_TEXELS
    picture = np.zeros((height, width, 3), np.uint8)
    fit_k = blotches(_PERSON_TEXELS, ((12.0, 0.9), (5.0, 0.5)), rng)
    picture[..., 1] = np.clip(np.round(NO_VARIATION + fit_k / KELVIN_PER_LEVEL), 1, 255)
    for name, patch in PATCHES.items():
        # Whole texels around the patch: its margin is less than one of these.
        left, right = int(patch.left * width), int(np.ceil(patch.right * width))
        top, bottom = int(patch.top * height), int(np.ceil(patch.bottom * height))
        part = np.full((bottom - top, right - left), _PART_OF_PATCH[name], np.uint8)
        if name == "head":
            down = np.linspace(0.0, 1.0, len(part))[:, None]
            is_behind = np.abs(np.linspace(-1.0, 1.0, part.shape[1])) > 0.5
            part[down < np.where(is_behind, _NAPE, _HAIRLINE)] = PersonPart.HAIR
        bare = (name == "forearm" and look.sleeves == "short") or (name == "shin" and look.legwear != "trousers")
        picture[top:bottom, left:right, 0] = PersonPart.SKIN if bare else part
    return Texture(picture)


def thermal_car(model: str, factors: tuple[float, float, float]) -> TexturedMesh:
    """Return a car as ``vehicle.vehicle``, its length, width and height multiplied by ``factors``."""
    return scaled(_standard_car(model), factors)


def scaled(mesh: TexturedMesh, factors: tuple[float, float, float]) -> TexturedMesh:
    """Return a mesh whose coordinates x, y, z are multiplied by ``factors``, all > 0."""
    check("factors", min(factors) > 0, "three factors > 0", factors)
    by = np.array(factors, np.float32)
    normals = mesh.normals / by
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return TexturedMesh(mesh.vertices_m * by, normals, mesh.uv, mesh.faces, mesh.texture)


_PART_OF_SWATCH = {
    Swatch.PAINT: CarPart.BODY,
    Swatch.DARK_PAINT: CarPart.BODY,
    Swatch.LIGHT_PAINT: CarPart.ROOF,
    Swatch.GLASS: CarPart.GLASS,
    Swatch.BLACK: CarPart.UNDERSIDE,
    Swatch.LIGHT: CarPart.TRIM,
    Swatch.RED: CarPart.TRIM,
    Swatch.CHROME: CarPart.WHEEL,
}
_ENGINE_FROM, _WHEELS_BELOW = 0.22, 0.5
"""Share of the length ahead of the middle where the bonnet begins; share of the height below which wheels are."""
_BODY_FROM_M = 0.22
"""All bodies begin higher."""


@cache
def _standard_car(model: str) -> TexturedMesh:
    mesh = vehicle(model, (0, 0, 0))
    swatch = np.floor(mesh.uv[:, 0] * len(Swatch)).astype(int)
    part = np.array([_PART_OF_SWATCH.get(each, CarPart.BODY) for each in Swatch])[swatch]
    # Faces do not share vertices, so that each vertex belongs to one part.
    middle_m = np.zeros_like(mesh.vertices_m)
    middle_m[mesh.faces] = mesh.vertices_m[mesh.faces].mean(axis=1)[:, None]
    length_m, _, height_m = mesh.size_m
    part[(part == CarPart.BODY) & (middle_m[:, 0] > _ENGINE_FROM * length_m)] = CarPart.BONNET
    is_low = middle_m[:, 2] < _WHEELS_BELOW * height_m
    part[(part == CarPart.WHEEL) & ~is_low] = CarPart.TRIM
    # Wheels reach below the body's lower edge, and their sides are upright.
    is_below = np.zeros(len(part), np.bool_)
    is_below[mesh.faces] = (mesh.vertices_m[mesh.faces][..., 2].min(axis=1) < _BODY_FROM_M)[:, None]
    is_side = is_low & (np.abs(mesh.normals[:, 1]) > 0.99)
    part[(part == CarPart.UNDERSIDE) & (is_below | is_side)] = CarPart.TYRE
    count = len(CarPart)
    uv = np.array([swatch_uv(each, count) for each in range(count)], np.float32)[part]
    return TexturedMesh(mesh.vertices_m, mesh.normals, uv, mesh.faces, parts_palette(count))
