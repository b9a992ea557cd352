"""Lorries, buses and a motorbike with its rider, in the colours of a car palette.

Sizes are those of common classes: a rigid lorry of 12-18 t, a low-floor bus of 12 m, a coach of 12.2 m. All keep within
directive 96/53/EC: 2.55 m wide, 4.00 m high, 12.00 m long (13.50 m for buses).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from sim.meshes.car_parts import Swatch, add_axle, colour
from sim.meshes.facets import Facets

_Plan = Sequence[tuple[float, float]]
_Level = tuple[float, float]
"""Height, and how far the outline lies inside the plan, metres."""


def add_lorry(facets: Facets) -> None:
    """Add a box lorry: 8.4 x 2.5 x 3.6 m, a cab with a deflector before a box with ribs."""
    _add_chassis(facets, -4.15, 3.9)
    _add_cab(facets, 2.45, 4.2, 2.75)
    _loft_up(facets, _plan(2.40, 3.45, 0.95), [(2.68, 0.0), (3.38, 0.28)], _all(Swatch.PAINT), Swatch.LIGHT_PAINT)
    low, high, half = 1.05, 3.6, 1.25
    _loft_up(
        facets,
        [(2.25, -half), (2.25, half), (-4.2, half), (-4.2, -half)],
        [(low, 0.0), (1.22, 0.0), (high - 0.06, 0.0), (high, 0.05)],
        lambda segment, side: Swatch.CHROME if segment != 1 else Swatch.ALUMINIUM if side == 2 else Swatch.BOX,
        Swatch.BOX,
    )
    for x in np.arange(-3.4, 2.0, 1.05):
        facets.box((x - 0.04, -half + 0.12, high), (x + 0.04, half - 0.12, high + 0.02), colour(Swatch.ALUMINIUM))
    for side in (-1.0, 1.0):
        _add_box(facets, (-3.6, 1.7), side * 1.255, 0.015, (1.75, 2.75), Swatch.STRIPE)
    _add_tail(facets, -4.2, 0.72)
    _add_axles(facets, (3.05, -2.35), 0.48, 1.2)


def add_flatbed(facets: Facets) -> None:
    """Add a dropside lorry: 8.0 x 2.5 x 2.8 m, its deck half full."""
    _add_chassis(facets, -3.95, 3.7)
    _add_cab(facets, 2.3, 4.0, 2.75)
    rear, front, half, deck, rim = -4.0, 2.05, 1.25, 1.15, 1.6
    facets.box((rear, -half, 1.0), (front, half, deck), colour(Swatch.WOOD))
    for side in (-1.0, 1.0):
        _add_box(facets, (rear + 0.05, front - 0.08), side * (half - 0.03), 0.05, (deck, rim), Swatch.STRIPE)
        for x in (rear + 1.9, rear + 3.9):
            _add_box(facets, (x - 0.05, x + 0.05), side * (half - 0.03), 0.08, (deck, rim + 0.04), Swatch.ALUMINIUM)
    facets.box((rear, -half + 0.06, deck), (rear + 0.05, half - 0.06, rim), colour(Swatch.STRIPE))
    facets.box((front - 0.08, -half + 0.02, deck), (front, half - 0.02, 2.5), colour(Swatch.ALUMINIUM))
    _loft_up(facets, _plan(0.25, 1.75, 0.95), [(deck, 0.0), (2.3, 0.08)], _all(Swatch.CLOTH), Swatch.CLOTH)
    for k, x in enumerate((-3.55, -2.35, -1.15)):
        facets.box((x, -0.95, deck), (x + 1.0, 0.95, 1.75 + 0.12 * k), colour(Swatch.WOOD if k else Swatch.CHROME))
    _add_tail(facets, rear, 0.72)
    _add_axles(facets, (2.85, -2.2), 0.48, 1.2)


def add_tanker(facets: Facets) -> None:
    """Add a tank lorry of three axles: 9.2 x 2.5 x 3.4 m, with a walkway along the top of its tank."""
    _add_chassis(facets, -4.55, 4.3)
    _add_cab(facets, 2.9, 4.6, 2.8)
    rear, front, radius_y, radius_z, axis_z = -4.55, 2.7, 1.24, 0.95, 2.1
    angles = (np.arange(16) + 0.5) * (2.0 * np.pi / 16)
    stations = ((rear, 0.72), (rear + 0.3, 1.0), (-2.1, 1.0), (-1.9, 1.0), (0.4, 1.0), (0.6, 1.0), (front - 0.3, 1.0))
    rings = [
        np.column_stack([np.full(16, x), share * radius_y * np.cos(angles), axis_z + share * radius_z * np.sin(angles)])
        for x, share in (*stations, (front, 0.72))
    ]
    facets.loft(
        np.array(rings),
        lambda segment, side: colour(
            Swatch.STRIPE if segment in (2, 4) else Swatch.ALUMINIUM if segment in (0, 6) else Swatch.BOX
        ),
        colour(Swatch.BOX),
        colour(Swatch.BOX),
    )
    facets.box((rear + 0.5, -0.28, axis_z + radius_z - 0.03), (front - 0.4, 0.28, 3.12), colour(Swatch.CHROME))
    for x in (-3.4, -1.2, 1.3):
        _add_cylinder(facets, (x, 0.0), 0.26, (3.1, 3.28), Swatch.ALUMINIUM)
    for side in (-1.0, 1.0):
        _add_box(facets, (-4.4, 2.6), side * 1.17, 0.1, (0.95, 1.3), Swatch.STRIPE)
    _add_tail(facets, -4.6, 0.72)
    _add_axles(facets, (3.45, -1.75, -3.1), 0.48, 1.2)


def add_bus(facets: Facets) -> None:
    """Add a city bus: 12.0 x 2.55 x 3.1 m, windows all round, hatches and a cooling unit on a pale roof."""
    _add_bus_body(facets, 12.0, (0.32, 0.95, 1.0, 2.45, 2.78, 2.86), Swatch.PAINT, Swatch.STRIPE)
    _add_roof_gear(facets, ((-4.6, 1.6, 1.5, 0.26), (2.4, 2.2, 1.7, 0.22)), ((-1.6, 0.8), (0.6, 0.8), (4.6, 0.7)), 2.86)
    facets.box((5.94, -0.85, 2.47), (6.0, 0.85, 2.76), colour(Swatch.AMBER))
    _add_axles(facets, (3.25, -2.65), 0.48, 1.23)


def add_coach(facets: Facets) -> None:
    """Add a coach: 12.2 x 2.55 x 3.55 m, with a high floor over its luggage and dark glass."""
    _add_bus_body(facets, 12.2, (0.35, 1.45, 1.55, 2.85, 3.2, 3.3), Swatch.PAINT, Swatch.LIGHT_PAINT)
    _add_roof_gear(facets, ((-0.6, 2.6, 1.6, 0.25),), ((3.6, 0.8), (-4.2, 0.8)), 3.3)
    _add_axles(facets, (3.3, -2.75, -4.1), 0.5, 1.23)


def add_motorbike(facets: Facets) -> None:
    """Add a motorbike with its rider: 2.15 x 0.8 x 1.55 m."""
    for x in (0.74, -0.72):
        add_axle(facets, x, 0.31, 0.07)
    facets.box((-0.45, -0.13, 0.28), (0.42, 0.13, 0.62), colour(Swatch.CHROME))
    _loft_up(facets, _plan(0.05, 0.62, 0.2), [(0.6, 0.0), (0.86, 0.05), (0.92, 0.1)], _all(Swatch.PAINT), Swatch.PAINT)
    _loft_up(
        facets, _plan(-1.02, 0.05, 0.17), [(0.62, 0.02), (0.8, 0.0), (0.84, 0.04)], _all(Swatch.BLACK), Swatch.BLACK
    )
    _loft_up(facets, _plan(0.62, 0.98, 0.16), [(0.62, 0.0), (1.02, 0.06)], _all(Swatch.PAINT), Swatch.GLASS)
    facets.box((0.98, -0.09, 0.7), (1.03, 0.09, 0.86), colour(Swatch.LIGHT))
    facets.box((-1.07, -0.09, 0.68), (-1.02, 0.09, 0.78), colour(Swatch.RED))
    facets.box((0.5, -0.38, 0.98), (0.56, 0.38, 1.03), colour(Swatch.BLACK))
    _loft_up(
        facets,
        _plan(-0.42, 0.02, 0.23),
        [(0.82, 0.02), (1.12, 0.03), (1.3, 0.0), (1.36, 0.08)],
        _all(Swatch.CLOTH),
        Swatch.CLOTH,
    )
    for side in (-1.0, 1.0):
        _add_limb(facets, (-0.15, side * 0.24, 1.26), (0.5, side * 0.33, 1.02), 0.06, Swatch.CLOTH)
        _add_limb(facets, (-0.25, side * 0.14, 0.86), (0.24, side * 0.24, 0.72), 0.09, Swatch.CLOTH)
        _add_limb(facets, (0.24, side * 0.24, 0.72), (-0.1, side * 0.22, 0.32), 0.07, Swatch.BLACK)
    _add_helmet(facets, (-0.08, 1.42))


def _plan(rear: float, front: float, half_width: float, cut: float = 0.12) -> list[tuple[float, float]]:
    """Return an outline with cut corners, counter-clockwise from the right end of its front."""
    cut = min(cut, 0.4 * half_width, 0.4 * (front - rear))
    left = [(front, half_width - cut), (front - cut, half_width), (rear + cut, half_width), (rear, half_width - cut)]
    return [(front, -half_width + cut), *left, *((x, -y) for x, y in left[:0:-1])]


def _all(swatch: Swatch) -> Callable[[int, int], Swatch]:
    return lambda segment, side: swatch


def _loft_up(
    facets: Facets,
    plan: _Plan,
    levels: Sequence[_Level],
    side_swatch: Callable[[int, int], Swatch],
    top: Swatch,
    rakes: Sequence[float] | None = None,
) -> None:
    """Add a closed body over a plan, upwards.

    Args:
        side_swatch: colour of the side that begins at a corner of the plan, between two levels.
        rakes: how far the front is behind the plan's at each level, on the foremost corners.
    """
    outline = np.array(plan)
    low, high = outline.min(axis=0), outline.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    rings = []
    for k, (z, inset) in enumerate(levels):
        ring: NDArray[np.float64] = middle + (outline - middle) * (1.0 - inset / half)
        if rakes is not None:
            ring[outline[:, 0] > high[0] - 0.3, 0] -= rakes[k]
        rings.append(np.column_stack([ring, np.full(len(ring), z)]))
    facets.loft(
        np.array(rings), lambda segment, side: colour(side_swatch(segment, side)), colour(Swatch.BLACK), colour(top)
    )


def _add_box(
    facets: Facets, x: tuple[float, float], y: float, thickness: float, z: tuple[float, float], swatch: Swatch
) -> None:
    """Add an upright board along the vehicle at a distance ``y`` from its axis."""
    facets.box((x[0], y - 0.5 * thickness, z[0]), (x[1], y + 0.5 * thickness, z[1]), colour(swatch))


def _add_chassis(facets: Facets, rear: float, front: float) -> None:
    facets.box((rear, -0.45, 0.6), (front, 0.45, 0.98), colour(Swatch.BLACK))
    for side in (-1.0, 1.0):
        low, high = sorted((side * 0.5, side * 1.1))
        facets.box((0.1, low, 0.45), (1.5, high, 0.95), colour(Swatch.ALUMINIUM))


def _add_cab(facets: Facets, rear: float, front: float, top: float) -> None:
    """Add a cab over its engine: bumper, grille, a raked windscreen, a roof, lamps and mirrors."""
    half = 1.22
    plan = _plan(rear, front, half, 0.16)
    # Sides of the plan: 0 the front, 1 and 7 its corners, 2 and 6 the flanks, 4 the back.
    glass = {0: Swatch.GLASS, 1: Swatch.GLASS, 7: Swatch.GLASS, 2: Swatch.GLASS, 6: Swatch.GLASS}

    def side(segment: int, at: int) -> Swatch:
        if segment == 0:
            return Swatch.BLACK if at == 0 else Swatch.DARK_PAINT
        return glass.get(at, Swatch.PAINT) if segment == 2 else Swatch.PAINT

    levels = [(0.38, 0.0), (0.85, 0.0), (1.6, 0.0), (top - 0.42, 0.04), (top - 0.12, 0.06), (top, 0.16)]
    _loft_up(facets, plan, levels, side, Swatch.LIGHT_PAINT, rakes=(0.0, 0.0, 0.02, 0.16, 0.24, 0.34))
    for sign in (-1.0, 1.0):
        low, high = sorted((sign * 0.72, sign * 1.04))
        facets.box((front - 0.05, low, 0.88), (front + 0.02, high, 1.08), colour(Swatch.LIGHT))
        low, high = sorted((sign * (half - 0.05), sign * (half + 0.16)))
        facets.box((front - 0.42, low, 1.75), (front - 0.32, high, 2.3), colour(Swatch.BLACK))


def _add_tail(facets: Facets, rear: float, height: float) -> None:
    """Add the rear lamps and the bumper bar."""
    facets.box((rear, -1.1, height - 0.12), (rear + 0.1, 1.1, height + 0.04), colour(Swatch.CHROME))
    for side in (-1.0, 1.0):
        low, high = sorted((side * 0.78, side * 1.16))
        facets.box((rear - 0.02, low, height + 0.06), (rear + 0.1, high, height + 0.24), colour(Swatch.RED))


def _add_axles(facets: Facets, places: Sequence[float], radius: float, half_width: float) -> None:
    for x in places:
        add_axle(facets, x, radius, half_width, 12)


def _add_bus_body(
    facets: Facets, length: float, heights: tuple[float, float, float, float, float, float], low: Swatch, high: Swatch
) -> None:
    """Add the body of a bus with a band of windows between pillars.

    Args:
        heights: of the floor's edge, the skirt's top, the windows' lower and upper edge, the roof's edge and the roof.
        low, high: colours below and above the windows.
    """
    half, half_width, cut = 0.5 * length, 1.275, 0.2
    # Panes and pillars alternate along either side.
    panes = np.linspace(half - cut, -half + cut, 8)
    along = [each for pane in panes[1:-1] for each in (pane + 0.06, pane - 0.06)]
    left = [(half, half_width - cut), (half - cut, half_width), *((x, half_width) for x in along)]
    left += [(-half + cut, half_width), (-half, half_width - cut)]
    plan = [(half, -half_width + cut), *left, *((x, -y) for x, y in left[:0:-1])]
    back = len(left)

    def side(segment: int, at: int) -> Swatch:
        # Sides of the plan: 0 the front, 1 its corner, then panes and pillars, then the rear corner and the back; and
        # so again on the right.
        at = min(at, 2 * back - at)
        if segment == 2:
            is_pane = at <= 1 or at == back or (at < back - 1 and at % 2 == 0)
            return Swatch.GLASS if is_pane else Swatch.BLACK if at < back - 1 else low
        if segment in (1, 3):
            return Swatch.BLACK if at in (0, back) else high
        return low

    skirt, belt, sill, glass_top, edge, roof = heights
    levels = [(skirt, 0.0), (belt, 0.0), (sill, 0.0), (glass_top, 0.03), (edge, 0.06), (roof, 0.2)]
    _loft_up(facets, plan, levels, side, Swatch.ROOF, rakes=(0.05, 0.0, 0.0, 0.06, 0.1, 0.2))
    for sign in (-1.0, 1.0):
        a, b = sorted((sign * 0.7, sign * 1.05))
        facets.box((half - 0.04, a, skirt + 0.2), (half + 0.015, b, skirt + 0.42), colour(Swatch.LIGHT))
        facets.box((-half - 0.015, a, skirt + 0.35), (-half + 0.06, b, skirt + 0.85), colour(Swatch.RED))
        a, b = sorted((sign * 1.2, sign * 1.45))
        facets.box((half - 0.2, a, glass_top - 0.55), (half - 0.08, b, glass_top - 0.1), colour(Swatch.BLACK))


def _add_roof_gear(
    facets: Facets,
    units: Sequence[tuple[float, float, float, float]],
    hatches: Sequence[tuple[float, float]],
    roof: float,
) -> None:
    """Add units (middle, length, width, height) and hatches (middle, side) to a roof."""
    for x, length, width, height in units:
        plan = _plan(x - 0.5 * length, x + 0.5 * length, 0.5 * width)
        _loft_up(facets, plan, [(roof - 0.02, 0.0), (roof + height, 0.08)], _all(Swatch.CHROME), Swatch.ALUMINIUM)
    for x, side in hatches:
        half = 0.5 * side
        facets.box((x - half, -half, roof - 0.02), (x + half, half, roof + 0.07), colour(Swatch.CHROME))


def _add_cylinder(
    facets: Facets, centre: tuple[float, float], radius: float, z: tuple[float, float], swatch: Swatch
) -> None:
    angles = np.arange(10) * (2.0 * np.pi / 10)
    circle = np.array(centre) + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    _loft_up(facets, [(x, y) for x, y in circle.tolist()], [(z[0], 0.0), (z[1], 0.0)], _all(swatch), swatch)


def _add_limb(
    facets: Facets, start: tuple[float, float, float], end: tuple[float, float, float], half_m: float, swatch: Swatch
) -> None:
    """Add a square bar between two points."""
    ahead = np.subtract(end, start)
    ahead /= np.linalg.norm(ahead)
    across = np.cross((0.0, 0.0, 1.0), ahead)
    across /= np.linalg.norm(across)
    up = np.cross(ahead, across)
    corners = [half_m * (a * across + b * up) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    # Counter-clockwise seen from the end: across × up points ahead.
    rings = np.array([[np.add(point, corner) for corner in corners] for point in (start, end)])
    facets.loft(rings, lambda segment, side: colour(swatch), colour(swatch), colour(swatch))


def _add_helmet(facets: Facets, centre_xz: tuple[float, float]) -> None:
    x, z = centre_xz
    angles = np.arange(8) * (2.0 * np.pi / 8)
    rings = [
        np.column_stack([x + r * np.cos(angles), 0.9 * r * np.sin(angles), np.full(8, z + h)])
        for r, h in ((0.09, -0.12), (0.14, -0.04), (0.14, 0.03), (0.1, 0.1), (0.05, 0.13))
    ]
    facets.loft(
        np.array(rings),
        lambda segment, side: colour(Swatch.GLASS if segment == 1 and side in (0, 7) else Swatch.HELMET),
        colour(Swatch.BLACK),
        colour(Swatch.HELMET),
    )
