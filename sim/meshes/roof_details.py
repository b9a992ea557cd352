"""Things on roofs: chimneys, roof lights, solar panels, dormers, boxes on flat roofs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.meshes.facade import HousePart, plain_uv
from sim.meshes.facets import Facets


@dataclass(frozen=True)
class Slopes:
    """Two roof slopes that fall from a ridge along x to both sides.

    Attributes:
        half_ridge_m: half the length of the ridge.
        half_width_m: from the ridge to the eaves, in plan.
        ridge_m: height of the ridge.
        fall: metres down for each metre away from the ridge.
    """

    half_ridge_m: float
    half_width_m: float
    ridge_m: float
    fall: float

    def height_m(self, y_m: float) -> float:
        """Return the height of the slopes at a distance from the ridge."""
        return self.ridge_m - self.fall * abs(y_m)


def add_slope_details(facets: Facets, slopes: Slopes, rng: np.random.Generator) -> None:
    """Add a chimney, and on either slope dormers, roof lights, solar panels or nothing."""
    _add_chimney(facets, slopes, rng)
    room_for_dormers = slopes.half_ridge_m > 2.5 and slopes.fall > 0.5 and slopes.half_width_m > 3.0
    for side in (-1.0, 1.0):
        kind = rng.random()
        if kind < 0.3 and room_for_dormers:
            _add_dormers(facets, slopes, side, int(rng.integers(1, 3)))
        elif kind < 0.45 and slopes.half_ridge_m > 2.0:
            half = (rng.uniform(0.4, 0.8) * slopes.half_ridge_m, 0.25 * slopes.half_width_m)
            _add_slab(facets, slopes, (0.0, 0.5 * side * slopes.half_width_m), half, HousePart.SOLAR)
        elif kind < 0.8:
            away = side * rng.uniform(0.35, 0.6) * slopes.half_width_m
            count = int(rng.integers(1, 4)) if slopes.half_ridge_m > 1.5 else 1
            for k in range(count):
                along = 0.7 * slopes.half_ridge_m * (k - 0.5 * (count - 1))
                _add_slab(facets, slopes, (along, away), (0.4, 0.5), HousePart.GLASS)


def _add_chimney(facets: Facets, slopes: Slopes, rng: np.random.Generator) -> None:
    x = rng.uniform(-0.7, 0.7) * slopes.half_ridge_m
    y = rng.uniform(0.3, 0.6) * float(rng.choice([-1.0, 1.0]))
    foot = slopes.height_m(abs(y) + 0.35) - 0.1
    facets.box((x - 0.4, y - 0.35, foot), (x + 0.4, y + 0.35, slopes.ridge_m + 0.7), plain_uv(HousePart.BRICK))


def _add_slab(
    facets: Facets, slopes: Slopes, centre_m: tuple[float, float], half_m: tuple[float, float], kind: HousePart
) -> None:
    """Add a thin closed slab that lies on a slope."""
    (x, y), (a, b) = centre_m, half_m
    outline = [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]
    uv = plain_uv(kind)
    rings = [[(*p, slopes.height_m(p[1]) + lift) for p in outline] for lift in (-0.05, 0.08)]
    facets.loft(rings, lambda segment, side: uv, uv, uv)


def _add_dormers(facets: Facets, slopes: Slopes, side: float, count: int) -> None:
    """Add dormers: wedges with a glazed front and a flat roof that runs back into the slope."""
    half = 0.8
    front, top = 0.72 * slopes.half_width_m, slopes.height_m(0.72 * slopes.half_width_m) + 1.3
    back = (slopes.ridge_m - top) / slopes.fall - 0.1
    # In the plane across the ridge: foot and head of the front, and where the roof meets the slope.
    profile = [(front, slopes.height_m(front) - 0.1), (front, top), (back, top)]
    colours = (HousePart.GLASS, HousePart.DARK, HousePart.DARK)
    light = plain_uv(HousePart.LIGHT)
    for k in range(count):
        x = (k - 0.5 * (count - 1)) * 1.1 * slopes.half_ridge_m
        # The two sides are mirror images: the order of the ends keeps the faces turned out.
        ends = [[(x + side * along, side * y, z) for y, z in profile] for along in (-half, half)]
        facets.loft(ends, lambda segment, edge: plain_uv(colours[edge]), light, light)


def add_deck_details(facets: Facets, half_deck_m: tuple[float, float], deck_m: float, rng: np.random.Generator) -> None:
    """Add boxes on a flat roof: lift house, air conditioning, roof lights. Small decks stay empty.

    Args:
        half_deck_m: (x, y) from the middle to the parapet.
        deck_m: height of the deck.
    """
    room = np.array(half_deck_m) - 1.3
    if (room < 0.3).any():
        return
    kinds = (HousePart.METAL, HousePart.METAL, HousePart.LIGHT, HousePart.GLASS, HousePart.BRICK)
    for _ in range(int(rng.integers(3, 6))):
        kind = kinds[int(rng.integers(len(kinds)))]
        half = rng.uniform((0.4, 0.4), (1.1, 0.9))
        height = 0.25 if kind == HousePart.GLASS else rng.uniform(0.5, 1.3)
        x, y = rng.uniform(-room, room)
        low, high = (x - half[0], y - half[1], deck_m - 0.02), (x + half[0], y + half[1], deck_m + height)
        facets.box(low, high, plain_uv(kind))
