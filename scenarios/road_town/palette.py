"""First, plain version, so that episodes can be lived through; the town helper replaces it."""

from __future__ import annotations

import numpy as np

PAINTS = [
    (200, 30, 30),
    (30, 60, 160),
    (235, 235, 235),
    (25, 25, 28),
    (140, 144, 150),
    (90, 95, 100),
    (20, 110, 60),
    (220, 180, 40),
    (120, 60, 30),
    (60, 140, 190),
]


def draw_paint(rng):
    return PAINTS[int(rng.integers(len(PAINTS)))]
