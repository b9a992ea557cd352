"""People and cyclists as a camera high above sees them: some hundred triangles in plain colours.

``person`` is for cameras close by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.mesh import Texture, TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv
from sim.motion.gait import phase_rate_radps, stride_lengths_m

Rgb = tuple[int, int, int]

SKIN_RGB: tuple[Rgb, ...] = ((224, 182, 154), (198, 150, 118), (150, 104, 76), (96, 66, 50), (234, 198, 174))
HAIR_RGB: tuple[Rgb, ...] = ((46, 36, 30), (84, 60, 42), (150, 118, 76), (34, 32, 32), (150, 148, 144), (122, 70, 46))
TOP_RGB: tuple[Rgb, ...] = (
    (46, 52, 62),
    (150, 34, 38),
    (210, 208, 202),
    (52, 84, 132),
    (88, 96, 68),
    (204, 168, 60),
    (128, 128, 130),
    (186, 116, 128),
    (60, 120, 116),
    (30, 30, 34),
)
LEGWEAR_RGB: tuple[Rgb, ...] = ((44, 54, 78), (36, 36, 40), (98, 92, 82), (70, 84, 110), (122, 108, 84))
HIP, _KNEE, _SHOULDER = 0.52, 0.28, 0.82
"""Heights of joints, shares of stature."""
PEDESTRIAN_PARTS = ("body", "left leg", "right leg")
_HALF_HIPS = 0.055
_SKIN, _HAIR, _TOP, _LEGS, _SHOES, _EXTRA = range(6)
_COLOURS = 6


@dataclass(frozen=True)
class PedestrianLook:
    """Stature, and colours (sRGB 0-255).

    Attributes:
        extra_rgb: of a bag, of a cyclist the bicycle's. bag: whether there is one.
    """

    stature_m: float
    skin_rgb: Rgb
    hair_rgb: Rgb
    top_rgb: Rgb
    legwear_rgb: Rgb
    extra_rgb: Rgb
    bag: bool


def draw_look(rng: np.random.Generator) -> PedestrianLook:
    """Draw a look: women, men, and some children."""
    stature_m = float(np.clip(rng.normal(1.71, 0.1), 1.45, 1.98))
    if rng.random() < 0.12:
        stature_m = float(rng.uniform(1.05, 1.45))

    def one(colours: tuple[Rgb, ...]) -> Rgb:
        return colours[int(rng.integers(len(colours)))]

    return PedestrianLook(
        stature_m, one(SKIN_RGB), one(HAIR_RGB), one(TOP_RGB), one(LEGWEAR_RGB), one(TOP_RGB), rng.random() < 0.35
    )


def pedestrian(look: PedestrianLook) -> tuple[TexturedMesh, TexturedMesh, TexturedMesh]:
    """Return the parts ``PEDESTRIAN_PARTS`` of a person, whose poses are those of ``pedestrian_poses``."""
    check("stature_m", 0.8 <= look.stature_m <= 2.2, "a length from 0.8 to 2.2 m", look.stature_m)
    height = look.stature_m
    facets, colours = Facets(), _palette(look)
    _add_trunk(facets, height, 0.0, 0.0)
    for side in (-1.0, 1.0):
        hand, shoulder = (0.05, side * 0.16 * height, 0.43 * height), (0.0, side * 0.135 * height, _SHOULDER * height)
        _add_limb(facets, hand, shoulder, 0.028 * height, _TOP)
    if look.bag:
        facets.box((-0.26, -0.13, 0.56 * height), (-0.09, 0.13, 0.79 * height), _colour(_EXTRA))
    legs = []
    for side in (1.0, -1.0):
        leg = Facets()
        y = side * _HALF_HIPS * height
        _add_limb(leg, (0.0, y, (0.04 - HIP) * height), (0.0, y, 0.01), 0.04 * height, _LEGS)
        leg.box((-0.06, y - 0.045, -HIP * height), (0.17, y + 0.045, (0.05 - HIP) * height), _colour(_SHOES))
        legs.append(leg.mesh(colours))
    return facets.mesh(colours), legs[0], legs[1]


def pedestrian_poses(
    stature_m: NDArray[np.float64],
    T_world_person: NDArray[np.float64],
    phase_rad: NDArray[np.float64],
    speed_mps: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the poses (N, 3, 4, 4) of the parts of N people: straight legs swing about the hips, the trunk turns
    against them.

    Args:
        stature_m: (N,). T_world_person: (N, 4, 4). speed_mps: (N,); at speed 0 a person stands.
        phase_rad: (N,) of the strides, advance by ``gait.phase_rate_radps``; see there.
    """
    hip_m = HIP * stature_m
    reach = 0.25 * stride_lengths_m(stature_m, speed_mps) / hip_m
    swing_rad = np.arcsin(np.minimum(reach, 0.6)) * np.cos(phase_rad)
    drop_m = hip_m * (1.0 - np.cos(swing_rad))
    poses = np.zeros((len(stature_m), 3, 4, 4))
    poses[..., range(4), range(4)] = 1.0
    turn = -0.3 * swing_rad
    c, s = np.cos(turn), np.sin(turn)
    poses[:, 0, 0, 0], poses[:, 0, 0, 1], poses[:, 0, 1, 0], poses[:, 0, 1, 1] = c, -s, s, c
    poses[:, 0, 2, 3] = -drop_m
    for k, angle in ((1, -swing_rad), (2, swing_rad)):
        c, s = np.cos(angle), np.sin(angle)
        poses[:, k, 0, 0], poses[:, k, 0, 2], poses[:, k, 2, 0], poses[:, k, 2, 2] = c, s, -s, c
        poses[:, k, 2, 3] = hip_m - drop_m
    placed: NDArray[np.float64] = T_world_person[:, None] @ poses
    return placed


def stride_rate_radps(look: PedestrianLook, speed_mps: float) -> float:
    """Return the rate of a person's phase."""
    return phase_rate_radps(look.stature_m, speed_mps)


def cyclist(look: PedestrianLook) -> TexturedMesh:
    """Return a person on a bicycle, about 1.8 m long, x ahead."""
    facets = Facets()
    metal = _colour(_EXTRA)
    for x in (-0.53, 0.53):
        angles = np.arange(10) * (0.2 * np.pi)
        rim = np.column_stack([x + 0.34 * np.cos(angles), 0.35 + 0.34 * np.sin(angles)])
        rings = [[(a, y, z) for a, z in rim] for y in (0.02, -0.02)]
        facets.loft(rings, lambda segment, side: _colour(_SHOES), _colour(_SHOES), _colour(_SHOES))
    facets.box((-0.5, -0.025, 0.5), (0.42, 0.025, 0.6), metal)
    facets.box((-0.22, -0.03, 0.3), (-0.12, 0.03, 0.92), metal)
    facets.box((0.4, -0.03, 0.36), (0.48, 0.03, 1.02), metal)
    facets.box((0.38, -0.27, 1.0), (0.44, 0.27, 1.05), metal)
    _add_trunk(facets, 1.72, 0.42, 0.08, seat_m=-0.2)
    for side in (-1.0, 1.0):
        _add_limb(facets, (0.42, side * 0.24, 1.04), (0.12, side * 0.2, 1.42), 0.045, _TOP)
        knee = (0.2, side * 0.1, 0.68 + 0.12 * side)
        _add_limb(facets, knee, (-0.18, side * 0.1, 0.98), 0.07, _LEGS)
        _add_limb(facets, (0.02 - 0.1 * side, side * 0.11, 0.2 + 0.15 * (side + 1.0)), knee, 0.055, _LEGS)
    return facets.mesh(_palette(look))


def _add_trunk(facets: Facets, height: float, lean_m: float, raise_m: float, seat_m: float = 0.0) -> None:
    """Add hips, chest and head, leaning ahead by ``lean_m`` at the head."""
    rows = (
        (0.47, 0.075, 0.098),
        (0.53, 0.075, 0.1),
        (0.64, 0.06, 0.088),
        (0.8, 0.07, 0.125),
        (0.845, 0.035, 0.06),
    )
    rings = []
    for share, half_x, half_y in rows:
        x = seat_m + lean_m * (share - 0.47) / 0.53
        rings.append(_ring(x, 0.0, share * height + raise_m, half_x * height, half_y * height))
    colours = (_LEGS, _TOP, _TOP, _TOP)
    facets.loft(rings, lambda segment, side: _colour(colours[segment]), _colour(_LEGS), _colour(_SKIN))
    x = seat_m + lean_m * 0.92
    head = [
        _ring(x, 0.0, share * height + raise_m, half * height, 0.85 * half * height)
        for share, half in ((0.845, 0.028), (0.9, 0.05), (0.955, 0.053), (0.985, 0.04), (1.0, 0.015))
    ]
    shades = (_SKIN, _SKIN, _HAIR, _HAIR)
    facets.loft(head, lambda segment, side: _colour(shades[segment]), _colour(_SKIN), _colour(_HAIR))


def _add_limb(
    facets: Facets, low: tuple[float, float, float], high: tuple[float, float, float], half_m: float, colour: int
) -> None:
    """Add a square limb from its lower to its upper end."""
    rings = [_ring(*end, size, size, 4) for end, size in ((low, 0.75 * half_m), (high, 1.15 * half_m))]
    facets.loft(rings, lambda segment, side: _colour(colour), _colour(_SKIN), _colour(colour))


def _ring(x: float, y: float, z: float, half_x: float, half_y: float, count: int = 6) -> NDArray[np.float64]:
    angles = (np.arange(count) + 0.5) * (2.0 * np.pi / count)
    return np.column_stack([x + half_x * np.cos(angles), y + half_y * np.sin(angles), np.full(count, z)])


def _colour(index: int) -> tuple[float, float]:
    return swatch_uv(index, _COLOURS)


def _palette(look: PedestrianLook) -> Texture:
    shoes = (40, 38, 38)
    return palette([look.skin_rgb, look.hair_rgb, look.top_rgb, look.legwear_rgb, shoes, look.extra_rgb])
