"""Parts of cars: bodies, cabins, wheels, mirrors, in the colours of a car palette."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from sim.meshes.facets import Facets, swatch_uv


class Swatch(IntEnum):
    """Places of a car palette."""

    PAINT = 0
    DARK_PAINT = 1
    LIGHT_PAINT = 2
    GLASS = 3
    BLACK = 4
    LIGHT = 5
    RED = 6
    CHROME = 7
    STRIPE = 8
    BOX = 9
    ROOF = 10
    ALUMINIUM = 11
    WOOD = 12
    AMBER = 13
    CLOTH = 14
    HELMET = 15


def colour(swatch: Swatch) -> tuple[float, float]:
    """Return the texture coordinates of a swatch."""
    return swatch_uv(swatch, len(Swatch))


@dataclass(frozen=True)
class BodyShape:
    """The painted lower part of a car. Lengths in metres, x ahead from the middle of the car.

    Attributes:
        length, width: over all.
        sill: height of the lower edge.
        belt: height at which the windows begin.
        nose, tail: heights of the bonnet's front edge and of the boot (or the bed). A tail far below the belt
            makes a step behind the cabin.
        bonnet_end, boot_start: x where the bonnet meets the windscreen, and the boot the rear window.
        wheelbase, wheel_radius: of the axles, which lie evenly about ``axle_centre``.
    """

    length: float
    width: float
    sill: float
    belt: float
    nose: float
    tail: float
    bonnet_end: float
    boot_start: float
    wheelbase: float
    wheel_radius: float
    axle_centre: float = 0.05


@dataclass(frozen=True)
class CabinShape:
    """Windows and roof. Lengths in metres.

    Attributes:
        front_base, front_top: x of the windscreen's lower and upper edge.
        rear_base, rear_top: x of the rear window's lower and upper edge.
        base, top: heights of the belt line and of the roof.
        width: at the belt line; the roof is narrower by ``lean`` on either side.
        pillars: (start, end) of the painted parts of the sides, as fractions from front to rear.
        rear_glass: False where the rear is of metal.
    """

    front_base: float
    front_top: float
    rear_base: float
    rear_top: float
    base: float
    top: float
    width: float
    lean: float
    pillars: tuple[tuple[float, float], ...]
    rear_glass: bool = True


_SECTION = np.array(
    # (share of the half width, height: 0 sill, 1 deck), the right-hand side from below
    [(0.90, 0.0), (0.985, 0.22), (1.0, 0.55), (0.96, 0.86), (0.80, 1.0)]
)


def add_body(facets: Facets, shape: BodyShape) -> None:
    """Add the lower body: a closed loft from tail to nose, rounded in plan, with lamps in its corners."""
    half = 0.5 * shape.length
    stations = [
        # x, share of the width, rise of the sill, deck height
        (-half, 0.78, 0.16, shape.tail - 0.13),
        (-half + 0.07, 0.90, 0.06, shape.tail - 0.02),
        (-half + 0.30, 0.98, 0.0, shape.tail),
        (shape.boot_start, 1.0, 0.0, shape.tail),
        *([(shape.boot_start + 0.03, 1.0, 0.0, shape.belt)] if shape.tail < shape.belt - 0.1 else []),
        (shape.bonnet_end, 1.0, 0.0, shape.belt),
        (0.45 * shape.bonnet_end + 0.55 * half, 0.985, 0.0, 0.45 * shape.belt + 0.55 * shape.nose + 0.03),
        (half - 0.28, 0.94, 0.0, shape.nose),
        (half - 0.08, 0.84, 0.04, shape.nose - 0.08),
        (half, 0.66, 0.14, shape.nose - 0.24),
    ]
    rings = np.array([_section(shape, *station) for station in stations])
    last = len(stations) - 2

    def side_colour(segment: int, side: int) -> tuple[float, float]:
        right = min(side, 8 - side) if side < 9 else -1
        if right == -1:
            return colour(Swatch.BLACK)
        if right == 0:
            return colour(Swatch.BLACK if 0 < segment < last else Swatch.DARK_PAINT)
        if segment == last - 1 and right == 3:
            return colour(Swatch.LIGHT)
        if segment <= 1 and right in (2, 3):
            return colour(Swatch.RED)
        return colour(Swatch.PAINT)

    facets.loft(rings, side_colour, colour(Swatch.DARK_PAINT), colour(Swatch.BLACK))


def _section(shape: BodyShape, x: float, width_share: float, sill_rise: float, deck: float) -> NDArray[np.float64]:
    """Return a ring (10, 3): up the left side, over, and down the right side, seen from ahead."""
    sill = shape.sill + sill_rise
    y = _SECTION[:, 0] * 0.5 * shape.width * width_share
    z = sill + _SECTION[:, 1] * (deck - sill)
    left = np.column_stack([np.full(5, x), y, z])
    right = np.column_stack([np.full(5, x), -y, z])
    return np.concatenate([left, right[::-1]])


def add_cabin(facets: Facets, shape: CabinShape) -> None:
    """Add the windows and the roof: a closed loft upwards, its front and rear bowed in plan."""
    base = _outline(shape, shape.front_base, shape.rear_base, 0.5 * shape.width)
    top = _outline(shape, shape.front_top, shape.rear_top, 0.5 * shape.width - shape.lean)
    middle = 0.5 * (shape.front_top + shape.rear_top)
    inner = (top - (middle, 0.0)) * (0.93, 0.88) + (middle, 0.0)
    rings = np.array(
        [
            np.column_stack([outline, np.full(len(outline), height)])
            for outline, height in ((base, shape.base - 0.06), (top, shape.top - 0.05), (inner, shape.top))
        ]
    )
    window = _window_colours(shape)

    def side_colour(segment: int, side: int) -> tuple[float, float]:
        return colour(window[side] if segment == 0 else Swatch.PAINT)

    facets.loft(rings, side_colour, colour(Swatch.BLACK), colour(Swatch.LIGHT_PAINT))


def _cuts(shape: CabinShape) -> list[float]:
    return [0.0, *(edge for pillar in shape.pillars for edge in pillar), 1.0]


def _outline(shape: CabinShape, front: float, rear: float, half_width: float) -> NDArray[np.float64]:
    """Return a plan (n, 2), counter-clockwise from the right end of the windscreen's middle part."""
    bow = min(0.14, 0.12 * (front - rear))
    side_x = [front - bow + cut * (rear + bow - front + bow) for cut in _cuts(shape)]
    left = [(front, 0.62 * half_width), *((x, half_width) for x in side_x), (rear, 0.68 * half_width)]
    return np.array([(x, -y) for x, y in left[:1]] + left + [(x, -y) for x, y in left[:0:-1]])


def _window_colours(shape: CabinShape) -> list[Swatch]:
    """Return the colour of every side of ``_outline``: windscreen, left side, rear, right side."""
    cuts = _cuts(shape)
    side = [Swatch.GLASS if k % 2 == 0 else Swatch.PAINT for k in range(len(cuts) - 1)]
    rear = Swatch.GLASS if shape.rear_glass else Swatch.PAINT
    left = [Swatch.GLASS, *side, rear]
    return [Swatch.GLASS, *left, rear, *left[::-1]]


def add_wheels(facets: Facets, shape: BodyShape) -> None:
    """Add two axles, each a cylinder across the car whose ends are the wheels."""
    for x in (shape.axle_centre + 0.5 * shape.wheelbase, shape.axle_centre - 0.5 * shape.wheelbase):
        add_axle(facets, x, shape.wheel_radius, 0.5 * shape.width * 0.985 + 0.012)


def add_axle(facets: Facets, x: float, radius: float, half_width: float, corners: int = 8) -> None:
    """Add one axle: a prism of ``corners`` sides across the vehicle."""
    angles = (np.arange(corners) + 0.5) * (2.0 * np.pi / corners)
    rings = []
    for y, scale in ((-half_width, 0.55), (-half_width, 1.0), (half_width, 1.0), (half_width, 0.55)):
        # Counter-clockwise seen from the left, where y grows to.
        circle = np.column_stack([np.sin(angles), np.full(corners, y), np.cos(angles)]) * (scale, 1.0, scale)
        rings.append(circle * (radius, 1.0, radius) + (x, 0.0, radius))
    facets.loft(rings, lambda segment, side: colour(Swatch.BLACK), colour(Swatch.CHROME), colour(Swatch.CHROME))


def add_mirrors(facets: Facets, x: float, height: float, half_width: float) -> None:
    """Add the two wing mirrors, which stand out from the body by 7 cm."""
    for side in (-1.0, 1.0):
        inner, outer = side * (half_width - 0.06), side * (half_width + 0.07)
        facets.box(
            (x - 0.06, min(inner, outer), height - 0.07),
            (x + 0.06, max(inner, outer), height + 0.07),
            colour(Swatch.DARK_PAINT),
        )
