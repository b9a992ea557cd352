"""Sizes, looks and shapes of a person's clothed parts: limbs, trunk, head, shoes, as shares of stature.

Every shape stands in the frame of its part (see ``sim.motion.skeleton``). Ends are rounded and reach beyond the joints,
so that nothing gapes where they bend. Lengths are those of the skeleton; breadths and depths are chosen by eye for
clothed adults within the breadths of Drillis and Contini (1966): shoulders 0.259, hips 0.191 of stature.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.motion.skeleton import Skeleton, skeleton

RGB = tuple[int, int, int]
HAIR_STYLES = ("short", "long")
PATTERNS = ("plain", "stripes", "check")


@dataclass(frozen=True, slots=True)
class PersonLook:
    """One person's size, colours (sRGB 0-255) and clothes.

    Attributes:
        stature_m: within ``STATURE_M`` of ``sim.motion.skeleton``.
        build: factor of girths within ``BUILD`` there.
        hair_style: long hair reaches the shoulders.
        cap_rgb: of a cap worn over it, None for no cap.
        top_pattern: horizontal stripes or a check in a darker shade of the top.
        sleeves: short ones end above the elbow.
        legwear: shorts end at the knee.
        backpack_rgb: None for no backpack.
    """

    stature_m: float = 1.74
    build: float = 1.0
    skin_rgb: RGB = (204, 158, 130)
    hair_rgb: RGB = (62, 46, 36)
    hair_style: Literal["short", "long"] = "short"
    cap_rgb: RGB | None = None
    top_rgb: RGB = (70, 92, 128)
    top_pattern: Literal["plain", "stripes", "check"] = "plain"
    sleeves: Literal["long", "short"] = "long"
    legwear: Literal["trousers", "shorts"] = "trousers"
    legwear_rgb: RGB = (52, 56, 70)
    shoes_rgb: RGB = (44, 42, 44)
    backpack_rgb: RGB | None = None

    def __post_init__(self) -> None:
        """Check sizes and words.

        Raises:
            ValueError: for an impossible size or an unknown word.
        """
        skeleton(self.stature_m, self.build)
        for name in ("skin", "hair", "cap", "top", "legwear", "shoes", "backpack"):
            rgb = getattr(self, f"{name}_rgb")
            good = rgb is None or (len(rgb) == 3 and all(0 <= c <= 255 for c in rgb))
            check(f"{name}_rgb", good, "three numbers from 0 to 255", rgb)
        check("hair_style", self.hair_style in HAIR_STYLES, f"one of {HAIR_STYLES}", self.hair_style)
        check("top_pattern", self.top_pattern in PATTERNS, f"one of {PATTERNS}", self.top_pattern)
        check("sleeves", self.sleeves in ("long", "short"), "long or short", self.sleeves)
        check("legwear", self.legwear in ("trousers", "shorts"), "trousers or shorts", self.legwear)


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

LIMB_SIDES = 8


def _girthed(stations: list[Station], build: float) -> list[Station]:
    return [(z, centre, ahead * build, behind * build, width * build) for z, centre, ahead, behind, width in stations]


def pelvis(bones: Skeleton, build: float, patches: Patches) -> SmoothShape:
    """Return the seat of the trousers, between the hips."""
    stations = [
        (0.105, 0.000, 0.052, 0.050, 0.080),
        (0.060, 0.000, 0.056, 0.058, 0.087),
        (-0.012, 0.000, 0.053, 0.066, 0.093),
        (-0.038, 0.000, 0.044, 0.054, 0.074),
    ]
    ring = rings(_girthed(stations, build), 10, bones.stature, 2.3)
    return loft(ring, 0.006 * bones.stature, 0.016 * bones.stature, patches["pelvis"])


def torso(bones: Skeleton, build: float, patches: Patches, backpack: bool) -> SmoothShape:
    """Return the top from its collar to its hem, which hangs over the pelvis, and a backpack or none."""
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
    ring = rings(_girthed(stations, build), 12, bones.stature, 2.3)
    cloth = loft(ring, 0.004 * bones.stature, -0.02 * bones.stature, patches["torso"])
    return joined([cloth, _backpack(bones, build, patches)]) if backpack else cloth


def _backpack(bones: Skeleton, build: float, patches: Patches) -> SmoothShape:
    """Return a rounded bag that leans on the shoulder blades."""
    stations = [
        (0.205, -0.082, 0.030, 0.016, 0.050),
        (0.195, -0.086, 0.034, 0.032, 0.072),
        (0.160, -0.090, 0.036, 0.042, 0.084),
        (0.035, -0.088, 0.042, 0.056, 0.086),
        (0.015, -0.086, 0.036, 0.044, 0.078),
    ]
    ring = rings(stations, 8, bones.stature, 3.2)
    ring[..., 0] -= 0.058 * (build - 1.0) * bones.stature
    return loft(ring, 0.004 * bones.stature, 0.003 * bones.stature, patches["backpack"])


def upper_arm(bones: Skeleton, build: float, patches: Patches) -> SmoothShape:
    """Return a sleeve from the shoulder to the elbow."""
    stations = [
        (-0.0010, -0.001, 0.017, 0.018, 0.0130),
        (-0.0110, 0.000, 0.028, 0.029, 0.0220),
        (-0.0340, 0.000, 0.033, 0.034, 0.0280),
        (-0.1250, 0.000, 0.027, 0.027, 0.0255),
        (-0.1860, 0.000, 0.023, 0.024, 0.0225),
    ]
    ring = rings(_girthed(stations, build), LIMB_SIDES, bones.stature)
    return loft(ring, 0.003 * bones.stature, 0.014 * bones.stature, patches["upper_arm"])


def forearm(bones: Skeleton, build: float, patches: Patches) -> SmoothShape:
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
    sleeve = loft(
        rings(_girthed(arm, build), LIMB_SIDES, bones.stature),
        0.010 * bones.stature,
        0.001 * bones.stature,
        patches["forearm"],
    )
    return joined([sleeve, loft(rings(hand, 6, bones.stature), 0.0, 0.006 * bones.stature, patches["hand"])])


def thigh(bones: Skeleton, build: float, patches: Patches) -> SmoothShape:
    """Return a trouser leg from the hip to the knee."""
    stations = [
        (0.0100, 0.000, 0.034, 0.046, 0.036),
        (-0.0180, 0.000, 0.046, 0.058, 0.0460),
        (-0.0600, 0.001, 0.050, 0.053, 0.0460),
        (-0.1300, 0.002, 0.045, 0.044, 0.0420),
        (-0.2450, 0.002, 0.034, 0.031, 0.0325),
    ]
    ring = rings(_girthed(stations, build), LIMB_SIDES, bones.stature, 2.1)
    return loft(ring, 0.010 * bones.stature, 0.016 * bones.stature, patches["thigh"])


def shin(bones: Skeleton, build: float, patches: Patches, bare: bool) -> SmoothShape:
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
    ring = rings(_girthed(skin if bare else cloth, build), LIMB_SIDES, bones.stature, 2.1)
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


HEAD_STATIONS: list[Station] = [
    (0.1520, -0.002, 0.020, 0.024, 0.0200),
    (0.1350, 0.000, 0.048, 0.050, 0.0410),
    (0.1180, 0.000, 0.0540, 0.0560, 0.0440),
    (0.0870, 0.000, 0.0545, 0.0540, 0.0435),
    (0.0720, 0.001, 0.0545, 0.0500, 0.0425),
    (0.0590, 0.002, 0.0550, 0.0460, 0.0405),
    (0.0480, 0.003, 0.0525, 0.0420, 0.0385),
    (0.0370, 0.004, 0.0510, 0.0360, 0.0345),
    (0.0260, 0.006, 0.0460, 0.0300, 0.0270),
]
"""From crown to chin, above the joint of the head at the base of the neck."""

HEAD_FORWARD = 0.012
"""Of the head's middle before that joint, share of stature."""


def head(bones: Skeleton, patches: Patches, hair: str, cap: bool) -> SmoothShape:
    """Return head, neck, ears and nose, and hair that stands off from the head where it grows.

    Args:
        hair: ``"short"``, or ``"long"`` down to the shoulders.
        cap: worn over it.
    """
    ring = rings(HEAD_STATIONS, 12, 1.0, 2.1)
    _raise(ring, hair, 0.006 if hair == "long" else 0.0035)
    if cap:
        _raise(ring, "cap", 0.003)
    _raise_nose(ring)
    ring[..., 0] += HEAD_FORWARD
    skull = loft(bones.stature * ring, 0.003 * bones.stature, 0.002 * bones.stature, patches["head"], upright=True)
    neck_stations = [(0.060, 0.004, 0.028, 0.030, 0.0290), (-0.022, -0.003, 0.036, 0.038, 0.0380)]
    neck = loft(rings(neck_stations, 6, bones.stature), 0.0, 0.0, patches["neck"])
    parts = [skull, neck, _ear(bones, patches, 1.0), _ear(bones, patches, -1.0)]
    if hair == "long":
        parts.append(_mane(bones, patches))
    if cap:
        parts.append(_brim(bones, patches))
    return joined(parts)


def edge_z(azimuth_rad: NDArray[np.float64], edge: str) -> NDArray[np.float64]:
    """Return the height of the lower edge of hair or cap above the joint of the head, share of stature.

    Args:
        azimuth_rad: from straight ahead, either way.
        edge: that of ``"short"`` or ``"long"`` hair or of a ``"cap"``.
    """
    at = np.abs((azimuth_rad + np.pi) % (2.0 * np.pi) - np.pi)
    edges = {
        "short": [0.128, 0.127, 0.112, 0.078, 0.075, 0.050, 0.044],
        "long": [0.128, 0.126, 0.105, 0.060, 0.040, 0.030, 0.026],
        "cap": [0.108, 0.108, 0.106, 0.100, 0.097, 0.094, 0.092],
    }
    return np.interp(at, np.deg2rad([0, 30, 55, 75, 95, 130, 180]), edges[edge])


def _raise(ring: NDArray[np.float64], edge: str, thickness: float) -> None:
    """Move the points (S, N, 3) above an edge outwards from the middle of the head, in shares of stature."""
    covered = np.clip((ring[..., 2] - edge_z(np.arctan2(ring[..., 1], ring[..., 0]), edge)) / 0.008 + 0.5, 0.0, 1.0)
    away = ring - np.array([0.0, 0.0, 0.09])
    ring += (thickness * covered)[..., None] * away / np.linalg.norm(away, axis=2, keepdims=True)


def _raise_nose(ring: NDArray[np.float64]) -> None:
    """Move the points straight ahead, and those under the cheekbones beside them, into a nose and eye sockets."""
    front = ring.shape[1] // 2
    ring[:, front, 0] += np.interp(ring[:, front, 2], [0.050, 0.059, 0.073, 0.087, 0.1], [0, 0.0125, 0.008, 0.001, 0])
    for side in (front - 1, front + 1):
        ring[:, side, 0] -= np.interp(ring[:, side, 2], [0.059, 0.073, 0.087, 0.1], [0, 0.003, 0.0035, 0.0])


def _ear(bones: Skeleton, patches: Patches, side: float) -> SmoothShape:
    stations = [(0.0860, -0.004, 0.007, 0.009, 0.0050), (0.0650, -0.001, 0.006, 0.007, 0.0045)]
    ring = rings(stations, 4, bones.stature)
    ring += bones.stature * np.array([HEAD_FORWARD, side * 0.0455, 0.0])
    return loft(ring, 0.004 * bones.stature, 0.004 * bones.stature, patches["ear"])


def _mane(bones: Skeleton, patches: Patches) -> SmoothShape:
    """Return hair that falls behind the ears onto the shoulders."""
    stations = [
        (0.115, -0.012, 0.026, 0.047, 0.0410),
        (0.088, -0.012, 0.024, 0.0515, 0.0490),
        (0.050, -0.013, 0.018, 0.0500, 0.0505),
        (0.010, -0.018, 0.016, 0.0430, 0.0490),
        (-0.030, -0.030, 0.012, 0.0300, 0.0420),
    ]
    ring = rings(stations, 8, bones.stature, 2.4) + bones.stature * np.array([HEAD_FORWARD, 0.0, 0.0])
    return loft(ring, 0.004 * bones.stature, 0.004 * bones.stature, patches["hair"])


def _brim(bones: Skeleton, patches: Patches) -> SmoothShape:
    """Return the peak of a cap."""
    stations = [(0.1130, 0.040, 0.050, 0.030, 0.0370), (0.1080, 0.040, 0.053, 0.030, 0.0400)]
    ring = rings(stations, 6, bones.stature, 2.4)
    ring[..., 2] -= 0.15 * np.maximum(ring[..., 0] - 0.06 * bones.stature, 0.0)
    ring[..., 0] += HEAD_FORWARD * bones.stature
    return loft(ring, 0.001 * bones.stature, 0.001 * bones.stature, patches["cap"])
