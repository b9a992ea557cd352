"""Baked light of fixed surfaces, with shadows and reflections between walls.

Sources come in named *groups*, each switched or dimmed as one. For every group at full strength there is a map of
illuminance on each panel and a grid of ambient cubes (``light_grid``) for other bodies. Direct light on a panel is
computed at every sample of its map, the smoother reflected light between coarse patches (``radiosity``). The maps are
too coarse for the edges of the sun's shadows: direct sunlight has finer maps of the share that arrives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.checks import check
from sim.mesh import Texture
from sim.render.compilation import announce_compilation
from sim.shaders.baked.direct import (
    MUCH_SKY,
    SunLight,
    add_lamps,
    resample,
    sky_levels,
    sky_light,
    sun_at_samples,
    sun_light,
)
from sim.shaders.baked.light_grid import Grid, Reflecting, cube_places, gather, grid_over_ground
from sim.shaders.baked.light_maps import Geometry, Lattice, fill_hidden, in_the_open, lattice, samples
from sim.shaders.baked.radiosity import arriving_at, cut, factors_between, mean_over_patches, thrown_back
from sim.shaders.baked.rays import Rectangles, rectangles, sphere_directions
from sim.shaders.colour import LUMINANCE_WEIGHTS, srgb_to_linear
from sim.shaders.daylight import Sun
from sim.shaders.lamps import BrightArea, Lamp, Sources, small_sources

_MAP_STEP_M = 0.25
_PATCH_M = 1.0
_FEW_DIRECTIONS, _MANY_DIRECTIONS = sphere_directions(256)[128:], sphere_directions(2048)[1024:]


@dataclass(frozen=True, slots=True)
class Panel:
    """A fixed rectangle that receives, reflects and blocks light, from both sides.

    Where another panel stands on it or meets it in the middle, use two panels: otherwise light and shadow continue
    beneath for a quarter of a metre.

    Attributes:
        instance_id: of the body that consists of this rectangle; -1 for one that only blocks light, such as the side of
            a box.
        corner_m, side_a_m, side_b_m: one corner and two sides (3,), world frame; it faces ``side_a x side_b``.
        reflectance_rgb: linear, in [0, 1).
    """

    instance_id: int
    corner_m: NDArray[np.float64]
    side_a_m: NDArray[np.float64]
    side_b_m: NDArray[np.float64]
    reflectance_rgb: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Sky:
    """The sky, a little paler and brighter towards the horizon.

    Attributes:
        luminance_nit: mean, >= 0: open level ground receives ``pi`` times as many lux.
        colour_rgb: relative linear R, G, B.
    """

    luminance_nit: float
    colour_rgb: tuple[float, float, float] = (0.86, 1.0, 1.3)

    @property
    def radiance(self) -> NDArray[np.float64]:
        """Mean radiance (3,) of R, G and B."""
        colour = np.asarray(self.colour_rgb)
        return self.luminance_nit * colour / float(colour @ LUMINANCE_WEIGHTS)


Source = Lamp | BrightArea | Sun | Sky


@dataclass(frozen=True, slots=True)
class BakedLight:
    """Light of G groups at full strength on R panels and in the space between them.

    Attributes:
        panels: R. groups: their sources, by name and in order.
        geometry: of the panels. obstacles: of panels and bright areas.
        where: lattice of the maps. maps_lx: (G, T, 3) float32, without direct sunlight.
        grid: of the cubes. cubes_lx: (G, P, 6, 3) float32, illuminance of their sides, without direct sunlight.
        sun: None for no sun. sky: (2, 3), see ``sky_levels``; sky_group: number of its group, -1 for none.
    """

    panels: tuple[Panel, ...]
    groups: dict[str, tuple[Source, ...]]
    geometry: Geometry
    obstacles: Rectangles
    where: Lattice
    maps_lx: NDArray[np.float32]
    grid: Grid
    cubes_lx: NDArray[np.float32]
    sun: SunLight | None
    sky: NDArray[np.float64]
    sky_group: int


def mean_reflectance(texture: Texture) -> NDArray[np.float64]:
    """Return the mean linear R, G, B (3,) of a texture."""
    mean: NDArray[np.float64] = srgb_to_linear(texture.rgb / 255.0).mean(axis=(0, 1))
    return mean


def bake_light(panels: Sequence[Panel], lights: Mapping[str, Sequence[Source]]) -> BakedLight:
    """Bake the light of groups of sources on panels and between them.

    Args:
        lights: the sources of each group; one sun and one sky at most in all.

    Raises:
        ValueError: for no panel or group, a panel without size, an impossible reflectance, or more than one sun or sky.
    """
    check("panels", len(panels) > 0, "at least one", len(panels))
    check("lights", len(lights) > 0, "at least one group", len(lights))
    for panel in panels:
        reflectance = np.asarray(panel.reflectance_rgb)
        good = reflectance.shape == (3,) and bool(((reflectance >= 0) & (reflectance < 1)).all())
        check("reflectance_rgb", good, "three numbers in [0, 1)", panel.reflectance_rgb)
    announce_compilation(factors_between)
    groups = {name: tuple(sources) for name, sources in lights.items()}
    areas = [source for sources in groups.values() for source in sources if isinstance(source, BrightArea)]
    geometry, obstacles = _geometry(panels), _obstacles([*panels, *areas])
    small, group = _small_sources(groups)
    sky, sky_group = _sky(groups)
    sun = _sun(groups, geometry, obstacles)
    where = lattice(geometry, _MAP_STEP_M)
    points_m, owner = samples(geometry, where)
    is_open = in_the_open(obstacles, points_m, geometry.normal, owner)
    straight_lx = np.zeros((where.total, 3 * len(groups)), np.float32)
    add_lamps(obstacles, small, group, points_m, geometry.normal, owner, is_open, straight_lx)
    if sky_group >= 0:
        straight_lx[:, 3 * sky_group : 3 * sky_group + 3] += _sky_light(geometry, obstacles, sky, where)
    fill_hidden(where, is_open, straight_lx)
    all_straight_lx = straight_lx.copy()
    if sun is not None:
        all_straight_lx[:, 3 * sun.group : 3 * sun.group + 3] += sun_at_samples(sun, geometry, where)
    reflectance = np.tile([panel.reflectance_rgb for panel in panels], len(groups)).astype(np.float32)
    thrown_lx = _thrown_back(geometry, obstacles, reflectance, where, all_straight_lx)
    leaving = (reflectance[owner] / np.float32(np.pi)) * (all_straight_lx + thrown_lx)
    grid = _grid(geometry, obstacles)
    seen = Reflecting(where, leaving, sky, 3 * sky_group if sky_group >= 0 else -1)
    in_rooms = np.repeat(grid.is_open, len(grid.heights_m))
    cubes_lx = gather(obstacles, small, group, seen, cube_places(grid), in_rooms)
    return BakedLight(
        tuple(panels),
        groups,
        geometry,
        obstacles,
        where,
        _by_group(straight_lx + thrown_lx, len(groups)),
        grid,
        _by_group(cubes_lx, len(groups)),
        sun,
        sky,
        sky_group,
    )


def _sky_light(
    geometry: Geometry, obstacles: Rectangles, sky: NDArray[np.float64], where: Lattice
) -> NDArray[np.float32]:
    """Return the direct light (T, 3) of the sky.

    Where little of it is visible, as through a door, few directions would act as so many lamps: there many are used, at
    coarse samples only.
    """
    light, share = [], []
    coarse = lattice(geometry, _PATCH_M)
    for lattices, many in ((where, _MANY_DIRECTIONS[:0]), (coarse, _MANY_DIRECTIONS)):
        points_m, owner = samples(geometry, lattices)
        is_open = in_the_open(obstacles, points_m, geometry.normal, owner)
        light.append(np.zeros((lattices.total, 3), np.float32))
        share.append(
            sky_light(obstacles, _FEW_DIRECTIONS, many, sky, points_m, geometry.normal, owner, is_open, light[-1])
        )
        fill_hidden(lattices, is_open, light[-1])
    from_coarse = np.empty_like(light[0])
    resample(coarse, light[1], where, 1, from_coarse)
    fine_weight = np.clip(2 * share[0] / MUCH_SKY - 1, 0, 1)[:, None]
    result: NDArray[np.float32] = fine_weight * light[0] + (1 - fine_weight) * from_coarse
    return result


def _thrown_back(
    geometry: Geometry,
    obstacles: Rectangles,
    reflectance: NDArray[np.floating],
    where: Lattice,
    straight_lx: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return the reflected light (T, C) between panels of reflectance (R, C) under direct light (T, C)."""
    patches = cut(geometry, _PATCH_M)
    arriving_lx = mean_over_patches(where, patches, straight_lx)
    leaving_lx = thrown_back(factors_between(obstacles, patches), reflectance[patches.owner], arriving_lx)
    weight = (leaving_lx / np.maximum(leaving_lx.max(axis=0), np.float32(1e-9))).max(axis=1)
    coarse = lattice(geometry, _PATCH_M)
    points_m, owner = samples(geometry, coarse)
    coarse_lx = arriving_at(obstacles, patches, leaving_lx, weight, points_m, geometry.normal, owner)
    fill_hidden(coarse, in_the_open(obstacles, points_m, geometry.normal, owner), coarse_lx)
    thrown_lx = np.empty_like(straight_lx)
    resample(coarse, coarse_lx, where, 1, thrown_lx)
    return thrown_lx


def _grid(geometry: Geometry, obstacles: Rectangles) -> Grid:
    grid = grid_over_ground(geometry)
    places_m = cube_places(grid)
    in_rooms = in_the_open(obstacles, places_m, np.zeros((1, 3)), np.zeros(len(places_m), np.int32))
    return grid._replace(is_open=grid.is_open & in_rooms.reshape(-1, len(grid.heights_m)).all(axis=1))


def _by_group(values: NDArray[np.float32], groups: int) -> NDArray[np.float32]:
    """Return values (..., 3 G) as (G, ..., 3)."""
    apart = values.reshape(*values.shape[:-1], groups, 3)
    return np.ascontiguousarray(np.moveaxis(apart, -2, 0))


def _geometry(them: Sequence[Panel | BrightArea]) -> Geometry:
    corner_m, side_a_m, side_b_m = (
        np.array([getattr(each, name) for each in them], dtype=float).reshape(-1, 3)
        for name in ("corner_m", "side_a_m", "side_b_m")
    )
    normal = np.cross(side_a_m, side_b_m)
    size_m2 = np.linalg.norm(normal, axis=1, keepdims=True)
    check("side_a_m, side_b_m", bool((size_m2 > 0).all()), "sides of a rectangle", float(size_m2.min()))
    return Geometry(corner_m, side_a_m, side_b_m, normal / size_m2)


def _obstacles(them: Sequence[Panel | BrightArea]) -> Rectangles:
    geometry = _geometry(them)
    return rectangles(geometry.corner_m, geometry.side_a_m, geometry.side_b_m)


def _small_sources(groups: dict[str, tuple[Source, ...]]) -> tuple[Sources, NDArray[np.int64]]:
    """Return lamps and patches of bright areas of all groups, and the group of each."""
    parts = []
    for sources in groups.values():
        lamps = [source for source in sources if isinstance(source, Lamp)]
        parts.append(small_sources(lamps, [source for source in sources if isinstance(source, BrightArea)]))
    group = np.repeat(np.arange(len(parts)), [len(part.positions_m) for part in parts])
    positions_m, facing, intensity_cd, spread_m2 = (
        np.concatenate([part[field] for part in parts]) for field in range(4)
    )
    flux_lm = np.sum([part.flux_lm for part in parts], axis=0)
    return Sources(positions_m, facing, intensity_cd, spread_m2, flux_lm), group


def _sky(groups: dict[str, tuple[Source, ...]]) -> tuple[NDArray[np.float64], int]:
    found = [(source, k) for k, sources in enumerate(groups.values()) for source in sources if isinstance(source, Sky)]
    check("lights", len(found) <= 1, "one sky at most", len(found))
    return (sky_levels(found[0][0].radiance), found[0][1]) if found else (np.zeros((2, 3)), -1)


def _sun(groups: dict[str, tuple[Source, ...]], geometry: Geometry, obstacles: Rectangles) -> SunLight | None:
    found = [(source, k) for k, sources in enumerate(groups.values()) for source in sources if isinstance(source, Sun)]
    check("lights", len(found) <= 1, "one sun at most", len(found))
    return sun_light(*found[0], geometry, obstacles) if found else None
