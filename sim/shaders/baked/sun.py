"""Direct sunlight on panels: fine maps of the share that arrives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.shaders.baked.direct import sun_share
from sim.shaders.baked.light_maps import Geometry, Lattice, add_between, fill_hidden, lattice, sample_points
from sim.shaders.baked.rays import Rectangles, count_backs
from sim.shaders.colour import LUMINANCE_WEIGHTS
from sim.shaders.daylight import Sun

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
