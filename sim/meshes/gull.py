"""A gull as a thermal camera sees it: warm body, cooler wings."""

from __future__ import annotations

from enum import IntEnum
from functools import cache

import numpy as np

from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, swatch_uv
from sim.meshes.thermal_paint import parts_palette


class GullPart(IntEnum):
    """Parts of a gull."""

    BODY = 0
    WING = 1
    HEAD = 2


_STATIONS = (
    (-0.22, 0.01, 0.06),
    (-0.1, 0.05, 0.05),
    (0.03, 0.075, 0.05),
    (0.14, 0.05, 0.08),
    (0.18, 0.035, 0.1),
    (0.25, 0.01, 0.1),
)
"""x, radius and height of the middle of each cross section, metres."""
_WING_STATIONS = ((0.02, 0.04, 0.12, 0.17), (0.05, 0.35, 0.19, 0.16), (-0.04, 0.65, 0.14, 0.04))
"""x, y and z of the middle of each section of a wing, and its chord, metres."""


@cache
def gull(flies: bool) -> TexturedMesh:
    """Return a gull, x ahead: standing or swimming with folded wings, its lowest point at z = 0, or gliding.

    0.47 m long, 1.3 m from wing to wing.
    """
    facets = Facets()
    angles = np.arange(6) * (2.0 * np.pi / 6)
    rings = [
        np.column_stack([np.full(6, x), radius * np.cos(angles), radius * np.sin(angles) + height + 0.03])
        for x, radius, height in _STATIONS
    ]
    # Seen from ahead, where the following rings lie, y grows to the right: this way round is counter-clockwise.
    body, head = swatch_uv(GullPart.BODY, 3), swatch_uv(GullPart.HEAD, 3)
    facets.loft(rings, lambda segment, side: head if segment >= 3 else body, body, head)
    if flies:
        wing = swatch_uv(GullPart.WING, 3)
        for side in (-1, 1):
            section = np.array([(0.5, 0.0), (0.0, 0.012), (-0.5, 0.0), (0.0, -0.012)])[::-side]
            stations = [
                [(x + chord * along, side * y, z + up) for along, up in section] for x, y, z, chord in _WING_STATIONS
            ]
            facets.loft(stations, lambda segment, k: wing, wing, wing)
    return facets.mesh(parts_palette(len(GullPart)))
