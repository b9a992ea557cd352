"""The kernels of ``sim.shaders.water``, a row of pixels at a time. Loops are short, so that they become vector code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.runs import PITCH, new_lines
from sim.render.water.rays import (
    ALONG_X,
    ALONG_Y,
    REFLECTANCE,
    STEP_PX,
    SURFACE_DEPTH,
    interpolate_row,
)
from sim.shaders.caustics import MapExtent
from sim.shaders.caustics_kernels import exp_minus
from sim.shaders.daylight_kernels import reflectance_row
from sim.shaders.water_mirrors import PanelArrays

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
_ON_FLOOR = np.float32(0.93)
"""Share of the water's depth from which on shadows of bodies fall: not on the bodies themselves."""
_FARTHEST_M = np.float32(1e4)
_EDGE = np.float32(0.06)
"""Width of a mirrored edge, which is out of focus, relative to the panel's side."""
Z, U, V, F, X, Y, DOWN, WAY, LIT, WET, MIRROR_A, MIRROR_B = (np.uint64(line * PITCH) for line in range(12))
"""Where lines of the scratch begin: z_s; e along x and y; share reflected; position of what is seen and its depth
below the surface; way to it in the water; light that arrives; 1 in the water, 0 elsewhere; place on a panel."""


class WaterLight(NamedTuple):
    """Light in one picture as arrays for kernels, all float32.

    Attributes:
        nodes: (6, R, C), see ``WaterRays``.
        position_m, matrix: (3,) and (3, 3) of the camera, see there.
        extent: of the maps.
        maps: (2, rows, columns) light on the floor, with and without shadows of bodies.
        medium: (4, 3) of R, G and B: light in the water as radiance of a white surface, radiance of the veil,
            attenuation per metre of the way to the camera and per metre of depth.
        direct: (3,) unit vector towards the light, in the water.
        bounce: share of light that comes from below.
        air: (3,) radiance of a white level surface in air. mirrored: (3,) radiance of the room.
        panels: above the water.
        places: (P, 2, R, C) where the nodes' mirrored rays meet each panel: 0 in its middle, -1/2 and 1/2 at its edges.
        spans: (P, R - 1, 2) int32 columns of pixels, between two rows of nodes, from the first that may mirror a panel
            to behind the last.
    """

    nodes: NDArray[np.float32]
    position_m: NDArray[np.float32]
    matrix: NDArray[np.float32]
    extent: MapExtent
    maps: NDArray[np.float32]
    medium: NDArray[np.float32]
    direct: NDArray[np.float32]
    bounce: np.float32
    air: NDArray[np.float32]
    mirrored: NDArray[np.float32]
    panels: PanelArrays
    places: NDArray[np.float32]
    spans: NDArray[np.int32]


class WaterScratch(NamedTuple):
    """Scratch of ``shade_row``: a line buffer (``sim.render.runs``) of 12 lines, and cells (W,) of the maps."""

    lines: NDArray[np.float32]
    cells: NDArray[np.uint32]


def new_water_scratch(width: int) -> WaterScratch:
    """Return scratch for rows of ``width`` pixels."""
    return WaterScratch(new_lines(12, width), np.empty(width, np.uint32))


@row_kernel()
def shade_row(
    light: WaterLight, row: int, surfaces: SurfaceRow, scratch: WaterScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (3, W) of one row, see ``sim.shaders.water``."""
    lines, width = scratch.lines, surfaces.depth_m.shape[0]
    interpolate_row(light.nodes[SURFACE_DEPTH], row, width, lines[Z:])
    interpolate_row(light.nodes[ALONG_X], row, width, lines[U:])
    interpolate_row(light.nodes[ALONG_Y], row, width, lines[V:])
    interpolate_row(light.nodes[REFLECTANCE], row, width, lines[F:])
    _place(light, row, surfaces.depth_m, lines)
    _light_arriving(light, surfaces, lines, scratch.cells)
    for channel in range(3):
        reflectance_row(surfaces.colour, np.uint32(8 * channel), radiance[channel])
        _colour(light, channel, surfaces.depth_m, lines, radiance[channel])
    for panel in range(light.places.shape[0]):
        _mirror(light, panel, row, lines, radiance)


# Numbers that are read from arrays inside a loop that writes would have to be read anew for each pixel.
@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _place(light: WaterLight, row: int, depth_m: NDArray[np.float32], lines: NDArray[np.float32]) -> None:
    """Write where the surfaces seen lie, below the water's surface, and how far the light comes through the water."""
    m, extent = light.matrix, light.extent
    at_x, at_y, at_z = light.position_m[0], light.position_m[1], light.position_m[2]
    level = at_z - extent.level_m
    low_x, low_y, high_x, high_y = extent.low_m[0], extent.low_m[1], extent.high_m[0], extent.high_m[1]
    y = np.float32(row) + HALF
    a, b, c = m[0, 1] * y + m[0, 2], m[1, 1] * y + m[1, 2], m[2, 1] * y + m[2, 2]
    a_x, b_x, c_x, a_y, b_y, c_y = m[0, 0], m[1, 0], m[2, 0], m[0, 1], m[1, 1], m[2, 1]
    for k in range(np.uint64(depth_m.shape[0])):
        x = np.float32(np.int32(k)) + HALF
        z, w = lines[Z + k], min(depth_m[k], _FARTHEST_M)
        dx, dy, dz = a_x * x + a, b_x * x + b, c_x * x + c
        place_x, place_y = at_x + z * dx, at_y + z * dy
        inside = (place_x > low_x) & (place_x < high_x) & (place_y > low_y) & (place_y < high_y) & (w > z)
        is_wet = ONE if inside else ZERO
        share = (ONE - z / w) * is_wet
        du, dv = share * lines[U + k], share * lines[V + k]
        px, py, pz = dx + a_x * du + a_y * dv, dy + b_x * du + b_y * dv, dz + c_x * du + c_y * dv
        along_x, along_y, along_z = w * px - z * dx, w * py - z * dy, w * pz - z * dz
        lines[X + k], lines[Y + k] = at_x + w * px, at_y + w * py
        lines[DOWN + k] = max(-level - w * pz, ZERO) * is_wet
        lines[WAY + k] = np.sqrt(along_x * along_x + along_y * along_y + along_z * along_z) * is_wet
        lines[WET + k] = is_wet


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _light_arriving(
    light: WaterLight, surfaces: SurfaceRow, lines: NDArray[np.float32], cells: NDArray[np.uint32]
) -> None:
    """Write the light that arrives, relative to that on the floor without ripples.

    Between surface and floor, caustics are as much weaker as they are higher. Light comes from the panels' mean
    direction and, a third of it and what the floor sends back, from all around:

        E = map (2/3 max(0, n . l) / l_z + 1/3 (1 + n_z) / 2) + bounce (1 - n_z) / 2
    """
    rows, columns = light.maps.shape[1], light.maps.shape[2]
    per_m, first_x, first_y = ONE / light.extent.step_m, light.extent.first_m[0], light.extent.first_m[1]
    most_s, most_t = np.float32(columns) - np.float32(1.01), np.float32(rows) - np.float32(1.01)
    shadowless, pitch, width = np.int32(rows * columns), np.int32(columns), np.uint64(cells.shape[0])
    depth_m = light.extent.depth_m
    floor = depth_m * _ON_FLOOR
    for k in range(width):
        s = min(max((lines[X + k] - first_x) * per_m, ZERO), most_s)
        t = min(max((lines[Y + k] - first_y) * per_m, ZERO), most_t)
        j, i = np.int32(s), np.int32(t)
        layer = np.int32(0) if lines[DOWN + k] > floor else shadowless
        cells[k] = np.uint32(np.int32(np.int32(i * pitch) + j) + layer)
        lines[X + k], lines[Y + k] = s - np.float32(j), t - np.float32(i)
    maps, below_row, one = light.maps.reshape(-1), np.uint64(columns), np.uint64(1)
    for k in range(width):
        cell = np.uint64(cells[k])
        upper, lower = maps[cell], maps[cell + below_row]
        upper += (maps[cell + one] - upper) * lines[X + k]
        lower += (maps[cell + below_row + one] - lower) * lines[X + k]
        lines[LIT + k] = upper + (lower - upper) * lines[Y + k]
    nx, ny, nz = surfaces.normal[0], surfaces.normal[1], surfaces.normal[2]
    lx, ly, lz, bounce, per_depth = (
        light.direct[0],
        light.direct[1],
        light.direct[2],
        HALF * light.bounce,
        ONE / depth_m,
    )
    directed, from_above = np.float32(2.0 / 3.0) / lz, np.float32(1.0 / 6.0)
    for k in range(width):
        cosine = max(nx[k] * lx + ny[k] * ly + nz[k] * lz, ZERO)
        share = min(lines[DOWN + k] * per_depth, ONE) * lines[WET + k]
        caustic = ONE + (lines[LIT + k] - ONE) * share
        lines[LIT + k] = caustic * (directed * cosine + from_above * (ONE + nz[k])) + bounce * (ONE - nz[k])


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _colour(
    light: WaterLight,
    channel: int,
    depth_m: NDArray[np.float32],
    lines: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Turn one channel's reflectance into radiance, without panels' mirror images. Where depth is inf, it is dark."""
    inside, veil = light.medium[0, channel], light.medium[1, channel]
    along, down = light.medium[2, channel], light.medium[3, channel]
    air, mirrored = light.air[channel], light.mirrored[channel]
    out = ONE / (light.extent.refractive_index * light.extent.refractive_index)
    infinity = np.float32(np.inf)
    for k in range(np.uint64(depth_m.shape[0])):
        left, reflected, wet = exp_minus(along * lines[WAY + k] + down * lines[DOWN + k]), lines[F + k], lines[WET + k]
        shown = radiance[k] * lines[LIT + k] * (air + (inside - air) * wet)
        under = (shown * left + veil * (ONE - left)) * (ONE - reflected) * out + mirrored * reflected
        seen = shown + (under - shown) * wet
        radiance[k] = seen if depth_m[k] < infinity else ZERO


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _mirror(light: WaterLight, panel: int, row: int, lines: NDArray[np.float32], radiance: NDArray[np.float32]) -> None:
    """Add what the surface mirrors of a panel to the radiance (3, W)."""
    span = light.spans[panel, min(row // STEP_PX, light.spans.shape[1] - 1)]
    first, last = np.uint64(span[0]), np.uint64(min(span[1], np.int32(radiance.shape[1])))
    if first >= last:
        return
    interpolate_row(light.places[panel, 0], row, radiance.shape[1], lines[MIRROR_A:])
    interpolate_row(light.places[panel, 1], row, radiance.shape[1], lines[MIRROR_B:])
    panes_a, panes_b, bar = light.panels.panes[panel, 0], light.panels.panes[panel, 1], light.panels.bar_share[panel]
    for k in range(first, last):
        shine = _within(lines[MIRROR_A + k], panes_a, bar) * _within(lines[MIRROR_B + k], panes_b, bar)
        lines[MIRROR_A + k] = shine * lines[WET + k] * lines[F + k]
    for channel in range(3):
        nit, line = light.panels.nit[panel, channel], radiance[channel]
        for k in range(first, last):
            line[k] += nit * lines[MIRROR_A + k]


@row_kernel(forceinline=True, fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _within(place: np.float32, panes: np.float32, bar: np.float32) -> np.float32:
    """Return 1 on the panes of a panel's side, 0 on bars and outside."""
    at = (place + HALF) * panes
    inside = min(max(min(at, panes - at) / (_EDGE * panes) + HALF, ZERO), ONE)
    off_bar = np.abs(at - np.floor(at) - HALF)
    pane = min(
        max((HALF - HALF * bar - off_bar) / (_EDGE * (bar + np.float32(1e-6)) * panes + np.float32(1e-6)), ZERO), ONE
    )
    return inside * (pane if bar > ZERO else ONE)
