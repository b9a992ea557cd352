"""Meshes of people: rigid, clothed parts for the poses of ``sim.motion.gait``, with their textures."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from sim.mesh import Texture, TexturedMesh
from sim.meshes import person_parts as shapes
from sim.meshes.person_head import BARE_CROWN_Z, HEAD_STATIONS, edge_z, head
from sim.meshes.person_parts import RGB, Body, HairStyle, Headwear, Patch, PersonLook, SmoothShape, TopLength
from sim.motion.gait import part_poses
from sim.motion.skeleton import PART_NAMES, Figure, skeleton

Picture = NDArray[np.float64]

SIZE_TEXELS = (448, 512)
"""Height and width of a person's texture: a texel is 3 to 4 mm."""
_MARGIN_TEXELS = 3
"""Painted around every patch, so that coarse mip levels do not mix it with its neighbours."""
_RECTANGLES = {
    # left, top, width, height
    "torso": (0, 0, 256, 176),
    "head": (256, 0, 176, 128),
    "neck": (432, 0, 80, 48),
    "ear": (432, 48, 40, 40),
    "hand": (432, 88, 80, 64),
    "pelvis": (256, 128, 176, 80),
    "thigh": (0, 176, 144, 128),
    "shin": (144, 176, 112, 128),
    "upper_arm": (256, 208, 104, 104),
    "forearm": (360, 208, 88, 88),
    "foot": (0, 304, 128, 80),
    "backpack": (128, 304, 160, 128),
    "hair": (288, 312, 128, 96),
    "cap": (416, 312, 96, 64),
    "skirt": (0, 384, 128, 64),
    "bag": (416, 376, 96, 72),
}
PATCHES = {
    name: Patch(
        (left + _MARGIN_TEXELS) / SIZE_TEXELS[1],
        (top + _MARGIN_TEXELS) / SIZE_TEXELS[0],
        (left + width - _MARGIN_TEXELS) / SIZE_TEXELS[1],
        (top + height - _MARGIN_TEXELS) / SIZE_TEXELS[0],
    )
    for name, (left, top, width, height) in _RECTANGLES.items()
}
"""Where each kind of part has its place in the texture."""

_TOP_TEXELS_PER_STRIPE = 9


def paint(look: PersonLook, rng: np.random.Generator) -> Texture:
    """Return a person's texture: cloth with grain, folds, seams and edges; a face; hair in strands."""
    painters = {
        "torso": _torso,
        "head": _head,
        "neck": lambda look, shape, rng: _skin(look.skin_rgb, shape, rng) * 0.93,
        "ear": lambda look, shape, rng: _skin(look.skin_rgb, shape, rng) * 0.96,
        "hand": _hand,
        "pelvis": _seat,
        "thigh": _thigh,
        "shin": _shin,
        "upper_arm": _upper_arm,
        "forearm": _forearm,
        "foot": _shoe,
        "backpack": _backpack,
        "hair": lambda look, shape, rng: _strands(look.hair_rgb, shape, rng),
        "cap": lambda look, shape, rng: _cloth(look.cap_rgb or look.top_rgb, shape, rng),
    }
    if look.legwear == "skirt":
        painters["skirt"] = _skirt
    if look.bag_rgb is not None:
        painters["bag"] = _bag
    picture = np.empty((*SIZE_TEXELS, 3))
    picture[:] = look.top_rgb
    for name in painters:
        left, top, width, height = _RECTANGLES[name]
        picture[top : top + height, left : left + width] = painters[name](look, (height, width), rng)
    return Texture(np.clip(picture + 0.5, 0, 255).astype(np.uint8), smooth=True)


def _around(width: int) -> NDArray[np.float64]:
    """Return the azimuth of every column, from straight ahead in (-pi, pi], positive to the left of the body."""
    share = (np.arange(width) + 0.5 - _MARGIN_TEXELS) / (width - 2 * _MARGIN_TEXELS)
    return 2.0 * np.pi * (share - 0.5)


def _down(height: int) -> NDArray[np.float64]:
    """Return the share of the way from top to bottom of every row (h, 1)."""
    return ((np.arange(height) + 0.5 - _MARGIN_TEXELS) / (height - 2 * _MARGIN_TEXELS))[:, None]


def _noise(
    shape: tuple[int, int], down_texels: float, across_texels: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return smooth noise of unit spread, without a seam around the limb."""
    field: NDArray[np.float64] = gaussian_filter(rng.normal(size=shape), (down_texels, across_texels), mode="wrap")
    return field / field.std()


def _line(offset: NDArray[np.float64], half_width: float) -> NDArray[np.float64]:
    """Return 1 on a line and 0 a ``half_width`` and more away from it."""
    return np.clip(1.5 - np.abs(offset) / half_width * 1.5, 0.0, 1.0)


def _cloth(
    rgb: RGB, shape: tuple[int, int], rng: np.random.Generator, *, folds: tuple[float, float] = (4.0, 8.0)
) -> Picture:
    """Return cloth with grain and folds of a size (down, across) in texels."""
    light = (
        1.0
        + 0.035 * _noise(shape, 0.5, 0.5, rng)
        + 0.045 * _noise(shape, *folds, rng)
        + 0.03 * _noise(shape, 2.5 * folds[0], 2.5 * folds[1], rng)
    )
    # Black cloth still reflects light, with the same relative variation.
    return np.maximum(np.array(rgb, dtype=float), 14.0) * light[..., None]


def _skin(rgb: RGB, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    light = 1.0 + 0.015 * _noise(shape, 0.7, 0.7, rng) + 0.02 * _noise(shape, 8.0, 8.0, rng)
    return np.array(rgb, dtype=float) * light[..., None]


def _strands(rgb: RGB, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    light = 1.0 + 0.12 * _noise(shape, 9.0, 0.8, rng) + 0.08 * _noise(shape, 12.0, 5.0, rng)
    return (np.array(rgb, dtype=float) + 6.0) * np.maximum(light, 0.5)[..., None]


def _pattern(picture: Picture, look: PersonLook) -> Picture:
    """Return a top's cloth with its stripes or check; stripes are 3 to 4 cm wide on trunk and sleeves."""
    rows, columns = (np.arange(n) // _TOP_TEXELS_PER_STRIPE % 2 for n in picture.shape[:2])
    if look.top_pattern not in ("stripes", "check"):
        return picture
    down, across = rows[:, None].astype(float), columns[None].astype(float)
    share = np.broadcast_to(down, picture.shape[:2]) if look.top_pattern == "stripes" else 0.5 * (down + across)
    return picture * (1.0 - 0.45 * share[..., None])


_COAT_LENGTH = 1.45
"""Length of a coat, from collar to hem, over that of a top."""


def _torso(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    picture = _pattern(_cloth(look.top_rgb, shape, rng, folds=(5.0, 10.0)), look)
    along, around = _down(shape[0]), _around(shape[1])[None]
    down = along if look.top_length == "hip" else along * _COAT_LENGTH
    picture = _front(picture, look, down, around)
    seams = _line(np.abs(around) - 0.5 * np.pi, 0.03) * (down > 0.35)
    hem = np.maximum(_line(along - 0.955, 0.008), _line(along - 0.975, 0.008))
    armpits = np.exp(-(((np.abs(around) - 0.5 * np.pi) / 0.35) ** 2) - ((down - 0.42) / 0.12) ** 2)
    spine = np.exp(-(((np.abs(around) - np.pi) / 0.18) ** 2)) * (down > 0.2)
    shade = 1.0 - 0.25 * np.maximum(seams, hem) - 0.22 * armpits - 0.06 * spine - 0.1 * (down < 0.09)
    picture = picture * shade[..., None]
    if look.backpack_rgb is not None:
        straps = _line(np.abs(around) - 0.52, 0.13) * (down > 0.1) * (down < 0.62)
        picture = picture + np.minimum(2.0 * straps, 1.0)[..., None] * (0.8 * np.array(look.backpack_rgb) - picture)
    if look.bag_rgb is not None:
        # From the right shoulder to the left hip, in front and behind.
        strap = np.minimum(2.0 * _line(np.cos(around - 1.9) * 0.42 + 0.5 - down, 0.035), 1.0) * (down > 0.06)
        picture = picture + strap[..., None] * (0.7 * np.array(look.bag_rgb) - picture)
    return picture


def _front(picture: Picture, look: PersonLook, down: NDArray[np.float64], around: NDArray[np.float64]) -> Picture:
    """Return a top with what is on or under its front: a pale band, a print, the shirt in an open jacket, buttons."""
    if look.top_pattern == "band":
        picture = picture + 0.7 * ((down > 0.36) & (down < 0.56))[..., None] * (225.0 - picture)
    elif look.top_pattern == "print":
        blocks = (np.abs(around) < 0.42) & (down > 0.3) & (down < 0.55) & (np.sin(21.0 * down + 3.0 * around) > -0.5)
        bright = 30.0 if sum(look.top_rgb) > 330 else 215.0
        picture = picture + 0.75 * blocks[..., None] * (bright - picture)
    if look.inner_rgb is not None:
        inner = np.clip((0.14 + 0.28 * np.minimum(down, 0.9) - np.abs(around)) / 0.03 + 0.5, 0.0, 1.0) * (down < 0.93)
        edges = _line(0.14 + 0.28 * np.minimum(down, 0.9) - np.abs(around), 0.06)
        picture = picture + inner[..., None] * (np.array(look.inner_rgb, dtype=float) - picture)
        return picture * (1.0 - 0.35 * edges)[..., None]
    if look.top_length == "thigh":
        buttons = _line(around - 0.16, 0.035) * (np.sin(34.0 * down) > 0.8) * (down > 0.15)
        return picture * (1.0 - 0.3 * _line(around - 0.1, 0.02) - 0.4 * buttons)[..., None]
    return picture


def _upper_arm(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    sleeve = _pattern(_cloth(look.top_rgb, shape, rng, folds=(4.0, 7.0)), look)
    if look.sleeves == "long":
        return sleeve
    down = _down(shape[0])
    cuff = 1.0 - 0.25 * _line(down - 0.59, 0.02)
    return np.where((down < 0.62)[..., None], sleeve * cuff[..., None], _skin(look.skin_rgb, shape, rng))


def _forearm(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    if look.sleeves == "short":
        return _skin(look.skin_rgb, shape, rng)
    sleeve = _pattern(_cloth(look.top_rgb, shape, rng, folds=(3.0, 7.0)), look)
    return sleeve * (1.0 - 0.28 * (_down(shape[0]) > 0.86))[..., None]


def _hand(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    fingers = (np.sin(7.0 * around) > 0.75) * (down > 0.55)
    return _skin(look.skin_rgb, shape, rng) * (1.0 - 0.22 * fingers - 0.08 * (down > 0.5))[..., None]


def _seat(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    behind = np.pi - np.abs(around)
    belt = (down > 0.1) * (down < 0.22)
    middle = _line(behind, 0.03) + _line(around, 0.03) * (down > 0.2)
    pocket = np.maximum(np.abs(behind - 0.65) / 0.35, np.abs(down - 0.55) / 0.2)
    shade = 1.0 - 0.5 * belt - 0.2 * np.minimum(middle, 1.0) - 0.22 * _line(pocket - 1.0, 0.08)
    return _cloth(look.legwear_rgb, shape, rng) * shade[..., None]


def _thigh(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    cloth = _cloth(look.legwear_rgb, shape, rng, folds=(9.0, 5.0))
    shade = 1.0 - 0.2 * _line(np.abs(around) - 0.5 * np.pi, 0.06) + 0.07 * np.exp(-((around / 0.7) ** 2))
    if look.legwear == "trousers":
        return cloth * shade[..., None]
    hem = 1.0 - 0.25 * _line(down - 0.84, 0.02)
    return np.where((down < 0.87)[..., None], cloth * (shade * hem)[..., None], _leg(look, shape, rng))


def _leg(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    """Return bare skin, or a stocking."""
    return _skin(look.stockings_rgb or look.skin_rgb, shape, rng)


def _shin(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    if look.legwear != "trousers":
        return _leg(look, shape, rng)
    cloth = _cloth(look.legwear_rgb, shape, rng, folds=(7.0, 6.0))
    # Folds behind the knee and above the shoe.
    creases = np.sin(2.0 * np.pi * 14.0 * down + 1.5 * np.cos(around)) * ((down < 0.18) + (down > 0.78))
    seam = _line(np.abs(around) - 0.5 * np.pi, 0.07)
    hem = _line(down - 0.93, 0.012)
    return cloth * (1.0 + 0.06 * creases - 0.2 * np.maximum(seam, hem))[..., None]


def _skirt(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    pleats = np.sin(11.0 * around + 0.6 * np.sin(3.0 * around)) * np.clip(down / 0.5, 0.0, 1.0)
    shade = 1.0 + 0.09 * pleats - 0.25 * _line(down - 0.95, 0.02) - 0.3 * (down < 0.08)
    return _cloth(look.legwear_rgb, shape, rng, folds=(9.0, 4.0)) * shade[..., None]


def _bag(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    flap = _line(down - 0.45 - 0.04 * np.cos(around), 0.02)
    return _cloth(look.bag_rgb or look.top_rgb, shape, rng) * (1.0 - 0.45 * flap)[..., None]


def _shoe(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    upper = _cloth(look.shoes_rgb, shape, rng, folds=(3.0, 3.0))
    laces = (np.abs(around) < 0.5) * (down > 0.12) * (down < 0.42) * (np.sin(down * 95.0) > 0.2)
    upper = upper + (0.55 * laces)[..., None] * (np.array([205.0, 203.0, 198.0]) - upper)
    rubber = _cloth((176, 172, 164), shape, rng, folds=(3.0, 3.0))
    return np.where(np.broadcast_to((down > 0.62) & (down < 0.72), shape)[..., None], rubber, upper)


def _backpack(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    down, around = _down(shape[0]), _around(shape[1])[None]
    behind = np.pi - np.abs(around)
    cloth = _cloth(look.backpack_rgb or look.top_rgb, shape, rng, folds=(5.0, 8.0))
    zips = np.maximum(_line(down - 0.3, 0.014), _line(behind - 1.5, 0.04))
    pocket = _line(np.maximum(behind / 0.9, np.abs(down - 0.66) / 0.2) - 1.0, 0.05)
    return cloth * (1.0 - 0.4 * np.maximum(zips, pocket))[..., None]


def _head(look: PersonLook, shape: tuple[int, int], rng: np.random.Generator) -> Picture:
    """Return a face under hair; heights are those of ``HEAD_STATIONS``."""
    around = _around(shape[1])[None]
    top, bottom = HEAD_STATIONS[0][0] + 0.006, HEAD_STATIONS[-1][0] - 0.002
    z = top + _down(shape[0]) * (bottom - top)
    face = _skin(look.skin_rgb, shape, rng) * _features(around, z)[..., None]
    lips = np.exp(-((around / 0.30) ** 4) - ((z - 0.0455) / 0.0035) ** 2)
    face = face * (1.0 - lips[..., None] * np.array([0.12, 0.36, 0.32]))
    eyes = np.exp(-(((np.abs(around) - 0.36) / 0.13) ** 4) - ((z - 0.0835) / 0.0042) ** 4)
    face = face + eyes[..., None] * (np.array([58.0, 46.0, 42.0]) - face)
    brows = np.exp(-(((np.abs(around) - 0.38) / 0.21) ** 4) - ((z - 0.0925) / 0.0026) ** 2)
    hair = _strands(look.hair_rgb, shape, rng)
    brown = np.minimum(0.8 * np.array(look.hair_rgb, dtype=float), 110.0)
    face = face + (0.75 * brows)[..., None] * (brown - face)
    edge = edge_z(around, look.hair_style) + 0.0015 * _noise(shape, 2.0, 2.0, rng)
    share = np.clip((z - edge) / 0.004 + 0.5, 0.0, 1.0)[..., None]
    if look.hair_style == "cropped":
        share = 0.75 * share
    elif look.hair_style == "receding":
        share = share * np.clip((BARE_CROWN_Z - z) / 0.008 + 0.5, 0.0, 1.0)[..., None]
    face = face + share * (hair - face)
    if look.beard:
        chin = 0.062 + 0.012 * np.clip(np.abs(around) - 0.4, 0.0, 1.0)
        grown = np.clip((chin - z) / 0.004 + 0.5, 0.0, 1.0) * (np.abs(around) < 1.45) * (1.0 - 0.8 * lips)
        face = face + (0.8 * grown)[..., None] * (0.9 * hair - face)
    if look.cap_rgb is None:
        return face
    seams = _line(np.sin(3.0 * around), 0.12) if look.headwear == "cap" else 0.0 * around
    cap = _cloth(look.cap_rgb, shape, rng) * (1.0 - 0.2 * seams)[..., None]
    return np.where((z > edge_z(around, look.headwear))[..., None], cap, face)


def _features(around: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the shading of a face: eye sockets, the sides of the nose, below nose and lip."""
    sockets = np.exp(-(((np.abs(around) - 0.36) / 0.24) ** 2) - ((z - 0.084) / 0.008) ** 2)
    nostrils = np.exp(-((around / 0.17) ** 4) - ((z - 0.0565) / 0.0026) ** 2)
    chin = np.exp(-((around / 0.3) ** 2) - ((z - 0.0395) / 0.0025) ** 2)
    cheeks = np.exp(-(((np.abs(around) - 0.6) / 0.3) ** 2) - ((z - 0.066) / 0.012) ** 2)
    return 1.0 - 0.24 * sockets - 0.32 * nostrils - 0.14 * chin + 0.05 * cheeks


def person_parts(look: PersonLook, rng: np.random.Generator) -> dict[str, TexturedMesh]:
    """Return a person's parts by name, in the order of ``PART_NAMES``, each in its own frame.

    Smooth-shaded, closed, 1,450 to 1,650 triangles in all, with one texture for all of them. Parts reach into their
    neighbours, so that nothing gapes where they bend. People of one size and cut share their shapes.

    Args:
        rng: of grain and folds of the clothes.
    """
    return covered(look, paint(look, rng))


def covered(look: PersonLook, texture: Texture) -> dict[str, TexturedMesh]:
    """Return a person's parts by name under another texture, whose patches lie as in ``PATCHES``."""
    return {
        name: TexturedMesh(shape.vertices_m, shape.normals, shape.uv, shape.faces, texture)
        for name, shape in _shapes_of(look).items()
    }


def standing_m(look: PersonLook) -> dict[str, NDArray[np.float64]]:
    """Return the vertices (V, 3) of each part of a person who stands, in the order of ``PART_NAMES``."""
    poses = part_poses(skeleton(look.stature_m, look.build, look.figure), np.eye(4), 0.0, 0.0)
    return {
        name: shape.vertices_m @ T[:3, :3].T + T[:3, 3]
        for (name, shape), T in zip(_shapes_of(look).items(), poses, strict=True)
    }


def person_size_m(look: PersonLook) -> NDArray[np.float64]:
    """Return length, width and height (3,) of a person who stands: the bounds of all parts, backpack included."""
    return np.ptp(np.concatenate([*standing_m(look).values()]), axis=0)


class _Cut(NamedTuple):
    """What the shapes of a person depend on, see ``PersonLook``; ``worn``: headwear or none."""

    stature_m: float
    build: float
    figure: Figure
    hair: HairStyle
    worn: Headwear | None
    length: TopLength
    has_skirt: bool
    bare_shins: bool
    backpack: bool
    bag: bool


def _shapes_of(look: PersonLook) -> dict[str, SmoothShape]:
    """Return the shapes by name, in the order of ``PART_NAMES``."""
    one_side = _shapes(
        _Cut(
            look.stature_m,
            look.build,
            look.figure,
            look.hair_style,
            None if look.cap_rgb is None else look.headwear,
            look.top_length,
            # A skirt would pierce a coat, under which it is drawn as shorts.
            look.legwear == "skirt" and look.top_length == "hip",
            look.legwear != "trousers",
            look.backpack_rgb is not None,
            look.bag_rgb is not None,
        )
    )
    return {name: one_side[name.removeprefix("left_").removeprefix("right_")] for name in PART_NAMES}


@lru_cache(maxsize=64)
def _shapes(cut: _Cut) -> dict[str, SmoothShape]:
    """Return the shapes of one side of a person: the two sides are alike."""
    body = Body(skeleton(cut.stature_m, cut.build, cut.figure), cut.build, cut.figure)
    made = {
        "pelvis": shapes.pelvis(body, PATCHES, cut.has_skirt),
        "torso": shapes.torso(body, PATCHES, cut.length, cut.backpack, cut.bag),
        "head": head(body, PATCHES, cut.hair, cut.worn),
        "upper_arm": shapes.upper_arm(body, PATCHES),
        "forearm": shapes.forearm(body, PATCHES),
        "thigh": shapes.thigh(body, PATCHES),
        "shin": shapes.shin(body, PATCHES, cut.bare_shins),
        "foot": shapes.foot(body.bones, PATCHES),
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
