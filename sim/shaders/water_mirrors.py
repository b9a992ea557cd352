"""Where the rippled surface mirrors bright panels; see ``sim.shaders.water``."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.water.rays import MIRROR_X, MIRROR_Y, STEP_PX, SURFACE_DEPTH, ZERO, WaterRays

_FARTHEST_M, _ASIDE = np.float32(1e4), np.float32(9.0)
_NEAR = np.float32(0.7)
"""Places from the middle of a panel up to which it, or its edge out of focus, is seen."""


class PanelArrays(NamedTuple):
    """Panels as arrays for kernels, float32.

    Attributes:
        frames: (P, 3, 3) the middle; and the sides, each divided by its squared length.
        nit: (P, 3) luminance of R, G and B.
        panes: (P, 2) along the sides.
        bar_share: (P,).
    """

    frames: NDArray[np.float32]
    nit: NDArray[np.float32]
    panes: NDArray[np.float32]
    bar_share: NDArray[np.float32]


def mirror_panels(rays: WaterRays, panels: PanelArrays) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return ``places`` and ``spans`` of ``WaterLight``."""
    places = np.empty((len(panels.frames), 2, *rays.nodes.shape[1:]), np.float32)
    spans = np.empty((len(panels.frames), rays.nodes.shape[1] - 1, 2), np.int32)
    _mirror_panels(rays, rays.position_m.astype(np.float32), rays.matrix.astype(np.float32), panels.frames, places)
    _find_spans(places, spans)
    return places, spans


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _mirror_panels(
    rays: WaterRays,
    origin: NDArray[np.float32],
    matrix: NDArray[np.float32],
    frames: NDArray[np.float32],
    places: NDArray[np.float32],
) -> None:
    """Write the places, from the mirrored rays ``p + rise (r_x, r_y, 1)``, for the plane of each panel.

    Args:
        origin, matrix: those of the rays, float32.
    """
    offset, farthest, aside = np.float32(rays.pixel_offset), _FARTHEST_M, _ASIDE
    m_x, m_y, m_z = matrix[0, 0], matrix[1, 0], matrix[2, 0]
    for panel in range(frames.shape[0]):
        middle, a, b = frames[panel, 0], frames[panel, 1], frames[panel, 2]
        a_x, a_y, a_z, b_x, b_y, b_z = a[0], a[1], a[2], b[0], b[1], b[2]
        nx, ny, nz = a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x
        at_x, at_y, at_z = origin[0] - middle[0], origin[1] - middle[1], origin[2] - middle[2]
        for row in range(places.shape[2]):
            y = np.float32(row * STEP_PX) + offset
            x_base = matrix[0, 1] * y + matrix[0, 2]
            y_base = matrix[1, 1] * y + matrix[1, 2]
            z_base = matrix[2, 1] * y + matrix[2, 2]
            depths, across, down = (
                rays.nodes[SURFACE_DEPTH, row],
                rays.nodes[MIRROR_X, row],
                rays.nodes[MIRROR_Y, row],
            )
            along_a, along_b = places[panel, 0, row], places[panel, 1, row]
            for k in range(depths.shape[0]):
                x, depth, rx, ry = (
                    np.float32(np.int32(k * STEP_PX)) + offset,
                    min(depths[k], farthest),
                    across[k],
                    down[k],
                )
                px, py, pz = (
                    at_x + depth * (m_x * x + x_base),
                    at_y + depth * (m_y * x + y_base),
                    at_z + depth * (m_z * x + z_base),
                )
                rise = -(nx * px + ny * py + nz * pz) / (nx * rx + ny * ry + nz)
                px, py, pz = px + rise * rx, py + rise * ry, pz + rise
                u, v = min(max(px * a_x + py * a_y + pz * a_z, -aside), aside), px * b_x + py * b_y + pz * b_z
                is_ahead = rise > ZERO
                along_a[k] = u if is_ahead else aside
                along_b[k] = min(max(v, -aside), aside) if is_ahead else aside


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _find_spans(places: NDArray[np.float32], spans: NDArray[np.int32]) -> None:
    """Write the spans: between the four nodes of a cell, an edge of the panel may lie though it is on none of them."""
    near, none = _NEAR, np.int32(places.shape[3])
    for panel in range(places.shape[0]):
        for row in range(spans.shape[1]):
            a, b = places[panel, 0, row], places[panel, 1, row]
            c, d = places[panel, 0, row + 1], places[panel, 1, row + 1]
            first, last = none, np.int32(0)
            for k in range(np.int32(places.shape[3] - 1)):
                low_a, high_a = (
                    min(min(a[k], a[k + 1]), min(c[k], c[k + 1])),
                    max(max(a[k], a[k + 1]), max(c[k], c[k + 1])),
                )
                low_b, high_b = (
                    min(min(b[k], b[k + 1]), min(d[k], d[k + 1])),
                    max(max(b[k], b[k + 1]), max(d[k], d[k + 1])),
                )
                is_near = (low_a < near) & (high_a > -near) & (low_b < near) & (high_b > -near)
                cell = np.int32(k)
                first = min(first, cell if is_near else none)
                last = max(last, np.int32(cell + 1) if is_near else np.int32(0))
            spans[panel, row, 0], spans[panel, row, 1] = first * STEP_PX, last * STEP_PX
