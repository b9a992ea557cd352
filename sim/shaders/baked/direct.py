"""Direct light of sources and of the sun, with shadows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.shaders.baked.light_maps import Geometry, Lattice, add_between, fill_hidden, lattice, sample_points
from sim.shaders.baked.rays import Rectangles, blocked, count_backs
from sim.shaders.colour import LUMINANCE_WEIGHTS
from sim.shaders.daylight import Sun
from sim.shaders.lamps import Sources, arriving_per_m2

_BEFORE_SOURCE = 1.0 - 1e-3
"""Share of the way to a source that a ray checks: a bright area does not block its own light."""
_FARTHEST = 1e6
MUCH_SKY = 0.3
"""Visible share of the sky below which many directions are used."""
SKY_PALENESS = np.array([0.7, 0.5, 0.3])
"""Rise of R, G and B from the zenith to the horizon, as a share of the sky's mean."""


def sky_levels(radiance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sky's radiance (2, 3) at the zenith and its rise to the horizon, of R, G and B.

    ``L = zenith + rise (1 - sine of the height)``; on level ground E = pi ``radiance``, as under an even sky: the rise
    weighs a third there.
    """
    rise = SKY_PALENESS * radiance
    return np.stack([radiance - rise / 3, rise])


@njit(cache=True)
def add_lamps(
    obstacles: Rectangles,
    sources: Sources,
    group: NDArray[np.int64],
    points_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    owner: NDArray[np.int32],
    is_open: NDArray[np.bool_],
    light_lx: NDArray[np.float32],
) -> None:
    """Add the direct light of lamps and bright areas, see ``LampShader.illuminance_lx``.

    Args:
        group: (S,) of each source.
        points_m: (N, 3). normals: (R, 3), of point n that of ``owner[n]``.
        light_lx: (N, 3 G) of R, G and B of each group, added to.
    """
    for n in range(points_m.shape[0]):
        if not is_open[n]:
            continue
        point, normal = points_m[n], normals[owner[n]]
        for s in range(sources.positions_m.shape[0]):
            arriving = arriving_per_m2(point, normal, sources, s)
            if arriving > 0.0 and reaches(obstacles, point, sources.positions_m[s]):
                for k in range(3):
                    light_lx[n, 3 * group[s] + k] += sources.intensity_cd[s, k] * arriving


@njit(cache=True)
def reaches(obstacles: Rectangles, point_m: NDArray[np.float64], source_m: NDArray[np.float64]) -> bool:
    """Return whether light reaches a point (3,) from a source (3,)."""
    x, y, z = point_m[0], point_m[1], point_m[2]
    return not blocked(obstacles, x, y, z, source_m[0] - x, source_m[1] - y, source_m[2] - z, _BEFORE_SOURCE)


@njit(cache=True)
def sky_light(
    obstacles: Rectangles,
    few: NDArray[np.float64],
    many: NDArray[np.float64],
    levels: NDArray[np.float64],
    points_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    owner: NDArray[np.int32],
    is_open: NDArray[np.bool_],
    light_lx: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Write the direct light (N, 3) of the sky; return its visible share (N,).

    ``E = (2 pi / K) sum of L cos`` over unblocked directions, spread evenly over the upper half sphere.

    Args:
        few: (K, 3) directions. many: (K', 3) directions where little of the sky is visible.
    """
    share = np.zeros(points_m.shape[0], np.float32)
    for n in range(points_m.shape[0]):
        if not is_open[n]:
            continue
        point, normal = points_m[n], normals[owner[n]]
        share[n] = _sky_at(obstacles, few, levels, point, normal, light_lx[n])
        if share[n] < MUCH_SKY and many.shape[0] > 0:
            _sky_at(obstacles, many, levels, point, normal, light_lx[n])
    return share


@njit(cache=True)
def _sky_at(
    obstacles: Rectangles,
    directions: NDArray[np.float64],
    levels: NDArray[np.float64],
    point_m: NDArray[np.float64],
    normal: NDArray[np.float64],
    light_lx: NDArray[np.float32],
) -> float:
    light_lx[:] = 0.0
    each = 2 * np.pi / directions.shape[0]
    seen, in_all = 0.0, 1e-9
    for d in range(directions.shape[0]):
        dx, dy, dz = directions[d, 0], directions[d, 1], directions[d, 2]
        cosine = dx * normal[0] + dy * normal[1] + dz * normal[2]
        if cosine <= 0.0:
            continue
        in_all += cosine
        if not blocked(obstacles, point_m[0], point_m[1], point_m[2], dx, dy, dz, _FARTHEST):
            seen += cosine
            for k in range(3):
                light_lx[k] += each * cosine * (levels[0, k] + levels[1, k] * (1 - dz))
    return seen / in_all


@njit(cache=True)
def sun_share(
    obstacles: Rectangles,
    towards_sun: NDArray[np.float64],
    points_m: NDArray[np.float64],
    offsets_m: NDArray[np.float64],
    share: NDArray[np.float32],
) -> None:
    """Write the share (N,) of the K places ``points_m + offsets_m``, (N, 3) and (K, 3), that see the sun."""
    dx, dy, dz = towards_sun[0], towards_sun[1], towards_sun[2]
    for n in range(points_m.shape[0]):
        seen = 0
        for k in range(offsets_m.shape[0]):
            x, y, z = (
                points_m[n, 0] + offsets_m[k, 0],
                points_m[n, 1] + offsets_m[k, 1],
                points_m[n, 2] + offsets_m[k, 2],
            )
            if not blocked(obstacles, x, y, z, dx, dy, dz, _FARTHEST):
                seen += 1
        share[n] = seen / offsets_m.shape[0]


_STEP_M = 0.06
_FLATTEST = 0.02
_QUARTERS = np.array([(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)])
"""Places around a sample where the sun is sampled, in steps along the two sides."""


@dataclass(frozen=True, slots=True)
class SunLight:
    """Direct sunlight on R panels.

    Attributes:
        group: number of its group. towards: (3,) unit vector. square_lx: (3,) on a surface perpendicular to it.
        where: lattice of the fine maps; panels without sun have no columns and rows there.
        share: (S,) float32, that arrives at each sample.
    """

    group: int
    towards: NDArray[np.float64]
    square_lx: NDArray[np.float64]
    where: Lattice
    share: NDArray[np.float32]


def sun_light(sun: Sun, group: int, geometry: Geometry, obstacles: Rectangles) -> SunLight:
    """Return the direct sunlight on panels."""
    direction, colour = np.asarray(sun.direction, dtype=float), np.asarray(sun.colour_rgb, dtype=float)
    towards = direction / np.linalg.norm(direction)
    fine = lattice(geometry, _STEP_M)
    shares: list[NDArray[np.float32]] = []
    columns, rows = np.zeros_like(fine.columns), np.zeros_like(fine.rows)
    for r in np.flatnonzero(geometry.normal @ towards > _FLATTEST).tolist():
        share = _on_panel(towards, geometry, obstacles, r, int(fine.columns[r]), int(fine.rows[r]))
        if share.any():
            columns[r], rows[r] = fine.columns[r], fine.rows[r]
            shares.append(share)
    ends = np.cumsum(columns * rows)
    where = Lattice((ends - columns * rows).astype(np.int32), columns, rows, int(ends[-1]))
    square_lx = sun.illuminance_lx * colour / float(colour @ LUMINANCE_WEIGHTS)
    return SunLight(group, towards, square_lx, where, np.concatenate([np.empty(0, np.float32), *shares]))


def _on_panel(
    towards: NDArray[np.float64], geometry: Geometry, obstacles: Rectangles, r: int, columns: int, rows: int
) -> NDArray[np.float32]:
    """Return the share (rows * columns,) at the samples of panel r."""
    points_m = sample_points(geometry, r, columns, rows)
    share = np.empty(len(points_m), np.float32)
    steps_m = np.stack([geometry.side_a_m[r] / (columns - 1), geometry.side_b_m[r] / (rows - 1)])
    sun_share(obstacles, towards, points_m, _QUARTERS @ steps_m, share)
    if share.min() < 1.0 and share.max() > 0.0:
        # Samples behind an object on the panel must not darken those beside it.
        ahead = geometry.normal[r : r + 1]
        is_open = count_backs(obstacles, points_m, ahead, np.zeros(len(points_m), np.int32), ahead) < 0.5
        one = Lattice(np.zeros(1, np.int32), np.array([columns], np.int32), np.array([rows], np.int32), len(points_m))
        fill_hidden(one, is_open, share[:, None])
    return share


def sun_at_samples(light: SunLight, geometry: Geometry, where: Lattice) -> NDArray[np.float32]:
    """Return the direct sunlight (T, 3) in lux, averaged around each sample of coarser maps."""
    share = np.zeros((where.total, 1), np.float32)
    resample(light.where, light.share[:, None], where, 4, share)
    owner = np.repeat(np.arange(len(where.first)), where.columns * where.rows)
    cosine = np.maximum(geometry.normal @ light.towards, 0.0)[owner]
    lx: NDArray[np.float32] = (share * cosine[:, None] * light.square_lx).astype(np.float32)
    return lx


@njit(cache=True)
def resample(
    before: Lattice, values: NDArray[np.float32], after: Lattice, pieces: int, result: NDArray[np.float32]
) -> None:
    """Write samples (T', C) of another lattice: means of ``pieces`` x ``pieces`` places around each.

    Args:
        values: (T, C). Rectangles without samples there are left as they are in ``result``.
    """
    total = np.empty(values.shape[1])
    for r in range(after.first.shape[0]):
        if before.columns[r] == 0:
            continue
        columns, rows = after.columns[r], after.rows[r]
        for i in range(rows):
            for j in range(columns):
                total[:] = 0.0
                for n in range(pieces * pieces):
                    u = (j + ((n % pieces) + 0.5) / pieces - 0.5) / (columns - 1)
                    v = (i + ((n // pieces) + 0.5) / pieces - 0.5) / (rows - 1)
                    u, v = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)
                    add_between(before, r, u, v, 1.0 / (pieces * pieces), values, total)
                result[after.first[r] + i * columns + j] = total
