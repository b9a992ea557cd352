"""Light in and on water: caustics, shadows, veil, and what the rippled surface reflects.

Panels above the water (tubes, lit ceilings, windows) and uniform light from all around shine on it. A surface of
reflectance ``rho`` (linear base colour) in the water, ``d`` below it and seen along ``s`` of it, has the radiance

    L = (1 - F) / n² (rho E / pi X + V (1 - X)) + F M,    X = exp(-(a + b) s - K d),    K = 1.2 (a + 0.3 b)

with absorption ``a`` and scattering ``b`` per metre, the share ``F`` that the surface reflects (Fresnel) and what is
mirrored there, ``M``. ``E`` is the light that enters, with caustics and shadows, see ``sim.shaders.caustics``. The veil
``V = b / (a + b + K) E_0 / (4 pi)`` is light scattered once, alike in all directions, of twice the light that enters:
about as much comes back from a pale floor. K is the usual estimate for daylight (Kirk, Light and Photosynthesis in
Aquatic Ecosystems, 2011, chapter 6), whose constants depend on the particles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.checks import check, check_types, check_within
from sim.gbuffer import GBuffer
from sim.optics import Camera
from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.refraction import water_rays
from sim.render.row_stages import RowStage, light_picture
from sim.render.rows import PITCH, new_lines
from sim.render.water.rays import (
    ALONG_X,
    ALONG_Y,
    MIRROR_X,
    MIRROR_Y,
    REFLECTANCE,
    STEP_PX,
    SURFACE_DEPTH,
    WaterRays,
    interpolate_row,
)
from sim.shaders.caustics import FloorLight, LightThroughSurface, MapExtent, exp_minus
from sim.shaders.colour import black_body_rgb
from sim.shaders.daylight import reflectance_row
from sim.water_surface import RippledSurface
from sim.world import World

_FARTHEST_M, _ASIDE = np.float32(1e4), np.float32(9.0)
_NEAR = np.float32(0.7)
"""Places from the middle of a panel up to which it, or its edge out of focus, is seen."""
_NEAR_SMOOTH = np.float32(4.0)
"""The same for edges that are smooth by pixels."""


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


def mirror_panels(
    rays: WaterRays, panels: PanelArrays, near: np.float32 = _NEAR
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return ``places`` and ``spans`` of ``WaterLight``, of what is nearer to a panel's middle than ``near``."""
    places = np.empty((len(panels.frames), 2, *rays.nodes.shape[1:]), np.float32)
    spans = np.empty((len(panels.frames), rays.nodes.shape[1] - 1, 2), np.int32)
    _mirror_panels(rays, rays.position_m.astype(np.float32), rays.matrix.astype(np.float32), panels.frames, places)
    _find_spans(places, near, spans)
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
def _find_spans(places: NDArray[np.float32], near: np.float32, spans: NDArray[np.int32]) -> None:
    """Write the spans: between the four nodes of a cell, an edge of the panel may lie though it is on none of them."""
    none = np.int32(places.shape[3])
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


ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
_ON_FLOOR = np.float32(0.93)
"""Share of the water's depth from which on shadows of bodies fall: not on the bodies themselves."""
_EDGE = np.float32(0.06)
"""Width of a mirrored edge, which is out of focus, relative to the panel's side."""
Z, U, V, F, X, Y, DOWN, WAY, LIT, WET, MIRROR_A, MIRROR_B = (np.uint64(line * PITCH) for line in range(12))
"""Where lines of the scratch begin: z_s; e along x and y; share reflected; position of what is seen and its depth
below the surface; way to it in the water; light that arrives; 1 in the water, 0 elsewhere; place on a panel."""
NEXT_A, NEXT_B = X, Y
"""Place on a panel in the next row, once the positions are no longer needed."""
SMOOTH_PX = np.float32(0.55)
"""Scale of the logistic spread of a mirrored edge on the sensor, in pixels: lens and shutter together."""


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
    """Scratch of ``shade_row``: a line buffer (``sim.render.rows``) of 12 lines, and cells (W,) of the maps."""

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
    _shade_without_mirror(light, row, surfaces, scratch, radiance)
    for panel in range(light.places.shape[0]):
        _mirror(light, panel, row, scratch.lines, radiance)


@row_kernel()
def shade_row_smooth(
    light: WaterLight, row: int, surfaces: SurfaceRow, scratch: WaterScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (3, W) of one row, mirror images with smooth edges."""
    _shade_without_mirror(light, row, surfaces, scratch, radiance)
    for panel in range(light.places.shape[0]):
        _mirror_smooth(light, panel, row, scratch.lines, radiance)


@row_kernel()
def _shade_without_mirror(
    light: WaterLight, row: int, surfaces: SurfaceRow, scratch: WaterScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (3, W) of one row without what the surface mirrors of panels."""
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


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _mirror_smooth(
    light: WaterLight, panel: int, row: int, lines: NDArray[np.float32], radiance: NDArray[np.float32]
) -> None:
    """Add what the surface mirrors of a panel to the radiance (3, W), its edges spread over pixels.

    Along each side of the panel, at place ``a`` that changes by ``g`` a pixel, the share ``l((a + 1/2) / (g s)) -
    l((a - 1/2) / (g s))`` is seen: the image of a bar of width 1 under a logistic spread ``l`` of scale s pixels. Its
    tails are exponential, so that an edge a hundred times too bright for the sensor still ends softly.
    """
    span = light.spans[panel, min(row // STEP_PX, light.spans.shape[1] - 1)]
    first, last = np.uint64(span[0]), np.uint64(min(span[1], np.int32(radiance.shape[1])))
    if first >= last:
        return
    width = radiance.shape[1]
    interpolate_row(light.places[panel, 0], row, width, lines[MIRROR_A:])
    interpolate_row(light.places[panel, 1], row, width, lines[MIRROR_B:])
    # Below the last row of nodes there is none; the change is that from the row before then.
    other = row + 1 if (row + 1) // STEP_PX < light.places.shape[2] - 1 else row - 1
    interpolate_row(light.places[panel, 0], other, width, lines[NEXT_A:])
    interpolate_row(light.places[panel, 1], other, width, lines[NEXT_B:])
    panes_a, panes_b, bar = light.panels.panes[panel, 0], light.panels.panes[panel, 1], light.panels.bar_share[panel]
    end = np.uint64(width - 1)
    for k in range(first, last):
        here = np.uint64(k)
        side = here + np.uint64(1) if here < end else here - np.uint64(1)
        a, b = lines[MIRROR_A + here], lines[MIRROR_B + here]
        across_a, down_a = lines[MIRROR_A + side] - a, lines[NEXT_A + here] - a
        across_b, down_b = lines[MIRROR_B + side] - b, lines[NEXT_B + here] - b
        shine = _spread(a, np.sqrt(across_a * across_a + down_a * down_a))
        shine *= _spread(b, np.sqrt(across_b * across_b + down_b * down_b))
        if bar > ZERO:
            shine *= _pane(a, panes_a, bar) * _pane(b, panes_b, bar)
        # The places themselves are read by the next pixel to the right.
        lines[LIT + here] = shine * lines[WET + here] * lines[F + here]
    for channel in range(3):
        nit, line = light.panels.nit[panel, channel], radiance[channel]
        for k in range(first, last):
            line[k] += nit * lines[LIT + k]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _spread(place: np.float32, change: np.float32) -> np.float32:
    """Return the share of a side of length 1 about 0 that is seen where places change by so much a pixel."""
    per_scale = ONE / (max(change, np.float32(1e-4)) * SMOOTH_PX)
    far, near = (np.abs(place) + HALF) * per_scale, (np.abs(place) - HALF) * per_scale
    most = np.float32(80.0)
    return ONE / (ONE + np.exp(min(max(near, -most), most))) - ONE / (ONE + np.exp(min(far, most)))


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _pane(place: np.float32, panes: np.float32, bar: np.float32) -> np.float32:
    """Return 1 on the panes of a window's side, 0 on the bars between them."""
    at = (place + HALF) * panes
    off_bar = np.abs(at - np.floor(at) - HALF)
    return min(max((HALF - HALF * bar - off_bar) / (_EDGE * (bar + np.float32(1e-6)) * panes) + HALF, ZERO), ONE)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _within(place: np.float32, panes: np.float32, bar: np.float32) -> np.float32:
    """Return 1 on the panes of a panel's side, 0 on bars and outside."""
    at = (place + HALF) * panes
    inside = min(max(min(at, panes - at) / (_EDGE * panes) + HALF, ZERO), ONE)
    off_bar = np.abs(at - np.floor(at) - HALF)
    pane = min(
        max((HALF - HALF * bar - off_bar) / (_EDGE * (bar + np.float32(1e-6)) * panes + np.float32(1e-6)), ZERO), ONE
    )
    return inside * (pane if bar > ZERO else ONE)


_PATCHES = 24
"""Patches along each side of a panel, over which its light is summed."""
_BACK_FROM_SURFACE = 0.48
"""Share of diffuse light from below that the surface sends back, for an index of 1.33."""


@dataclass(frozen=True, slots=True)
class Water:
    """What is in the water.

    Attributes:
        scattering_per_m: by particles, in [0, 60]: 0.2 is clear, 3 a little cloudy, 8 murky for a tank of 12 cm.
        absorption_per_m: of R, G and B, each in [0, 20]; the default is that of pure water.
        particles_rgb: share of scattered light of each colour that particles do not absorb, in [0, 1].
        floor_reflectance: mean of floor and walls, in [0, 0.95], which light up the water from below.
    """

    scattering_per_m: float = 0.2
    absorption_per_m: tuple[float, float, float] = (0.34, 0.06, 0.01)
    particles_rgb: tuple[float, float, float] = (0.92, 0.95, 0.86)
    floor_reflectance: float = 0.5

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "scattering_per_m", 0.0, 60.0)
        check_within(self, "floor_reflectance", 0.0, 0.95)
        for name, high in (("absorption_per_m", 20.0), ("particles_rgb", 1.0)):
            got = getattr(self, name)
            check(name, all(0.0 <= each <= high for each in got), f"three numbers in [0, {high:g}]", got)


@dataclass(frozen=True, slots=True)
class Panel:
    """A bright rectangle above the water: a tube, a lit ceiling panel or a window. It is mirrored, but not drawn.

    Attributes:
        middle_m, side_a_m, side_b_m: its middle and two sides (3,) at a right angle, world frame; both faces shine.
        luminance_nit: >= 0.
        temperature_k: colour temperature, see ``black_body_rgb``.
        panes: of a window, along side a and b; cross bars between them are dark.
        bar_share: width of a bar or frame relative to that of a pane, in [0, 1).
    """

    middle_m: tuple[float, float, float]
    side_a_m: tuple[float, float, float]
    side_b_m: tuple[float, float, float]
    luminance_nit: float
    temperature_k: float = 5000.0
    panes: tuple[int, int] = (1, 1)
    bar_share: float = 0.0

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "luminance_nit", 0.0)
        check("panes", min(self.panes) >= 1, "two numbers >= 1", self.panes)
        check("bar_share", 0.0 <= self.bar_share < 1.0, "a number in [0, 1)", self.bar_share)
        a, b = np.array(self.side_a_m), np.array(self.side_b_m)
        lengths = float(np.linalg.norm(a) * np.linalg.norm(b))
        is_rectangle = lengths > 0 and abs(float(a @ b)) < 1e-6 * lengths
        check("side_a_m, side_b_m", is_rectangle, "sides of a rectangle", (self.side_a_m, self.side_b_m))


_SHARP, _SMOOTH = RowStage(shade_row, new_water_scratch), RowStage(shade_row_smooth, new_water_scratch)


class WaterShader:
    """Lights G-buffers of one world with water in it, as ``sim.render.refraction.ThroughWater`` draws them."""

    def __init__(
        self,
        world: World,
        surface: RippledSurface,
        water: Water,
        panels: Sequence[Panel],
        ambient_lx: float,
        *,
        ambient_temperature_k: float = 5000.0,
        smooth_glare: bool = False,
    ) -> None:
        """Set the light.

        Args:
            surface: the one that is looked through; its ``time_s`` counts.
            panels: each wholly above the water.
            ambient_lx: uniform light from all around, on a level surface, >= 0.
            smooth_glare: whether edges of mirrored panels are spread as on a sensor, over a pixel or two; else they are
                as wide as a share of the panel, which a bright lamp's image shows as stairs.
        """
        self.lighting = _SMOOTH if smooth_glare else _SHARP
        self._near = _NEAR_SMOOTH if smooth_glare else _NEAR
        check("ambient_lx", ambient_lx >= 0, "a number >= 0", ambient_lx)
        for panel in panels:
            lowest_m = panel.middle_m[2] - 0.5 * (abs(panel.side_a_m[2]) + abs(panel.side_b_m[2]))
            check("panels", lowest_m > surface.level_m, f"above the water at {surface.level_m} m", lowest_m)
        self._surface = surface
        lights = [_through_surface(panel, surface) for panel in panels]
        lights.append(_ambient(ambient_lx, surface.refractive_index))
        self._floor = FloorLight(world, surface, lights)
        lx = np.array([light.illuminance_lx for light in lights])
        rgb = np.stack(
            [*(black_body_rgb(panel.temperature_k) for panel in panels), black_body_rgb(ambient_temperature_k)]
        )
        self._entering_lx = float(lx.sum()) / (1.0 - _BACK_FROM_SURFACE * water.floor_reflectance)
        colour = lx @ rgb / lx.sum() if lx.sum() > 0 else np.ones(3)
        absorbed, scattered = np.array(water.absorption_per_m), water.scattering_per_m
        down = 1.2 * (absorbed + 0.3 * scattered)
        along = absorbed + scattered
        share = np.divide(scattered, along + down, out=np.zeros(3), where=along + down > 0)
        veil = np.array(water.particles_rgb) * share * 2.0 * self._entering_lx * colour / (4.0 * np.pi)
        self._medium = np.stack([colour * self._entering_lx / np.pi, veil, along, down]).astype(np.float32)
        self._direct = self._floor.mean_direction()
        self._bounce = water.floor_reflectance
        self._air = (colour * float(lx.sum()) / np.pi).astype(np.float32)
        self._mirrored = (ambient_lx * black_body_rgb(ambient_temperature_k) / np.pi).astype(np.float32)
        self._panels = _panel_arrays(panels)

    def shade(self, gbuffer: GBuffer, camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the radiance (H, 3, W) float32, cd/m² for each of R, G and B, of a G-buffer sampled at centres."""
        return light_picture(self.lighting, self.row_light(gbuffer.depth_m, camera, T_world_camera), gbuffer)

    def row_light(
        self, depth_m: NDArray[np.float32], camera: Camera, T_world_camera: NDArray[np.float64]
    ) -> WaterLight:
        """Return the light of the present moment, see ``RowShader``."""
        rays = water_rays(self._surface, camera, T_world_camera)
        return WaterLight(
            rays.nodes,
            rays.position_m.astype(np.float32),
            rays.matrix.astype(np.float32),
            self._floor.extent(),
            self._floor.maps(),
            self._medium,
            self._direct,
            np.float32(self._bounce),
            self._air,
            self._mirrored,
            self._panels,
            *mirror_panels(rays, self._panels, self._near),
        )


def _through_surface(panel: Panel, surface: RippledSurface) -> LightThroughSurface:
    """Return what enters the water at rest in the middle of its rectangle."""
    index = surface.refractive_index
    steps = (np.arange(_PATCHES) + 0.5) / _PATCHES - 0.5
    a, b = (side.ravel() for side in np.meshgrid(steps, steps))
    side_a, side_b = np.array(panel.side_a_m), np.array(panel.side_b_m)
    middle = np.array([*(0.5 * (surface.low_m + surface.high_m)), surface.level_m])
    towards = np.array(panel.middle_m) + a[:, None] * side_a + b[:, None] * side_b - middle
    distance = np.linalg.norm(towards, axis=1)
    across = np.cross(side_a, side_b)
    cosine = towards[:, 2] / distance
    leaving = np.abs(towards @ across) / distance
    lux = panel.luminance_nit * leaving * cosine / distance**2 / len(a)
    bent = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    reflected = 0.5 * (
        ((cosine - index * bent) / (cosine + index * bent)) ** 2
        + ((index * cosine - bent) / (index * cosine + bent)) ** 2
    )
    lux *= (1.0 - reflected) * (1.0 - panel.bar_share) ** 2
    run = -towards[:, :2] / distance[:, None] / index / bent[:, None]
    weight = lux / lux.sum() if lux.sum() > 0 else np.full(len(a), 1.0 / len(a))
    mean = weight @ run
    return LightThroughSurface(float(lux.sum()), mean, np.sqrt(weight @ (run - mean) ** 2))


def _ambient(ambient_lx: float, index: float) -> LightThroughSurface:
    """Return uniform light from above: 7 % are reflected; the tangent of the bent rays is uniform in its square."""
    widest = 1.0 / np.sqrt(index**2 - 1.0)
    return LightThroughSurface(0.93 * ambient_lx, np.zeros(2), np.full(2, 0.5 * widest))


def _panel_arrays(panels: Sequence[Panel]) -> PanelArrays:
    frames = np.empty((len(panels), 3, 3), np.float32)
    for frame, panel in zip(frames, panels, strict=True):
        frame[0] = panel.middle_m
        for k, side in enumerate((np.array(panel.side_a_m), np.array(panel.side_b_m)), 1):
            frame[k] = side / (side @ side)
    nit = [panel.luminance_nit * black_body_rgb(panel.temperature_k) for panel in panels]
    return PanelArrays(
        frames,
        np.array(nit, np.float32).reshape(-1, 3),
        np.array([panel.panes for panel in panels], np.float32).reshape(-1, 2),
        np.array([panel.bar_share for panel in panels], np.float32),
    )
