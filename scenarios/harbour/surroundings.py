"""What a drawn harbour has beside every harbour's things: wings, containers, cranes, shut ends, far shores."""

from __future__ import annotations

import numpy as np

from scenarios.harbour.layout import COPING_M, Goods, Site, Wing
from scenarios.harbour.scenery import (
    GROUND_VIEW,
    OPENINGS,
    WALL_BANDS,
    Surface,
    add,
    at,
    quay_wall,
    slabs,
)
from sim.meshes.facets import Facets, swatch_uv
from sim.meshes.quayside import CONTAINER_M, CRANE_PARTS, container, portal_crane, skyline
from sim.meshes.shed import Opening, ShedPart, level_plate, shed
from sim.meshes.thermal_paint import blotches, parts_palette, varied
from sim.world import World

_SHORE_M = 430.0
_HILLS_M = 1300.0
_GOODS = ("timber", "painted steel", "dark paint", "white paint", "rope", "canvas", "rubber")
_PAINTS = ("painted steel", "dark paint", "white paint")


def add_surroundings(world: World, site: Site, rng: np.random.Generator) -> list[Surface]:
    """Add all of it."""
    surfaces = [each for wing in site.wings for each in _wing(world, site, wing, rng)]
    surfaces += _containers(world, site, rng)
    surfaces += _cranes(world, site, rng)
    surfaces.append(_goods(world, site, rng))
    for side, y_m in site.shut_y_m.items():
        surfaces += _shut(world, site, side, y_m, rng)
    return surfaces + _far_shore(world, site, rng)


def _wing(world: World, site: Site, wing: Wing, rng: np.random.Generator) -> list[Surface]:
    """Add a wing: its walls, its ground and the stones along its edges."""
    x0, x1, y0, y1 = wing.tip_x_m, site.wall_x_m, wing.low_y_m, wing.high_y_m
    granite = ("granite",) * (WALL_BANDS + 1)
    surfaces = [
        add(world, quay_wall(left, right, rng), "wall", "land", granite, 0.5)
        for left, right in (((x0, y0), (x1, y0)), ((x0, y1), (x0, y0)), ((x1, y1), (x0, y1)))
    ]
    texels = 6.0
    k = slabs((round((y1 - y0) * texels), round((x1 - x0) * texels)), texels, 5.0, 0.5, rng)
    edge = round(COPING_M * texels)
    k[:edge] += 0.6
    k[-edge:] += 0.6
    k[:, :edge] += 0.6
    ground = level_plate((x0, y0), (x1 + COPING_M, y1), 0.001, varied(0, k), (6, 6))
    return [*surfaces, add(world, ground, "wing", "land", ("concrete",), GROUND_VIEW)]


def _containers(world: World, site: Site, rng: np.random.Generator) -> list[Surface]:
    """Add stacks beside where people go, on the apron, before the sheds and on wide wings."""
    surfaces = []
    _, width, height = CONTAINER_M
    for _ in range(int(rng.integers(0, 5))):
        way = float(rng.choice([-1.0, 1.0]))
        y = way * (site.walks_y_m + rng.uniform(4.0, 30.0))
        x = float(rng.choice([rng.uniform(site.wall_x_m + 8.0, site.apron_end_m - 6.0), site.shed_x_m - 6.5]))
        if _is_before_camera(site, x, y):
            continue
        columns, turn = int(rng.integers(1, 5)), float(rng.choice([0.0, 0.5 * np.pi])) + float(rng.normal(0.0, 0.01))
        for column in range(columns):
            for layer in range(int(rng.integers(1, 4))):
                ahead = column * (width + 0.15)
                place = at(x - ahead * np.sin(turn), y + ahead * np.cos(turn), layer * height, turn)
                paint = (str(rng.choice(_PAINTS)),)
                surfaces.append(add(world, container(rng), "container", "building", paint, 0.6, place))
    return surfaces


def _cranes(world: World, site: Site, rng: np.random.Generator) -> list[Surface]:
    """Add cranes on the apron, beside where people go, or none."""
    surfaces = []
    for _ in range(int(rng.choice(3, p=[0.45, 0.4, 0.15]))):
        crane = portal_crane(rng.uniform(7.0, 13.0), rng.uniform(9.0, 16.0), rng.uniform(-np.pi, np.pi))
        y = float(rng.choice([-1.0, 1.0])) * (site.walks_y_m + rng.uniform(8.0, 45.0))
        if _is_before_camera(site, site.wall_x_m + 7.0, y):
            continue
        surfaces.append(add(world, crane, "crane", "building", CRANE_PARTS, 0.7, at(site.wall_x_m + 7.0, y)))
    return surfaces


def _goods(world: World, site: Site, rng: np.random.Generator) -> Surface:
    """Add pallets with boxes, drums, reels, heaps of net, bins and stacks under canvas, as one body."""
    facets = Facets()
    for each in site.goods:
        # Some of each kind stay within the circle.
        half = 0.5 * each.radius_m
        for dx, dy in ((0.0, 0.0),) if each.radius_m < 1.0 else ((-half, -half), (half, -half), (half, half)):
            _pile(facets, Goods(each.x_m + dx, each.y_m + dy, 0.62), rng)
    return add(world, facets.mesh(parts_palette(len(_GOODS))), "goods", "building", _GOODS, 0.7)


def _pile(facets: Facets, place: Goods, rng: np.random.Generator) -> None:
    """Add one thing or a few on one another, turned at random."""
    timber, steel, dark, white, rope, canvas, rubber = (swatch_uv(k, len(_GOODS)) for k in range(len(_GOODS)))
    turn, radius = float(rng.uniform(0.0, 2.0 * np.pi)), place.radius_m

    def prism(sides: int, low_m: float, high_m: float, wide: tuple[float, float], uv: tuple[float, float]) -> None:
        rings = []
        for z, share in ((low_m, wide[0]), (high_m, wide[1])):
            angles = turn + np.pi / sides + np.arange(sides) * (2.0 * np.pi / sides)
            x, y = place.x_m + share * radius * np.cos(angles), place.y_m + share * radius * np.sin(angles)
            rings.append(np.column_stack([x, y, np.full(sides, z)]))
        facets.loft(rings, lambda segment, side: uv, uv, uv)

    kind = int(rng.integers(6))
    if kind == 0:
        top = float(rng.uniform(0.5, 1.4))
        prism(4, 0.0, 0.14, (1.0, 1.0), timber)
        prism(4, 0.14, top, (0.9, 0.9), (timber, white, dark)[int(rng.integers(3))])
    elif kind == 1:
        prism(8, 0.0, 0.88, (0.47, 0.47), (steel, dark, white)[int(rng.integers(3))])
    elif kind == 2:
        prism(10, 0.0, 0.1, (0.95, 0.95), timber)
        prism(10, 0.1, 0.75, (0.5, 0.5), rope)
        prism(10, 0.75, 0.85, (0.95, 0.95), timber)
    elif kind == 3:
        prism(7, 0.0, float(rng.uniform(0.3, 0.7)), (1.0, 0.45), (rope, rubber)[int(rng.integers(2))])
    elif kind == 4:
        prism(4, 0.05, 1.05, (0.85, 1.0), dark)
        prism(4, 1.05, 1.15, (1.0, 0.9), steel)
    else:
        prism(4, 0.0, float(rng.uniform(0.7, 1.3)), (1.0, 0.85), canvas)


def _is_before_camera(site: Site, x_m: float, y_m: float) -> bool:
    """Return whether something tall there would hide where people go, or stand about the camera's mast."""
    ahead_m, left_m = site.volume_axes @ (x_m - site.camera_m[0], y_m - site.camera_m[1])
    half, away_m = 0.5 * site.camera.width_px / site.camera.focal_px, float(np.hypot(*site.camera_m[:2]))
    return bool(abs(left_m) < half * max(ahead_m, 0.0) + 12.0 and -15.0 < ahead_m < 0.9 * away_m)


def _shut(world: World, site: Site, side: int, y_m: float, rng: np.random.Generator) -> list[Surface]:
    """Add the building across the quay at an end that the picture shows, and the mole across the water behind it."""
    low, high = site.wall_x_m + 1.5, site.shed_x_m + 16.0
    long, eaves = high - low, float(rng.uniform(4.5, 9.0))
    doors = np.arange(-0.5 * long + 4.0, 0.5 * long - 3.0, float(rng.uniform(5.5, 8.0)))
    openings = [Opening(ShedPart.DOOR, float(y), 3.6, 0.0, 3.4) for y in doors]
    openings += [Opening(ShedPart.GLASS, float(y) + 2.4, 1.2, 1.4, 2.6) for y in doors[:-1]]
    walls, roof = shed((long, 18.0, eaves), float(rng.uniform(1.0, 3.5)), openings, rng)
    # Its front, along y at x = 0 there, looks back along the quay.
    place = at(0.5 * (low + high), side * y_m, 0.0, side * 0.5 * np.pi)
    wall = str(rng.choice(["brick", "timber", "concrete"]))
    surfaces = [
        add(world, walls, "end shed", "building", (wall, *OPENINGS), 0.5, place),
        add(world, roof, "end roof", "building", ("roof sheet",), 1.0, place),
    ]
    facets, tip = Facets(), site.fairway_x_m[0] - 14.0
    y0, y1 = side * site.mole_y_m - 3.0, side * site.mole_y_m + 3.0
    facets.box((-_SHORE_M, y0, -6.0), (tip, y1, 3.6), swatch_uv(0, 1))
    facets.box((tip - 3.0, y0 - 1.0, -6.0), (tip + 3.0, y1 + 1.0, 4.2), swatch_uv(0, 1))
    facets.box((tip - 0.8, 0.5 * (y0 + y1) - 0.8, 4.2), (tip + 0.8, 0.5 * (y0 + y1) + 0.8, 10.0), swatch_uv(0, 1))
    mole = facets.mesh(parts_palette(1))
    return [*surfaces, add(world, mole, "mole", "land", ("granite",), 0.7)]


def _far_shore(world: World, site: Site, rng: np.random.Generator) -> list[Surface]:
    """Add the shores of the bay with houses, and hills behind them."""
    surfaces, land = [], blotches((128, 128), ((3.0, 0.9), (16.0, 1.2)), rng)
    behind = site.shed_x_m + 29.0
    shores = [((-1000.0, -1000.0), (-_SHORE_M, 1000.0))]
    shores += [((-_SHORE_M, _SHORE_M), (behind, 1000.0)), ((-_SHORE_M, -1000.0), (behind, -_SHORE_M))]
    shores += [((site.wall_x_m, site.span_m), (behind, _SHORE_M)), ((site.wall_x_m, -_SHORE_M), (behind, -site.span_m))]
    for low, high in shores:
        plate = level_plate(low, high, 0.8 if abs(low[0]) > 100.0 else 0.0, varied(0, land), (8, 8))
        surfaces.append(add(world, plate, "shore", "land", ("grass",), GROUND_VIEW))
    for _ in range(46):
        long, deep, eaves = rng.uniform(9.0, 40.0), rng.uniform(9.0, 16.0), rng.uniform(3.5, 12.0)
        panes = np.arange(-0.5 * long + 2.0, 0.5 * long - 1.5, 3.2)
        windows = [
            Opening(ShedPart.GLASS, float(y), 1.5, float(z), float(z) + 1.5)
            for y in panes
            for z in np.arange(1.0, eaves - 1.8, 3.0)
        ]
        walls, roof = shed((long, deep, eaves), float(rng.choice([0.0, 3.5])), windows, rng, texels_per_m=2.0)
        way, far, along = (
            float(rng.choice([-1.0, 1.0])),
            _SHORE_M + rng.gamma(2.0, 40.0) + 6.0,
            rng.uniform(-420.0, 60.0),
        )
        # On a shore at either end the fronts look back along the water.
        place = at(along, way * far, 0.8, way * 0.5 * np.pi)
        wall, roofing = str(rng.choice(["brick", "concrete", "timber"])), str(rng.choice(["roof felt", "roof sheet"]))
        surfaces.append(add(world, walls, "far house", "building", (wall, *OPENINGS), 0.4, place))
        surfaces.append(add(world, roof, "far roof", "building", (roofing,), 0.9, place))
    count = 96
    turns = np.arange(count) * (2.0 * np.pi / count)
    heights = 22.0 + sum(
        rng.uniform(2.0, 11.0) / wave**0.5 * np.cos(wave * turns + rng.uniform(0.0, 2.0 * np.pi))
        for wave in range(2, 15)
    )
    hills = skyline(_HILLS_M, np.maximum(heights, 5.0), -8.0)
    surfaces.append(add(world, hills, "hills", "land", ("grass",), 0.5))
    return surfaces
