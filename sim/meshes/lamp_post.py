"""Street lamps: a post, an arm over the street, and a flat head that shines down."""

from __future__ import annotations

from functools import cache

import numpy as np

from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv

HEIGHT_M, REACH_M = 8.0, 1.6
"""Height of the lamp above the ground, and its distance from the post, ahead of it."""
HEAD_M = (0.75, 0.34)
"""Length and width of the head."""
_STEEL, _GLASS = swatch_uv(0, 2), swatch_uv(1, 2)


@cache
def lamp_post() -> TexturedMesh:
    """Return a street lamp on the origin, its arm along +x; about 40 triangles."""
    facets = Facets()
    angles = np.arange(6) * (2.0 * np.pi / 6)
    outline = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [
        np.column_stack([outline * radius, np.full(6, height)]) for radius, height in ((0.1, 0.0), (0.055, HEIGHT_M))
    ]
    facets.loft(rings, lambda segment, side: _STEEL, None, _STEEL)
    length, width = HEAD_M
    facets.box((0.0, -0.035, HEIGHT_M - 0.04), (REACH_M - 0.4 * length, 0.035, HEIGHT_M + 0.04), _STEEL)
    low = (REACH_M - 0.5 * length, -0.5 * width, HEIGHT_M - 0.02)
    facets.box(low, (REACH_M + 0.5 * length, 0.5 * width, HEIGHT_M + 0.1), _STEEL)
    facets.box(
        (low[0] + 0.08, low[1] + 0.05, HEIGHT_M - 0.06),
        (REACH_M + 0.5 * length - 0.08, 0.5 * width - 0.05, HEIGHT_M - 0.015),
        _GLASS,
    )
    return facets.mesh(palette([(104, 108, 110), (214, 214, 206)]))
