"""Colours of a town, sRGB 0-255: cars, walls, roofs and grounds."""

from __future__ import annotations

import numpy as np

Rgb = tuple[int, int, int]

PAINTS: dict[str, tuple[Rgb, float]] = {
    "white": ((232, 232, 228), 0.20),
    "black": ((26, 26, 29), 0.16),
    "grey": ((92, 95, 99), 0.14),
    "silver": ((164, 168, 172), 0.11),
    "blue": ((28, 62, 150), 0.11),
    "red": ((176, 24, 26), 0.10),
    "green": ((24, 92, 58), 0.04),
    "yellow": ((222, 176, 32), 0.04),
    "orange": ((208, 92, 24), 0.03),
    "brown": ((98, 64, 42), 0.03),
    "sky": ((92, 158, 200), 0.04),
}
"""Car paints and their shares: roughly those of new cars in Europe, with more colours than today."""

WALLS: tuple[Rgb, ...] = (
    (214, 204, 186),
    (196, 180, 152),
    (226, 222, 212),
    (178, 146, 118),
    (160, 98, 76),
    (188, 190, 188),
    (206, 184, 136),
)
ROOFS: tuple[Rgb, ...] = (
    (146, 88, 72),
    (128, 74, 60),
    (104, 72, 62),
    (84, 84, 88),
    (64, 66, 72),
    (128, 108, 92),
    (158, 104, 80),
    (98, 94, 90),
)
FLAT_ROOFS: tuple[Rgb, ...] = ((128, 128, 124), (104, 106, 106), (150, 146, 136), (88, 90, 94), (166, 164, 158))
LAWNS: tuple[Rgb, ...] = ((88, 106, 64), (98, 114, 68), (80, 96, 60), (110, 116, 74), (94, 104, 70))
YARDS: tuple[Rgb, ...] = ((150, 140, 124), (132, 126, 116), (164, 152, 130), (118, 104, 84))
CROPS: tuple[Rgb, ...] = ((122, 104, 78), (134, 128, 72), (84, 104, 50), (146, 136, 92), (104, 116, 62))
BEDS: tuple[Rgb, ...] = ((96, 78, 58), (72, 88, 48), (120, 96, 88), (142, 84, 92), (150, 132, 70), (84, 66, 50))
HEDGES: tuple[Rgb, ...] = ((58, 78, 42), (66, 84, 46), (48, 68, 38), (128, 118, 100), (104, 88, 70))
PATHS: tuple[Rgb, ...] = ((158, 150, 134), (142, 132, 114), (128, 126, 122), (150, 128, 112), (168, 162, 150))
MEADOW: Rgb = (94, 108, 62)
PAVEMENT: Rgb = (156, 152, 144)
KERB: Rgb = (150, 148, 142)
ASPHALT: tuple[Rgb, ...] = ((84, 85, 88), (92, 92, 93), (76, 78, 82))
MARKING: Rgb = (214, 214, 208)


def draw_paint(rng: np.random.Generator) -> Rgb:
    """Draw a car paint by its share."""
    shares = np.array([share for _, share in PAINTS.values()])
    paints = [rgb for rgb, _ in PAINTS.values()]
    return paints[int(rng.choice(len(paints), p=shares / shares.sum()))]


def pick(colours: tuple[Rgb, ...], rng: np.random.Generator, spread: float = 8.0) -> Rgb:
    """Draw one of ``colours`` and vary it a little, mostly in lightness."""
    rgb = np.array(colours[int(rng.integers(len(colours)))], dtype=float)
    rgb += rng.normal(0.0, spread) + rng.normal(0.0, 0.3 * spread, 3)
    r, g, b = np.clip(rgb, 8, 247).astype(int).tolist()
    return r, g, b
