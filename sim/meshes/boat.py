"""Boats as a thermal camera sees them: hull, deck, wheelhouse, engine and exhaust as parts with temperatures."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from sim.checks import check
from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, swatch_uv
from sim.meshes.thermal_paint import parts_palette

BOATS = ("fisher", "launch", "yacht")


class BoatPart(IntEnum):
    """Parts of a boat; ``WET`` is the hull near the waterline, ``GEAR`` mast, rails and nets."""

    HULL = 0
    DECK = 1
    CABIN = 2
    GLASS = 3
    ENGINE = 4
    EXHAUST = 5
    GEAR = 6
    WET = 7


_TEXTURE = parts_palette(len(BoatPart))
_DRAUGHT_M = 0.45
"""Depth to which the hull is modelled: deeper than its waterline ever rises when it rolls."""
_RAIL_M = 0.3
"""Height of the rail above the deck."""
_FREEBOARD = {"fisher": 0.095, "launch": 0.1, "yacht": 0.1}
"""Height of the rail amidships over the length."""
_OUTBOARD_M = 0.42
"""How far the outboard engine reaches behind the stern."""
_STATIONS = (
    (-0.5, 0.78, 1.0, 0.0),
    (-0.49, 0.79, 1.0, 1.0),
    (-0.3, 0.95, 0.96, 1.0),
    (0.0, 1.0, 1.0, 1.0),
    (0.2, 0.9, 1.1, 1.0),
    (0.36, 0.58, 1.28, 1.0),
    (0.47, 0.14, 1.46, 1.0),
    (0.5, 0.07, 1.5, 0.0),
)
"""x over length, half width over half the beam, height of the rail over the freeboard, depth of the deck below it."""


def boat(model: str, length_m: float, beam_m: float) -> TexturedMesh:
    """Return a boat on its waterline z = 0, x ahead, the origin under the middle of its bounds.

    Args:
        model: ``fisher``: wheelhouse ahead, engine hatch and exhaust behind it; ``launch``: open, with an outboard
            engine; ``yacht``: low cabin and a tall mast.

    Raises:
        ValueError: for an unknown model or a length or beam that is not > 0.
    """
    check("model", model in BOATS, f"one of {', '.join(BOATS)}", model)
    check("length_m beam_m", min(length_m, beam_m) > 0, "lengths > 0 m", (length_m, beam_m))
    facets = Facets()
    freeboard_m = _FREEBOARD[model] * length_m
    _add_hull(facets, length_m, beam_m, freeboard_m)
    {"fisher": _add_fisher, "launch": _add_launch, "yacht": _add_yacht}[model](facets, length_m, beam_m, freeboard_m)
    mesh = facets.mesh(_TEXTURE)
    vertices_m = mesh.vertices_m.copy()
    vertices_m[:, 0] -= 0.5 * (vertices_m[:, 0].min() + vertices_m[:, 0].max())
    return TexturedMesh(vertices_m, mesh.normals, mesh.uv, mesh.faces, _TEXTURE)


class Place(NamedTuple):
    """Where someone stands or sits aboard: the floor under the pelvis, and the height of the seat over it, if any."""

    floor_m: tuple[float, float, float]
    seat_m: float | None = None


def places_aboard(model: str, length_m: float) -> tuple[Place, ...]:
    """Return where people have room on the deck of a boat of ``boat``; who steers from a wheelhouse is not seen.

    ``fisher``: between hatch and net drum, and on the foredeck; ``launch``: behind the console, and on the last bench.
    """
    deck = _FREEBOARD[model] * length_m - _RAIL_M
    if model == "fisher":
        fore = 1.24 * _FREEBOARD[model] * length_m - _RAIL_M
        return Place((-0.215 * length_m, 0.0, deck)), Place((0.325 * length_m, 0.0, fore))
    if model == "launch":
        # Its engine hangs behind the stern, which moves the middle.
        x, bench = 0.5 * _OUTBOARD_M - 0.27 * length_m, 0.32
        helm = Place((0.5 * _OUTBOARD_M - 0.025 * length_m, 0.0, deck))
        return helm, Place((x, 0.4, deck), bench), Place((x, -0.4, deck), bench)
    return ()


def _of(part: BoatPart) -> tuple[float, float]:
    return swatch_uv(part, len(BoatPart))


def above_water(mesh: TexturedMesh) -> TexturedMesh:
    """Return a boat's shape for labels: what is below the waterline z = 0 is raised to it."""
    dry = mesh.vertices_m.copy()
    dry[:, 2] = np.maximum(dry[:, 2], 0.0)
    return TexturedMesh(dry, mesh.normals, mesh.uv, mesh.faces, mesh.texture)


def _add_hull(facets: Facets, length_m: float, beam_m: float, freeboard_m: float) -> None:
    """Add a closed loft from stern to bow, and a rail around the deck."""
    rings = []
    for x, width, rise, depth in _STATIONS:
        half, rail = 0.5 * beam_m * width, freeboard_m * rise
        outside = [(0.62 * half, -_DRAUGHT_M), (0.92 * half, 0.22), (half, rail)]
        side = [*outside, (0.9 * half, rail), (0.8 * half, rail - depth * _RAIL_M)]
        ring = [(x * length_m, y, z) for y, z in side] + [(x * length_m, -y, z) for y, z in reversed(side)]
        rings.append(ring)
    parts = [BoatPart.WET, BoatPart.HULL, BoatPart.GEAR, BoatPart.DECK]
    around = [*parts, BoatPart.DECK, *parts[::-1], BoatPart.WET]
    facets.loft(rings, lambda segment, side: _of(around[side]), _of(BoatPart.HULL), _of(BoatPart.HULL))


def _add_fisher(facets: Facets, length_m: float, beam_m: float, freeboard_m: float) -> None:
    deck, half = freeboard_m - _RAIL_M, 0.3 * beam_m
    x0, x1 = 0.05 * length_m, 0.27 * length_m
    _add_house(facets, (x0, x1), half, deck, deck + 2.2)
    facets.box(
        (-0.16 * length_m, -0.22 * beam_m, deck), (-0.02 * length_m, 0.22 * beam_m, deck + 0.55), _of(BoatPart.ENGINE)
    )
    low, stack = deck + 1.5, deck + 2.8
    facets.box((x0 - 0.3, 0.5 * half, low), (x0 - 0.08, 0.5 * half + 0.22, stack), _of(BoatPart.EXHAUST))
    facets.box((x1 - 0.45, -0.05, deck + 2.2), (x1 - 0.35, 0.05, deck + 4.0), _of(BoatPart.GEAR))
    # Net drum and boxes at the stern, a gallows above.
    facets.box(
        (-0.36 * length_m, -0.26 * beam_m, deck), (-0.27 * length_m, 0.26 * beam_m, deck + 0.8), _of(BoatPart.GEAR)
    )
    for side in (-1.0, 1.0):
        y = side * 0.3 * beam_m
        facets.box((-0.42 * length_m, y - 0.06, deck), (-0.41 * length_m, y + 0.06, deck + 1.9), _of(BoatPart.GEAR))
    gallows = (-0.42 * length_m, -0.3 * beam_m, deck + 1.8), (-0.41 * length_m, 0.3 * beam_m, deck + 1.92)
    facets.box(*gallows, _of(BoatPart.GEAR))


def _add_launch(facets: Facets, length_m: float, beam_m: float, freeboard_m: float) -> None:
    deck = freeboard_m - _RAIL_M
    facets.box((0.02 * length_m, -0.2 * beam_m, deck), (0.1 * length_m, 0.2 * beam_m, deck + 0.9), _of(BoatPart.CABIN))
    facets.box(
        (0.08 * length_m, -0.2 * beam_m, deck + 0.9), (0.1 * length_m, 0.2 * beam_m, deck + 1.25), _of(BoatPart.GLASS)
    )
    for share in (-0.3, -0.12):
        bench = (share * length_m, -0.36 * beam_m, deck + 0.2), ((share + 0.06) * length_m, 0.36 * beam_m, deck + 0.32)
        facets.box(*bench, _of(BoatPart.DECK))
    stern = -0.5 * length_m
    facets.box((stern - 0.35, -0.2, -0.3), (stern, 0.2, freeboard_m - 0.05), _of(BoatPart.EXHAUST))
    facets.box(
        (stern - _OUTBOARD_M, -0.24, freeboard_m - 0.05), (stern + 0.08, 0.24, freeboard_m + 0.45), _of(BoatPart.ENGINE)
    )


def _add_yacht(facets: Facets, length_m: float, beam_m: float, freeboard_m: float) -> None:
    deck = freeboard_m - _RAIL_M
    _add_house(facets, (-0.1 * length_m, 0.24 * length_m), 0.28 * beam_m, deck, deck + 0.95)
    mast_m = 1.05 * length_m
    facets.box((0.08 * length_m, -0.07, deck), (0.08 * length_m + 0.14, 0.07, deck + mast_m), _of(BoatPart.GEAR))
    boom = (-0.36 * length_m, -0.12, deck + 1.3), (0.08 * length_m, 0.12, deck + 1.6)
    facets.box(*boom, _of(BoatPart.CABIN))


def _add_house(facets: Facets, span_x: tuple[float, float], half_m: float, low_m: float, high_m: float) -> None:
    """Add a house with a band of windows under its roof."""
    (x0, x1), window = span_x, low_m + 0.5 * (high_m - low_m)
    top = high_m - 0.18 * (high_m - low_m)
    facets.box((x0, -half_m, low_m), (x1, half_m, window), _of(BoatPart.CABIN))
    facets.box((x0 + 0.03, 0.03 - half_m, window), (x1 - 0.03, half_m - 0.03, top), _of(BoatPart.GLASS))
    facets.box((x0 - 0.1, -half_m - 0.08, top), (x1 + 0.12, half_m + 0.08, high_m), _of(BoatPart.CABIN))
