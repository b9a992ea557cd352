"""Sizes, looks and shapes of a person's clothed parts: limbs, trunk, shoes, as shares of stature.

Every shape stands in the frame of its part (see ``sim.motion.skeleton``). Ends are rounded and reach beyond the joints,
so that nothing gapes where they bend. Lengths are those of the skeleton; breadths and depths are chosen by eye for
clothed adults within the breadths of Drillis and Contini (1966): shoulders 0.259, hips 0.191 of stature; a ``Figure``
changes them. The head is in ``person_head``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.motion.skeleton import AVERAGE, Figure, Skeleton, skeleton

RGB = tuple[int, int, int]
HairStyle = Literal["short", "long", "bald", "cropped", "receding", "bob", "bun", "ponytail", "curly"]
Headwear = Literal["cap", "beanie", "hat", "scarf"]
Pattern = Literal["plain", "stripes", "check", "band", "print"]
Legwear = Literal["trousers", "shorts", "skirt"]
TopLength = Literal["hip", "thigh"]


@dataclass(frozen=True, slots=True)
class PersonLook:
    """One person's size, colours (sRGB 0-255) and clothes.

    Attributes:
        stature_m: within ``STATURE_M`` of ``sim.motion.skeleton``.
        build: factor of girths within ``BUILD`` there.
        figure: proportions of the body.
        hair_style: long hair reaches the shoulders, a bob the chin; the receding one leaves the crown bare.
        beard: in the colour of the hair.
        cap_rgb: of a cap worn over it, None for no cap. headwear: what is worn in that colour; a scarf covers all hair.
        top_pattern: horizontal stripes or a check in a darker shade of the top, one pale band, or a print on the chest.
        top_length: a coat reaches down to half of the thighs, and over shorts in place of a skirt.
        inner_rgb: of the shirt in an open jacket, None for a closed top.
        sleeves: short ones end above the elbow.
        legwear: shorts and skirts end at the knee. stockings_rgb: of the legs below a skirt, None for bare ones.
        backpack_rgb: None for no backpack. bag_rgb: of a bag at the left hip on a strap, None for no bag.
    """

    stature_m: float = 1.74
    build: float = 1.0
    skin_rgb: RGB = (204, 158, 130)
    hair_rgb: RGB = (62, 46, 36)
    hair_style: HairStyle = "short"
    cap_rgb: RGB | None = None
    top_rgb: RGB = (70, 92, 128)
    top_pattern: Pattern = "plain"
    sleeves: Literal["long", "short"] = "long"
    legwear: Legwear = "trousers"
    legwear_rgb: RGB = (52, 56, 70)
    shoes_rgb: RGB = (44, 42, 44)
    backpack_rgb: RGB | None = None
    figure: Figure = AVERAGE
    beard: bool = False
    headwear: Headwear = "cap"
    top_length: TopLength = "hip"
    inner_rgb: RGB | None = None
    stockings_rgb: RGB | None = None
    bag_rgb: RGB | None = None

    def __post_init__(self) -> None:
        """Check sizes and words.

        Raises:
            ValueError: for an impossible size or an unknown word.
        """
        skeleton(self.stature_m, self.build, self.figure)
        for name in ("skin", "hair", "cap", "top", "inner", "legwear", "stockings", "shoes", "backpack", "bag"):
            rgb = getattr(self, f"{name}_rgb")
            good = rgb is None or (len(rgb) == 3 and all(0 <= c <= 255 for c in rgb))
            check(f"{name}_rgb", good, "three numbers from 0 to 255", rgb)
        check("sleeves", self.sleeves in ("long", "short"), "long or short", self.sleeves)
        for name, words in (
            ("hair_style", HairStyle),
            ("headwear", Headwear),
            ("top_pattern", Pattern),
            ("top_length", TopLength),
            ("legwear", Legwear),
        ):
            got = getattr(self, name)
            check(name, got in get_args(words), f"one of {get_args(words)}", got)


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


Patches = Mapping[str, Patch]


class Body(NamedTuple):
    """What the shapes of a person are made to: segments, factor of girths, proportions."""

    bones: Skeleton
    build: float
    figure: Figure


LIMB_SIDES = 8

Along = Sequence[tuple[float, float]]
"""Heights, rising, and a factor at each of them."""
_EVEN: Along = ((0.0, 1.0),)


def fitted(
    stations: list[Station],
    body: Body,
    *,
    tall: float = 1.0,
    wide: Along = _EVEN,
    deep: Along = _EVEN,
    bumps: Sequence[tuple[float, float, float]] = (),
) -> list[Station]:
    """Return stations of a body's girths.

    Args:
        tall: factor of heights. wide, deep: factors of breadth and depth at heights before that.
        bumps: (height, half height, share) by which the front reaches farther ahead.
    """
    made = []
    for z, centre, ahead, behind, width in stations:
        broad, thick = (
            float(np.interp(z, [at for at, _ in along], [factor for _, factor in along])) for along in (wide, deep)
        )
        front = 1.0 + sum(share * float(np.exp(-(((z - at) / reach) ** 2))) for at, reach, share in bumps)
        made.append(
            (
                z * tall,
                centre,
                ahead * body.build * thick * front,
                behind * body.build * thick,
                width * body.build * broad,
            )
        )
    return made


_HIPS_Z, _WAIST_Z = -0.03, 0.07
"""Heights of the broadest hips and of the waist above the joint of the torso, shares of stature."""


def pelvis(body: Body, patches: Patches, skirt: bool) -> SmoothShape:
    """Return the seat of the trousers, between the hips, and a skirt around the thighs or none."""
    stations = [
        (0.105, 0.000, 0.052, 0.050, 0.080),
        (0.060, 0.000, 0.056, 0.058, 0.087),
        (-0.012, 0.000, 0.053, 0.066, 0.093),
        (-0.038, 0.000, 0.044, 0.054, 0.074),
    ]
    bones, figure = body.bones, body.figure
    between = 0.5 * (figure.hips + figure.waist)
    across: Along = ((-0.012, figure.hips), (0.105, between))
    bumps = ((0.105, 0.06, figure.belly),)
    made = fitted(stations, body, tall=figure.trunk, wide=across, deep=across, bumps=bumps)
    ring = rings(made, 10, bones.stature, 2.3)
    seat = loft(ring, 0.006 * bones.stature, 0.016 * bones.stature, patches["pelvis"])
    return joined([seat, _skirt(body, patches)]) if skirt else seat


def _skirt(body: Body, patches: Patches) -> SmoothShape:
    """Return a skirt from the waist to above the knee, wide enough for most of a stride."""
    stations = [
        (0.095, 0.000, 0.055, 0.054, 0.084),
        (0.020, 0.000, 0.062, 0.068, 0.098),
        (-0.060, 0.002, 0.070, 0.075, 0.106),
        (-0.140, 0.004, 0.084, 0.083, 0.113),
        (-0.215, 0.006, 0.098, 0.094, 0.121),
    ]
    bones, figure = body.bones, body.figure
    ring = rings(
        fitted(stations, body, wide=((0.0, figure.hips), (0.095, 0.5 * (figure.hips + figure.waist)))),
        12,
        bones.stature,
        2.2,
    )
    ring[..., 2] *= np.where(ring[..., 2] < 0.0, figure.limbs, figure.trunk)
    return loft(ring, 0.002 * bones.stature, -0.03 * bones.stature, patches["skirt"])


def torso(body: Body, patches: Patches, length: TopLength, backpack: bool, bag: bool) -> SmoothShape:
    """Return the top from its collar to its hem, which hangs over the pelvis, with a backpack and a bag or none."""
    stations = [
        (0.2330, -0.002, 0.034, 0.036, 0.036),
        (0.2150, -0.006, 0.044, 0.050, 0.083),
        (0.2040, -0.006, 0.049, 0.055, 0.106),
        (0.1870, -0.004, 0.058, 0.060, 0.1180),
        (0.1200, 0.000, 0.067, 0.059, 0.0990),
        (0.0700, 0.001, 0.061, 0.053, 0.0905),
        (-0.0300, 0.000, 0.066, 0.068, 0.0970),
        (-0.0680, 0.000, 0.068, 0.076, 0.1020),
    ]
    if length == "thigh":
        stations[-1] = (-0.1000, 0.000, 0.072, 0.080, 0.1060)
        stations.append((-0.2150, 0.000, 0.088, 0.096, 0.1180))
    bones, figure = body.bones, body.figure
    shoulders = figure.shoulders * figure.elbow_room
    wide: Along = (
        (_HIPS_Z, figure.hips),
        (_WAIST_Z, figure.waist),
        (0.130, 0.5 * (figure.waist + shoulders)),
        (0.187, shoulders),
        (0.215, shoulders),
        (0.233, 1.0),
    )
    deep: Along = ((_HIPS_Z, figure.hips), (_WAIST_Z, figure.waist), (0.150, 0.5 + 0.5 * figure.waist), (0.2, 1.0))
    bumps = ((0.015, 0.075, figure.belly), (0.130, 0.035, figure.bust))
    ring = rings(fitted(stations, body, tall=figure.trunk, wide=wide, deep=deep, bumps=bumps), 12, bones.stature, 2.3)
    parts = [loft(ring, 0.004 * bones.stature, -0.02 * bones.stature, patches["torso"])]
    if backpack:
        parts.append(_backpack(body, patches))
    if bag:
        parts.append(_shoulder_bag(body, patches))
    return joined(parts) if len(parts) > 1 else parts[0]


def _backpack(body: Body, patches: Patches) -> SmoothShape:
    """Return a rounded bag that leans on the shoulder blades."""
    stations = [
        (0.205, -0.082, 0.030, 0.016, 0.050),
        (0.195, -0.086, 0.034, 0.032, 0.072),
        (0.160, -0.090, 0.036, 0.042, 0.084),
        (0.035, -0.088, 0.042, 0.056, 0.086),
        (0.015, -0.086, 0.036, 0.044, 0.078),
    ]
    bones, figure = body.bones, body.figure
    ring = rings(stations, 8, bones.stature, 3.2)
    ring[..., 0] -= 0.058 * (body.build * (0.5 + 0.5 * figure.waist) - 1.0) * bones.stature
    ring[..., 2] *= figure.trunk
    return loft(ring, 0.004 * bones.stature, 0.003 * bones.stature, patches["backpack"])


def _shoulder_bag(body: Body, patches: Patches) -> SmoothShape:
    """Return a flat bag at the left hip."""
    stations = [
        (0.010, -0.010, 0.062, 0.062, 0.014),
        (0.002, -0.010, 0.072, 0.072, 0.020),
        (-0.085, -0.010, 0.074, 0.074, 0.024),
        (-0.100, -0.010, 0.066, 0.066, 0.018),
    ]
    bones = body.bones
    ring = rings(stations, 8, bones.stature, 3.4)
    ring[..., 1] += (0.102 * body.build * max(body.figure.hips, body.figure.waist) + 0.018) * bones.stature
    return loft(ring, 0.003 * bones.stature, 0.003 * bones.stature, patches["bag"])


def upper_arm(body: Body, patches: Patches) -> SmoothShape:
    """Return a sleeve from the shoulder to the elbow."""
    stations = [
        (-0.0010, -0.001, 0.017, 0.018, 0.0130),
        (-0.0110, 0.000, 0.028, 0.029, 0.0220),
        (-0.0340, 0.000, 0.033, 0.034, 0.0280),
        (-0.1250, 0.000, 0.027, 0.027, 0.0255),
        (-0.1860, 0.000, 0.023, 0.024, 0.0225),
    ]
    bones = body.bones
    ring = rings(_of_an_arm(stations, body), LIMB_SIDES, bones.stature)
    return loft(ring, 0.003 * bones.stature, 0.014 * bones.stature, patches["upper_arm"])


def _of_an_arm(stations: list[Station], body: Body) -> list[Station]:
    girth: Along = ((0.0, 0.5 + 0.5 * body.figure.shoulders),)
    return fitted(stations, body, tall=body.figure.limbs, wide=girth, deep=girth)


def forearm(body: Body, patches: Patches) -> SmoothShape:
    """Return a forearm from the elbow to the wrist and a hand half closed, its palm towards the thigh."""
    arm = [
        (0.0080, 0.000, 0.020, 0.021, 0.019),
        (-0.0300, 0.000, 0.0245, 0.025, 0.0225),
        (-0.0800, 0.000, 0.0215, 0.022, 0.0200),
        (-0.1440, 0.000, 0.0180, 0.018, 0.0160),
    ]
    hand = [
        (-0.1380, 0.000, 0.0125, 0.0125, 0.0100),
        (-0.1850, 0.002, 0.0215, 0.0195, 0.0125),
        (-0.2080, 0.004, 0.0190, 0.0175, 0.0125),
        (-0.2260, 0.007, 0.0130, 0.0120, 0.0100),
    ]
    bones = body.bones
    sleeve = loft(
        rings(_of_an_arm(arm, body), LIMB_SIDES, bones.stature),
        0.010 * bones.stature,
        0.001 * bones.stature,
        patches["forearm"],
    )
    palm = rings(hand, 6, bones.stature)
    palm[..., 2] *= body.figure.limbs
    return joined([sleeve, loft(palm, 0.0, 0.006 * bones.stature, patches["hand"])])


def thigh(body: Body, patches: Patches) -> SmoothShape:
    """Return a trouser leg from the hip to the knee."""
    stations = [
        (0.0100, 0.000, 0.034, 0.046, 0.036),
        (-0.0180, 0.000, 0.046, 0.058, 0.0460),
        (-0.0600, 0.001, 0.050, 0.053, 0.0460),
        (-0.1300, 0.002, 0.045, 0.044, 0.0420),
        (-0.2450, 0.002, 0.034, 0.031, 0.0325),
    ]
    bones, figure = body.bones, body.figure
    girth: Along = ((-0.245, 1.0), (-0.06, figure.hips))
    made = fitted(stations, body, tall=figure.limbs, wide=girth, deep=girth)
    ring = rings(made, LIMB_SIDES, bones.stature, 2.1)
    return loft(ring, 0.010 * bones.stature, 0.016 * bones.stature, patches["thigh"])


def shin(body: Body, patches: Patches, bare: bool) -> SmoothShape:
    """Return a trouser leg from the knee to the hem above the shoe, or a bare shin."""
    cloth = [
        (0.0150, 0.002, 0.031, 0.027, 0.0295),
        (-0.0400, 0.001, 0.031, 0.034, 0.0310),
        (-0.1600, 0.000, 0.028, 0.032, 0.0290),
        (-0.2340, 0.002, 0.0300, 0.033, 0.0290),
    ]
    skin = [
        (0.0150, 0.002, 0.028, 0.025, 0.0265),
        (-0.0850, 0.000, 0.024, 0.033, 0.0275),
        (-0.1500, 0.000, 0.020, 0.024, 0.0205),
        (-0.2400, 0.000, 0.017, 0.021, 0.0160),
    ]
    bones = body.bones
    ring = rings(fitted(skin if bare else cloth, body, tall=body.figure.limbs), LIMB_SIDES, bones.stature, 2.1)
    return loft(ring, 0.012 * bones.stature, (0.002 if bare else -0.01) * bones.stature, patches["shin"])


def foot(bones: Skeleton, patches: Patches) -> SmoothShape:
    """Return a shoe, its sole flat from the heel to the ball and rising to the tip."""
    middle, half = 0.5 * (bones.toe - bones.heel) / bones.stature, 0.5 * (bones.toe + bones.heel) / bones.stature
    stations = [
        (0.0180, -0.006, 0.021, 0.024, 0.0195),
        (-0.0080, 0.014, 0.044, 0.052, 0.0265),
        (-0.0190, middle - 0.003, half - 0.011, half - 0.006, 0.0285),
        (-0.0290, middle, half, half - 0.001, 0.0300),
        (-0.0390, middle, half, half, 0.0295),
    ]
    ring = rings(stations, 12, bones.stature, 2.6)
    shoe = loft(ring, 0.0, 0.0, patches["foot"])
    # Narrow at the heel, widest at the ball; the tip bends up.
    x = shoe.vertices_m[:, 0]
    shoe.vertices_m[:, 1] *= np.interp(x / bones.stature, [-0.04, 0.0, 0.06, 0.1145], [0.86, 0.86, 1.08, 1.0])
    shoe.vertices_m[:, 2] += bones.toe_rise * np.maximum((x - bones.ball) / (bones.toe - bones.ball), 0.0)
    return shoe
