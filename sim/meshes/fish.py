"""Meshes of fish: rigid segments for the poses of ``sim.motion.swim``, much like a zebrafish seen from above.

Other species are as long, high and coloured as a ``FishLook`` says.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from sim.checks import check, check_types, check_within
from sim.mesh import Texture, TexturedMesh
from sim.motion.swim import SEGMENT_COUNT, SEGMENT_ENDS

RGB = tuple[int, int, int]

_LENGTH_SPREAD, _WIDTH_SPREAD = 0.07, 0.06
"""Standard deviations among adults of one age, as shares; our choice, as are all below."""
_SHADE_SPREAD, _HUE_SPREAD = 0.16, 0.02
_STRIPE_SPREAD = 0.12
_MOST_SPOTS = 4


@dataclass(frozen=True, slots=True)
class FishLook:
    """One fish's size, colours (sRGB 0-255) and markings.

    Attributes:
        length_m: from snout to the end of the tail fin, within [0.01, 0.3].
        width: factor of the body's width, within [0.8, 1.25]. height: of its height and that of the tail fin, within
            [0.8, 2.0].
        back_rgb, flank_rgb: the back is the darker one.
        fin_rgb: of fins, which are clear in truth and take a little of the floor's colour.
        stripes: contrast of the stripes along the flanks, within [0, 1].
        spots: dark spots on the back, as (place behind the snout as a share of length, darkness in [0, 1]).
        bars: dark bars across back and flanks, as (place, half width), shares of length.
        line_rgb: of a shining line along the upper flanks, None for none. hind_rgb: of the flanks behind the middle,
            None for their own colour.
    """

    length_m: float = 0.035
    width: float = 1.0
    back_rgb: RGB = (74, 70, 58)
    flank_rgb: RGB = (150, 150, 140)
    fin_rgb: RGB = (128, 124, 108)
    stripes: float = 0.45
    spots: tuple[tuple[float, float], ...] = ()
    height: float = 1.0
    bars: tuple[tuple[float, float], ...] = ()
    line_rgb: RGB | None = None
    hind_rgb: RGB | None = None

    def __post_init__(self) -> None:
        """Check sizes and colours.

        Raises:
            ValueError: for an impossible one.
        """
        check_types(self)
        check_within(self, "length_m", 0.01, 0.3)
        check_within(self, "width", 0.8, 1.25)
        check_within(self, "height", 0.8, 2.0)
        check_within(self, "stripes", 0.0, 1.0)
        for name in ("back_rgb", "flank_rgb", "fin_rgb", "line_rgb", "hind_rgb"):
            rgb = getattr(self, name)
            good = rgb is None or all(0 <= c <= 255 for c in rgb)
            check(name, good, "three numbers from 0 to 255", rgb)
        for name in ("spots", "bars"):
            for pair in getattr(self, name):
                check(name, len(pair) == 2 and all(0 <= part <= 1 for part in pair), "pairs within [0, 1]", pair)


Species = Literal["zebrafish", "tetra", "guppy", "barb"]

SPECIES: dict[Species, FishLook] = {
    "zebrafish": FishLook(),
    "tetra": FishLook(
        length_m=0.027,
        width=0.95,
        height=1.15,
        back_rgb=(86, 84, 62),
        flank_rgb=(176, 176, 164),
        fin_rgb=(150, 146, 132),
        stripes=0.0,
        line_rgb=(44, 150, 200),
        hind_rgb=(186, 52, 44),
    ),
    "guppy": FishLook(
        length_m=0.030,
        width=0.9,
        back_rgb=(122, 112, 84),
        flank_rgb=(172, 160, 126),
        fin_rgb=(206, 116, 44),
        stripes=0.1,
        spots=((0.55, 0.7),),
        hind_rgb=(196, 124, 70),
    ),
    "barb": FishLook(
        length_m=0.048,
        width=1.05,
        height=1.8,
        back_rgb=(150, 118, 58),
        flank_rgb=(206, 174, 106),
        fin_rgb=(190, 74, 40),
        stripes=0.0,
        bars=((0.08, 0.025), (0.30, 0.040), (0.56, 0.038), (0.79, 0.025)),
    ),
}
"""The middle look of each species: zebrafish (Danio rerio), neon tetra (Paracheirodon innesi), guppy (Poecilia
reticulata), tiger barb (Puntigrus tetrazona).

Lengths are total lengths of adults in aquaria: zebrafish 25 to 40 mm (Spence and others, Biological Reviews, 2008),
tetra 20 to 30, guppy 15 to 35 (males), barb up to 70 (FishBase). Heights are our reading of photographs: for its
length a barb is almost twice as deep as a zebrafish.
"""


def draw_look(rng: np.random.Generator, variety: float, species: Species = "zebrafish") -> FishLook:
    """Return the look of one fish of a shoal.

    Args:
        rng: draws the same number of values whatever the variety.
        variety: 0 = all fish look the same; 1 = they differ in size, shade, stripes and spots as adults of one strain.

    Raises:
        ValueError: for a variety outside [0, 1].
    """
    check("variety", 0.0 <= variety <= 1.0, "a number in [0, 1]", variety)
    mean = SPECIES[species]
    length, width, shade, stripes = variety * np.clip(rng.normal(size=4), -2.0, 2.0)
    hue = 1.0 + variety * _HUE_SPREAD * np.clip(rng.normal(size=3), -2.0, 2.0)
    count = round(variety * _MOST_SPOTS * float(rng.random()))
    places, darkness = rng.uniform(0.25, 0.75, _MOST_SPOTS), rng.uniform(0.3, 0.8, _MOST_SPOTS)
    light = np.exp(_SHADE_SPREAD * shade)
    return FishLook(
        length_m=mean.length_m * float(np.exp(_LENGTH_SPREAD * length)),
        width=float(np.clip(mean.width * (1.0 + _WIDTH_SPREAD * width), 0.8, 1.25)),
        back_rgb=_tinted(mean.back_rgb, light * hue),
        flank_rgb=_tinted(mean.flank_rgb, np.sqrt(light) * hue),
        fin_rgb=mean.fin_rgb,
        stripes=float(np.clip(mean.stripes + _STRIPE_SPREAD * stripes, 0.0, 1.0)) if mean.stripes > 0 else 0.0,
        spots=mean.spots + tuple((float(p), float(d)) for p, d in zip(places[:count], darkness[:count], strict=True)),
        height=mean.height,
        bars=mean.bars,
        line_rgb=mean.line_rgb,
        hind_rgb=mean.hind_rgb,
    )


def _tinted(rgb: RGB, factor: object) -> RGB:
    red, green, blue = np.clip(np.rint(np.array(rgb) * factor), 0, 255).astype(int).tolist()
    return red, green, blue


HEIGHT_TEXELS, WIDTH_TEXELS = 96, 24
_BODY_TEXELS = 64
"""Rows of the skin, from snout to tail; columns go from the middle of the back down to that of the belly. Both sides of
a fish are alike, so that there is no seam on its back."""
_FIN_ROWS, _EYE_ROWS = (68, 82), (82, 96)

FIN_UV = (0.5, (_FIN_ROWS[0] + _FIN_ROWS[1]) / 2 / HEIGHT_TEXELS)
EYE_UV = (0.5, (_EYE_ROWS[0] + _EYE_ROWS[1]) / 2 / HEIGHT_TEXELS)
"""Where fins and eyes have their one colour."""

_EYE_RGB = (22, 21, 20)
_STRIPES_RAD = np.deg2rad([42.0, 75.0, 108.0])
"""Azimuths of the stripes from the middle of the back."""


def body_uv(share: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the place (V, 2) in the texture of points on the skin.

    Args:
        share: (V,) behind the snout, in lengths. y, z: (V,) to the left of and above the axis.
    """
    u = np.abs(np.arctan2(y, z)) / np.pi
    v = np.clip(share, 0.0, 1.0) * (_BODY_TEXELS / HEIGHT_TEXELS)
    return np.column_stack([u, v])


def paint(look: FishLook, rng: np.random.Generator) -> Texture:
    """Return a fish's texture.

    Args:
        rng: of the mottling.
    """
    picture = np.empty((HEIGHT_TEXELS, WIDTH_TEXELS, 3))
    picture[:] = look.fin_rgb
    picture[:_BODY_TEXELS] = _skin(look, rng)
    picture[_BODY_TEXELS : _FIN_ROWS[0]] = picture[_BODY_TEXELS - 1]
    picture[_EYE_ROWS[0] :] = _EYE_RGB
    return Texture(np.clip(picture + 0.5, 0, 255).astype(np.uint8), smooth=True)


def _skin(look: FishLook, rng: np.random.Generator) -> NDArray[np.float64]:
    share = ((np.arange(_BODY_TEXELS) + 0.5) / _BODY_TEXELS)[:, None]
    azimuth = (np.pi * (np.arange(WIDTH_TEXELS) + 0.5) / WIDTH_TEXELS)[None]
    back, flank = np.array(look.back_rgb, dtype=float), np.array(look.flank_rgb, dtype=float)
    # The dark of the back reaches farther down on the head.
    edge = np.deg2rad(38.0) + np.deg2rad(30.0) * np.clip((0.2 - share) / 0.08, 0.0, 1.0)
    dark = 1.0 / (1.0 + np.exp((azimuth - edge) / np.deg2rad(9.0)))
    if look.hind_rgb is not None:
        behind = np.clip((share - 0.45) / 0.08, 0.0, 1.0)[..., None]
        flank = flank + behind * (np.array(look.hind_rgb, dtype=float) - flank)
    colour = flank + (back - flank) * dark[..., None]
    if look.line_rgb is not None:
        line = np.exp(-(((azimuth - np.deg2rad(44.0)) / np.deg2rad(15.0)) ** 4)) * ((share > 0.07) & (share < 0.72))
        colour = colour + line[..., None] * (np.array(look.line_rgb, dtype=float) - colour)
    belly = np.clip((azimuth - np.deg2rad(120.0)) / np.deg2rad(30.0), 0.0, 1.0)
    colour += (230.0 - colour) * (0.6 * belly * np.ones_like(share))[..., None]
    lines = sum(np.exp(-0.5 * ((azimuth - at) / np.deg2rad(8.0)) ** 2) for at in _STRIPES_RAD)
    behind_gills = np.clip((share - 0.2) / 0.04, 0.0, 1.0)
    shade = 1.0 - 0.7 * look.stripes * lines * behind_gills
    for place, darkness in look.spots:
        shade = shade * (1.0 - darkness * np.exp(-0.5 * ((share - place) / 0.018) ** 2 - 0.5 * (azimuth / 0.5) ** 2))
    for place, half_width in look.bars:
        bar = np.exp(-(((share - place) / half_width) ** 4)) * np.clip((np.deg2rad(165.0) - azimuth) / 0.3, 0.0, 1.0)
        shade = shade * (1.0 - 0.85 * bar)
    # A pale edge of the gills, and mottling.
    shade = shade * (1.0 + 0.18 * np.exp(-0.5 * ((share - 0.2) / 0.012) ** 2))
    mottling = gaussian_filter(rng.normal(size=colour.shape[:2]), 1.2, mode="nearest")
    return colour * (shade * (1.0 + 0.05 * mottling / mottling.std()))[..., None]


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
            (shape.vertices * look.length_m * np.array([1.0, look.width, look.height])).astype(np.float32),
            _unit(shape.normals / np.array([1.0, look.width, look.height])).astype(np.float32),
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
