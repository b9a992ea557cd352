"""Direct light of sources, with shadows."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.shaders.baked.rays import Rectangles, blocked
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
