"""The bodies that never move: quay, wall, ground, sheds, what stands about, and the town behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.layout import COPING_M, FIXED, PARKING_Y_M, Place, Site
from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, swatch_uv
from sim.meshes.shed import Opening, ShedPart, add_plate, level_plate, parts_picture, planks, shed
from sim.meshes.thermal_paint import blotches, parts_palette, varied
from sim.world import Body, World

WALL_TOP_M, WALL_FOOT_M, WALL_BANDS = -0.2, -3.2, 15
"""The wall of the quay has bands of equal height between these, which differ by when the tide last wetted them."""
VENT, LAMP = "vent", "lamp"
"""What is heated from within; all other materials are those of ``sim.thermal.heat``."""
OPENINGS, _WALLS, _ROOFS = (
    ("painted steel", "glass", VENT),
    ("brick", "concrete", "timber"),
    ("roof felt", "brick", "roof sheet"),
)


@dataclass(frozen=True, slots=True)
class Surface:
    """A body, the material of each of its parts by name, and what share of the sky its parts see."""

    body: Body
    materials: tuple[str, ...]
    sky_view: float


YARD, GROUND_VIEW = "asphalt", 0.95
"""Material of the yard, on which cars park, and the share of sky that all ground sees."""


class Scenery(NamedTuple):
    """What was built.

    Attributes:
        surfaces: bodies with their materials. The first is the quay's wall, see ``WALL_BANDS``.
        bay_k: bay's middle along y -> how much warmer the yard about it is than a yard without patches, as the overview
            camera sees it around a car there.
    """

    surfaces: list[Surface]
    bay_k: dict[float, float]


def build_scenery(world: World, rng: np.random.Generator, site: Site = FIXED) -> Scenery:
    """Add the bodies of all that stands there on all days."""
    x, span = site.wall_x_m, site.span_m
    surfaces = [add(world, quay_wall((x, span), (x, -span), rng), "wall", "land", ("granite",) * (WALL_BANDS + 1), 0.5)]
    grounds, bay_k = _grounds(site, rng)
    for name, mesh, material in grounds:
        surfaces.append(add(world, mesh, name, "land", (material,), GROUND_VIEW))
    for k, one in enumerate(site.sheds):
        openings = [Opening(ShedPart.DOOR, y - one.y_m, 1.4, 0.0, 2.3) for y in one.doors_y_m]
        openings += [Opening(ShedPart.DOOR, y - one.y_m + 4.5, 3.2, 0.0, 3.0) for y in one.doors_y_m]
        openings += [Opening(ShedPart.GLASS, y, 1.3, 1.3, 2.4) for y in _windows(one.length_m, openings)]
        openings.append(Opening(ShedPart.VENT, rng.uniform(-0.3, 0.3) * one.length_m, 0.8, 3.1, 3.6))
        wall = ("timber", "brick")[k % 2]
        walls, roof = shed((one.length_m, one.depth_m, one.eaves_m), one.rise_m, openings, rng)
        place = at(site.shed_x_m, one.y_m)
        surfaces.append(add(world, walls, f"shed {k}", "building", (wall, *OPENINGS), 0.5, place))
        surfaces.append(add(world, roof, f"roof {k}", "building", (("roof felt", "roof sheet")[k % 2],), 1.0, place))
    surfaces += _add_town(world, site, rng)
    surfaces += _add_things(world, site, rng)
    return Scenery(surfaces, bay_k)


def add(
    world: World,
    mesh: TexturedMesh,
    name: str,
    category: str,
    materials: tuple[str, ...],
    sky_view: float,
    place: NDArray[np.float64] | None = None,
) -> Surface:
    """Add a body that never moves."""
    pose = np.eye(4) if place is None else place
    return Surface(world.add(mesh, pose, name=name, category=category), materials, sky_view)


def at(x_m: float, y_m: float, z_m: float = 0.0, turn_rad: float = 0.0) -> NDArray[np.float64]:
    """Return the pose (4, 4) of something upright at a place."""
    T = np.eye(4)
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    T[:2, :2] = (c, 0.0 - s), (s, c)
    T[:3, 3] = x_m, y_m, z_m
    return T


def quay_wall(left: Place, right: Place, rng: np.random.Generator) -> TexturedMesh:
    """Return the wall between two places, as seen from the water, down to the bottom of the sea.

    Part 0 is below the bands, the highest band goes up to the top.
    """
    low_m, texels_per_m = -5.0, 10.0
    rows, columns = round(-low_m * texels_per_m), round(float(np.hypot(*np.subtract(left, right))) * texels_per_m)
    z = -(np.arange(rows) + 0.5) / texels_per_m
    band = np.floor((z - WALL_FOOT_M) / (WALL_TOP_M - WALL_FOOT_M) * WALL_BANDS).astype(int)
    part = np.broadcast_to(np.clip(band + 1, 0, WALL_BANDS)[:, None], (rows, columns))
    variation = blotches((rows, columns), ((4.0, 0.35), (25.0, 0.5)), rng) + planks((rows, columns), 13.0, 0.25, rng)
    courses = (np.arange(rows) % 6 == 0)[:, None] | (np.arange(columns) % 120 == 0)[None]
    facets = Facets()
    corners = [(*left, low_m), (*right, low_m), (*right, 0.0), (*left, 0.0)]
    add_plate(facets, corners)
    return facets.mesh(parts_picture(part, variation - 0.7 * courses))


def _grounds(site: Site, rng: np.random.Generator) -> tuple[list[tuple[str, TexturedMesh, str]], dict[float, float]]:
    edge, low, span = site.wall_x_m + COPING_M, site.apron_end_m, site.span_m
    # Small enough for clipping near the camera.
    rows, behind, far = round(12 * span / 90.0), site.shed_x_m + 29.0, 1000.0 if site.is_drawn else 400.0
    apron = slabs((round(2 * span * 6), round((site.apron_end_m - edge) * 6)), 6.0, 5.0, 0.55, rng)
    yard = slabs((round(2 * span * 4), (63 * 4)), 4.0, 0.0, 0.6, rng)
    bay_k = _bays(site, yard, 4.0)
    land = blotches((256, 256), ((3.0, 0.8), (20.0, 1.2)), rng)
    stones = blotches((round(2 * span * 5), 8), ((2.0, 0.3), (9.0, 0.5)), rng)
    stones[:: round(1.2 * 5)] -= 0.8
    coping = level_plate((site.wall_x_m, -span), (edge, span), 0.0, varied(0, stones), (1, rows))
    grounds = [
        ("coping", coping, "granite"),
        ("apron", level_plate((edge, -span), (low, span), 0.0, varied(0, apron), (4, rows)), "concrete"),
        ("yard", level_plate((low, -span), (behind, span), 0.0, varied(0, yard), (4, round(8 * span / 90.0))), YARD),
        ("land", level_plate((behind, -far), (900.0, far), 0.0, varied(0, land), (4, 4)), "grass"),
    ]
    return grounds, bay_k


def slabs(
    shape: tuple[int, int], texels_per_m: float, slab_m: float, spread_k: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the variation of a paved area: joints of slabs, stains, patches that were mended, and puddles."""
    k = blotches(shape, ((1.5, 0.35 * spread_k), (10.0, 0.6 * spread_k), (60.0, 0.9 * spread_k)), rng)
    if slab_m > 0:
        side = round(slab_m * texels_per_m)
        slab = rng.normal(0.0, 0.35 * spread_k, (shape[0] // side + 1, shape[1] // side + 1))
        k += np.kron(slab, np.ones((side, side)))[: shape[0], : shape[1]]
        k[::side] -= 0.8
        k[:, ::side] -= 0.8
    for _ in range(round(0.012 * k.size / texels_per_m**2)):
        height, width = rng.uniform(0.8, 5.0, 2) * texels_per_m
        top, left = rng.uniform(0, shape[0]), rng.uniform(0, shape[1])
        k[int(top) : int(top + height), int(left) : int(left + width)] += rng.normal(0.0, 1.3)
    for _ in range(round(0.008 * k.size / texels_per_m**2)):
        # Covers of shafts, gratings.
        row, column = rng.integers(0, shape[0] - 6), rng.integers(0, shape[1] - 6)
        k[row : row + round(0.7 * texels_per_m), column : column + round(0.7 * texels_per_m)] += rng.choice([-1.5, 2.5])
    wet = blotches(shape, ((30.0, 1.0), (8.0, 0.35)), rng)
    return k - 2.2 * np.clip((wet - 1.55) / 0.25, 0.0, 1.0)


def _bays(site: Site, yard_k: NDArray[np.float64], texels_per_m: float) -> dict[float, float]:
    """Mark the bays of the parking row with painted lines, and where cars often stand with what they leak; return
    ``Scenery.bay_k``.
    """

    def column(x_m: float) -> int:
        return round((x_m - site.apron_end_m) * texels_per_m)

    for y_m in (*PARKING_Y_M, PARKING_Y_M[-1] + 3.0):
        row = round((site.span_m - (y_m - 1.5)) * texels_per_m)
        yard_k[row, column(site.parking_x_m - 2.5) : column(site.parking_x_m + 2.5)] -= 0.9
        stain = round((site.span_m - y_m) * texels_per_m)
        yard_k[stain - 3 : stain + 3, column(site.parking_x_m - 1.8) : column(site.parking_x_m - 0.4)] += 0.7
    # Around a car the camera sees the yard from before its bumper to where the line of sight over its roof ends.
    around = slice(column(site.parking_x_m - 3.0), column(site.parking_x_m + 9.0))
    rows = {y_m: round((site.span_m - y_m) * texels_per_m) for y_m in PARKING_Y_M}
    half = round(1.5 * texels_per_m)
    return {y_m: float(yard_k[row - half : row + half, around].mean()) for y_m, row in rows.items()}


def _windows(length_m: float, doors: list[Opening]) -> list[float]:
    places = np.arange(-0.5 * length_m + 1.6, 0.5 * length_m - 1.0, 2.6)
    clear = [all(abs(y - d.middle_m) > 0.5 * d.width_m + 0.9 for d in doors) for y in places]
    return places[clear].tolist()


def _add_town(world: World, site: Site, rng: np.random.Generator) -> list[Surface]:
    """Add buildings behind the sheds, up to the upper border of the picture."""
    surfaces: list[Surface] = []
    x, k = site.shed_x_m + 32.0, 0
    while x < 420.0:
        reach = 250.0 if site.is_drawn else 0.27 * (x + 100.0) + 20.0
        y = -reach
        while y < reach:
            length = rng.uniform(9.0, 26.0)
            height = rng.uniform(3.5, 7.0) + 0.03 * (x - 78.0)
            depth, rise = rng.uniform(9.0, 16.0), float(rng.choice([0.0, rng.uniform(2.0, 4.0)]))
            storeys = np.arange(1.0, height - 1.6, 2.9)
            openings = [
                Opening(ShedPart.GLASS, across, 1.2, z, z + 1.4)
                for z in storeys
                for across in np.arange(-0.5 * length + 1.5, 0.5 * length - 1.0, rng.uniform(2.4, 3.6))
            ]
            walls, roof = shed((length, depth, height), rise, openings, rng, texels_per_m=3.0)
            place = at(x + rng.uniform(0.0, 5.0), y + 0.5 * length)
            wall, roofing = str(rng.choice(_WALLS)), str(rng.choice(_ROOFS))
            surfaces.append(add(world, walls, f"house {k}", "building", (wall, *OPENINGS), 0.4, place))
            surfaces.append(add(world, roof, f"house roof {k}", "building", (roofing,), 0.9, place))
            y += length + float(rng.choice([0.5, rng.uniform(2.0, 9.0)]))
            k += 1
        x += rng.uniform(38.0, 60.0) * (1.0 + (x - 78.0) / 150.0)
    return surfaces


_THINGS = ("dark paint", "timber", "painted steel", "rubber", LAMP)


def _add_things(world: World, site: Site, rng: np.random.Generator) -> list[Surface]:
    """Add bollards, fenders, ladders, lamp posts, crates, containers, barriers and drums, as one body."""
    facets = Facets()
    iron, timber, steel, rubber, lamp = (swatch_uv(k, len(_THINGS)) for k in range(len(_THINGS)))
    for x, y in site.bollards_m:
        facets.box((x - 0.2, y - 0.2, 0.0), (x + 0.2, y + 0.2, 0.45), iron)
        facets.box((x - 0.3, y - 0.3, 0.45), (x + 0.3, y + 0.3, 0.6), iron)
        if x < site.wall_x_m:
            continue
        facets.box((site.wall_x_m - 0.35, y + 1.6, -2.0), (site.wall_x_m, y + 2.1, -0.5), rubber)
        facets.box((site.wall_x_m - 0.35, y - 1.9, -2.0), (site.wall_x_m, y - 1.4, -0.5), rubber)
    for y in (-21.0, 2.0, 15.5):
        for side in (-0.25, 0.2):
            facets.box((site.wall_x_m - 0.12, y + side, -3.5), (site.wall_x_m, y + side + 0.06, 0.5), iron)
        for z in np.arange(-3.3, -0.1, 0.4):
            facets.box((site.wall_x_m - 0.12, y - 0.2, z), (site.wall_x_m - 0.06, y + 0.2, z + 0.05), iron)
    for x, y in site.lamp_posts_m:
        facets.box((x - 0.25, y - 0.25, 0.0), (x + 0.25, y + 0.25, 0.5), iron)
        facets.box((x - 0.09, y - 0.09, 0.5), (x + 0.09, y + 0.09, 8.0), steel)
        facets.box((x - 1.4, y - 0.12, 7.9), (x + 0.1, y + 0.12, 8.05), lamp)
    shed_x, wall_x = site.shed_x_m, site.wall_x_m
    facets.box((shed_x - 9.0, -27.8, 0.0), (shed_x - 6.5, -21.8, 2.6), steel)
    facets.box((shed_x - 8.0, 24.0, 0.0), (shed_x - 5.5, 30.0, 2.6), steel)
    for _ in range(9):
        x, y = (
            rng.uniform(shed_x - 7.0, shed_x - 1.5),
            float(rng.choice([rng.uniform(-11.0, -8.0), rng.uniform(7.5, 9.5), -34.5])),
        )
        side, height = rng.uniform(0.5, 1.1), rng.uniform(0.5, 1.6)
        facets.box((x, y, 0.0), (x + side, y + 1.2 * side, height), timber)
    for off, y in ((5.5, -24.5), (4.5, -11.0), (6.0, 12.5), (4.0, 25.5)):
        x = wall_x + off
        # Nets and fish boxes near the edge.
        for _ in range(4):
            dx, dy = rng.uniform(-0.9, 0.9, 2)
            height = rng.uniform(0.3, 0.8)
            facets.box(
                (x + dx, y + dy, 0.0), (x + dx + 0.6, y + dy + 0.8, height), (timber, rubber)[int(rng.integers(2))]
            )
    barrier_x = site.apron_end_m + 0.9
    for y in np.arange(-40.0, 41.0, 2.4):
        # A barrier of concrete feet and rails before the parking row, open in the middle.
        if abs(y) > 3.0 and abs(y - 12.0) > 2.0:
            facets.box((barrier_x, y - 0.15, 0.0), (barrier_x + 0.3, y + 0.15, 0.6), timber)
    return [add(world, facets.mesh(parts_palette(len(_THINGS))), "things", "building", _THINGS, 0.6)]
