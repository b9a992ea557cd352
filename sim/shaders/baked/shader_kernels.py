"""The kernels of ``sim.shaders.baked.shader``: light on runs of pixels, of panels, of other bodies and of the sky.

Pixels are those from ``first`` up to, not including, ``last`` of the row's arrays (W,).

Pixels are those from ``first`` up to, not including, ``last`` of the row's arrays (W,).

A row is a few *runs* of pixels that show the same body. On a panel, the shares u and v of its sides are ``depth (base +
step column) + offset``; its map of light is interpolated between four samples. Loops that compute, fetch and mix are
separate, so that the first and the last become vector code.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.render.attributes import SurfaceRow
from sim.render.compilation import row_kernel
from sim.render.rows import LANES, PITCH, new_lines
from sim.shaders.daylight import ShadowArrays, ShadowScratch, new_shadow_scratch, reflect_row, shadow_row

LIGHT_LINES = 5
ONE, ZERO = np.float32(1.0), np.float32(0.0)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def place_run(
    place: NDArray[np.float32],
    panel: int,
    row: int,
    first_sample: int,
    columns: int,
    rows: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    index: NDArray[np.uint32],
    x: NDArray[np.float32],
    y: NDArray[np.float32],
) -> None:
    """Write the places of pixels on a panel: number of the sample before, and fractions towards the next ones.

    Args:
        place: see ``BakedArrays``.
        first_sample, columns, rows: of the panel's map.
    """
    down = np.float32(row)
    u_base, u_step, u_start = place[panel, 0] + place[panel, 2] * down, place[panel, 1], place[panel, 3]
    v_base, v_step, v_start = place[panel, 4] + place[panel, 6] * down, place[panel, 5], place[panel, 7]
    wide, high = np.float32(columns - 1), np.float32(rows - 1)
    start, pitch = np.int32(first_sample), np.int32(columns)
    last_column, last_row = np.int32(columns - 2), np.int32(rows - 2)
    for k in range(first, last):
        column, depth = np.float32(np.int32(k)), depth_m[k]
        u = (u_base + u_step * column) * depth + u_start
        v = (v_base + v_step * column) * depth + v_start
        s, t = min(max(u, ZERO), ONE) * wide, min(max(v, ZERO), ONE) * high
        j, i = min(np.int32(s), last_column), min(np.int32(t), last_row)
        index[k] = np.uint32(np.int32(start + np.int32(i * pitch)) + j)
        x[k], y[k] = s - np.float32(j), t - np.float32(i)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def mix_light(
    light: NDArray[np.float32],
    columns: int,
    first: np.uint64,
    last: np.uint64,
    index: NDArray[np.uint32],
    lines: NDArray[np.float32],
) -> None:
    """Write the bilinear light ``level + x across + y (down + x twist)`` between four samples each.

    On near panels many neighbouring pixels share these four, which are read once.

    Args:
        lines: line buffer of x, y, red, green and blue, see ``sim.render.rows``.
    """
    one = np.uint64(1)
    to_y, to_red, to_green, to_blue = np.uint64(PITCH), np.uint64(2 * PITCH), np.uint64(3 * PITCH), np.uint64(4 * PITCH)
    k = first
    while k < last:
        here = index[k]
        a = np.uint64(here)
        b = a + np.uint64(columns)
        r, g, b_ = light[a, 0], light[a, 1], light[a, 2]
        r_across, g_across, b_across = light[a + one, 0] - r, light[a + one, 1] - g, light[a + one, 2] - b_
        r_down, g_down, b_down = light[b, 0] - r, light[b, 1] - g, light[b, 2] - b_
        r_twist = light[b + one, 0] - light[b, 0] - r_across
        g_twist = light[b + one, 1] - light[b, 1] - g_across
        b_twist = light[b + one, 2] - light[b, 2] - b_across
        end = k + one
        while end < last and index[end] == here:
            end += one
        for block in range(k, end, np.uint64(LANES)):
            for n in range(block, block + np.uint64(LANES)):
                s, t = lines[n], lines[to_y + n]
                lines[to_red + n] = r + s * r_across + t * (r_down + s * r_twist)
                lines[to_green + n] = g + s * g_across + t * (g_down + s * g_twist)
                lines[to_blue + n] = b_ + s * b_across + t * (b_down + s * b_twist)
        k = end


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def mix_run(
    values: NDArray[np.float32],
    columns: int,
    first: np.uint64,
    last: np.uint64,
    index: NDArray[np.uint32],
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    factor: np.float32,
    result: NDArray[np.float32],
) -> None:
    """Write ``factor`` times the bilinear value between four samples each."""
    for k in range(first, last):
        a = np.uint64(index[k])
        b = a + np.uint64(columns)
        upper = values[a] + x[k] * (values[a + np.uint64(1)] - values[a])
        lower = values[b] + x[k] * (values[b + np.uint64(1)] - values[b])
        result[k] = factor * (upper + y[k] * (lower - upper))


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def body_run(
    cubes: NDArray[np.float32],
    body: int,
    first: np.uint64,
    last: np.uint64,
    normal: NDArray[np.float32],
    red: NDArray[np.float32],
    green: NDArray[np.float32],
    blue: NDArray[np.float32],
) -> None:
    """Write ``sum of n_k² E_side(k)`` of pixels of a body."""
    cube = cubes[body]  # Loaded before the loop, which then selects between two numbers each and becomes vector code.
    r0, r1, r2, r3, r4, r5 = cube[0, 0], cube[1, 0], cube[2, 0], cube[3, 0], cube[4, 0], cube[5, 0]
    g0, g1, g2, g3, g4, g5 = cube[0, 1], cube[1, 1], cube[2, 1], cube[3, 1], cube[4, 1], cube[5, 1]
    b0, b1, b2, b3, b4, b5 = cube[0, 2], cube[1, 2], cube[2, 2], cube[3, 2], cube[4, 2], cube[5, 2]
    for k in range(first, last):
        x, y, z = normal[0, k], normal[1, k], normal[2, k]
        is_ahead, is_aside, is_up = x > ZERO, y > ZERO, z > ZERO
        x, y, z = x * x, y * y, z * z
        red[k] = x * (r0 if is_ahead else r3) + y * (r1 if is_aside else r4) + z * (r2 if is_up else r5)
        green[k] = x * (g0 if is_ahead else g3) + y * (g1 if is_aside else g4) + z * (g2 if is_up else g5)
        blue[k] = x * (b0 if is_ahead else b3) + y * (b1 if is_aside else b4) + z * (b2 if is_up else b5)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sun_on_body(
    towards_sun: NDArray[np.float32],
    share: np.float32,
    first: np.uint64,
    last: np.uint64,
    normal: NDArray[np.float32],
    cosine: NDArray[np.float32],
    sun_lit: NDArray[np.float32],
) -> None:
    """Write ``max(0, n . l)`` of pixels of a body, and its product with the share of the sun that arrives."""
    for k in range(first, last):
        along = normal[0, k] * towards_sun[0] + normal[1, k] * towards_sun[1] + normal[2, k] * towards_sun[2]
        cosine[k] = max(along, ZERO)
        sun_lit[k] = share * cosine[k]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def sky_run(
    sky: NDArray[np.float32],
    rays: NDArray[np.float32],
    row: int,
    first: np.uint64,
    last: np.uint64,
    red: NDArray[np.float32],
    green: NDArray[np.float32],
    blue: NDArray[np.float32],
) -> None:
    """Write the sky's radiance in the directions of pixels."""
    down = np.float32(row)
    bx, by, bz = rays[0, 0] + down * rays[2, 0], rays[0, 1] + down * rays[2, 1], rays[0, 2] + down * rays[2, 2]
    sx, sy, sz = rays[1, 0], rays[1, 1], rays[1, 2]
    r, g, b = sky[0, 0], sky[0, 1], sky[0, 2]
    r_rise, g_rise, b_rise = sky[1, 0], sky[1, 1], sky[1, 2]
    for k in range(first, last):
        column = np.float32(np.int32(k))
        dx, dy, dz = bx + column * sx, by + column * sy, bz + column * sz
        flat = ONE - max(dz, ZERO) / np.sqrt(dx * dx + dy * dy + dz * dz)
        red[k], green[k], blue[k] = r + r_rise * flat, g + g_rise * flat, b + b_rise * flat


_SUMMED_AT_ONCE = 2048


class BakedArrays(NamedTuple):
    """Light in one picture as arrays for kernels, of B bodies and R panels; float32 except indices and counts.

    Illuminances are in lux over pi: the radiance of a white surface.

    Attributes:
        panel: (B,) int32, number of the panel that a body shows, -1 for none.
        own_nit: (B, 3) luminances of bright areas, -1 for bodies that do not shine.
        place: (R, 8), base, step a column, step a row and offset of u, and those of v.
        maps: (R, 3) int32, first sample, columns and rows of each panel in light: (T, 4) R, G, B and nothing.
        sun_maps: (R, 3) int32, the same in sun_share: (S,); no columns where there is no sun.
        sun_cosine: (R,). shadow_cosine: (R,) the same as the shadow map takes it, see ``shadow_row``.
        sun: (3,) on a surface perpendicular to it. towards_sun: (3,) unit vector.
        casts: whether moving bodies may stand in the sun. shadows: of these.
        cubes: (B, 6, 3) ambient cubes. body_sun: (B,) share of the sun that arrives.
        is_floor: (R,) bool, moving bodies darken it by ``contact``: (C,), rows of ``contact_columns``.
        contact_place: (1, 8), as ``place``, but in samples of ``contact``.
        contact_within: (H, 2) int32, in which columns of each row of pixels: first, after the last.
        sky: (2, 3), see ``sky_levels``. rays: (3, 3) of the upper left pixel, its change a column and a row.
    """

    panel: NDArray[np.int32]
    own_nit: NDArray[np.float32]
    place: NDArray[np.float32]
    maps: NDArray[np.int32]
    light: NDArray[np.float32]
    sun_maps: NDArray[np.int32]
    sun_share: NDArray[np.float32]
    sun_cosine: NDArray[np.float32]
    shadow_cosine: NDArray[np.float32]
    sun: NDArray[np.float32]
    towards_sun: NDArray[np.float32]
    casts: bool
    shadows: ShadowArrays
    cubes: NDArray[np.float32]
    body_sun: NDArray[np.float32]
    is_floor: NDArray[np.bool_]
    contact: NDArray[np.float32]
    contact_columns: int
    contact_place: NDArray[np.float32]
    contact_within: NDArray[np.int32]
    sky: NDArray[np.float32]
    rays: NDArray[np.float32]


class BakedScratch(NamedTuple):
    """Scratch of ``baked_row``, for rows of W pixels; float32 except indices and counts.

    Attributes:
        lines: line buffer (``sim.render.rows``) of x and y, how far a pixel lies beyond a sample, and of the light's
            red, green and blue; these five are (W,) views of it.
        sample: (W,) uint32, number of the sample before a pixel.
        darkening: (W,) by bodies nearby. sun_lit: (W,) share of the sun on a surface. cosine: (W,) between normal and
            the sun's direction, see ``shadow_row``.
        shining_first, shining_last: (W,) uint32, first column of each run that shines, and the one after its last.
    """

    shadow: ShadowScratch
    lines: NDArray[np.float32]
    x: NDArray[np.float32]
    y: NDArray[np.float32]
    red: NDArray[np.float32]
    green: NDArray[np.float32]
    blue: NDArray[np.float32]
    sample: NDArray[np.uint32]
    darkening: NDArray[np.float32]
    sun_lit: NDArray[np.float32]
    cosine: NDArray[np.float32]
    shining_first: NDArray[np.uint32]
    shining_last: NDArray[np.uint32]


def new_baked_scratch(width: int) -> BakedScratch:
    """Return scratch for rows of ``width`` pixels."""
    shadow, lines = new_shadow_scratch(width), new_lines(LIGHT_LINES, width)
    x, y, red, green, blue = lines.reshape(LIGHT_LINES, PITCH)[:, :width]
    dark, lit, cosine = np.empty((3, width), np.float32)
    sample, first, last = np.empty((3, width), np.uint32)
    return BakedScratch(shadow, lines, x, y, red, green, blue, sample, dark, lit, cosine, first, last)


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def add_up(weights: NDArray[np.float32], groups: NDArray[np.float32], total: NDArray[np.float32]) -> None:
    """Write ``sum of weights_g groups_g`` (N,) of groups (G, N)."""
    total[:] = ZERO
    # Piece by piece, so that the sums stay in the processor's cache.
    for first in range(0, total.shape[0], _SUMMED_AT_ONCE):
        piece = total[first : first + _SUMMED_AT_ONCE]
        for g in range(weights.shape[0]):
            values, weight = groups[g, first : first + _SUMMED_AT_ONCE], weights[g]
            if weight != ZERO:
                for n in range(piece.shape[0]):
                    piece[n] += weight * values[n]


@row_kernel(error_model="numpy")
def baked_row(
    light: BakedArrays, row: int, surfaces: SurfaceRow, scratch: BakedScratch, radiance: NDArray[np.float32]
) -> None:
    """Write the radiance (3, W) of one row."""
    shining, sunny_first, sunny_last = _light_runs(light, row, surfaces, scratch)
    _add_sunshine(light, row, surfaces.depth_m, scratch, sunny_first, sunny_last)
    reflect_row(surfaces.colour, np.uint32(0), scratch.red, radiance[0])
    reflect_row(surfaces.colour, np.uint32(8), scratch.green, radiance[1])
    reflect_row(surfaces.colour, np.uint32(16), scratch.blue, radiance[2])
    _show_shining(light, row, surfaces.instance_id, scratch, shining, radiance)


@row_kernel(error_model="numpy")
def _light_runs(
    light: BakedArrays, row: int, surfaces: SurfaceRow, scratch: BakedScratch
) -> tuple[int, np.uint64, np.uint64]:
    """Write the light on each run of pixels that show the same body, its share of the sun apart.

    Returns:
        number of runs that shine; columns that the sun may fall on: first, after the last.
    """
    # Columns are unsigned: signed indices would be checked for negative values.
    instance_id, width = surfaces.instance_id, np.uint64(surfaces.instance_id.shape[0])
    shining, sunny_first, sunny_last = 0, width, np.uint64(0)
    scratch.sun_lit[:] = ZERO
    scratch.cosine[:] = ONE
    first = np.uint64(0)
    while first < width:
        body = instance_id[first]
        last = first + np.uint64(1)
        while last < width and instance_id[last] == body:
            last += np.uint64(1)
        panel = light.panel[body] if body >= 0 else -1
        is_sunny = False
        if body < 0 or light.own_nit[body, 0] >= ZERO:
            scratch.shining_first[shining], scratch.shining_last[shining] = np.uint32(first), np.uint32(last)
            shining += 1
        elif panel >= 0:
            is_sunny = _light_panel(light, panel, row, first, last, surfaces.depth_m, scratch)
        else:
            is_sunny = _light_body(light, body, first, last, surfaces.normal, scratch)
        if is_sunny:
            sunny_first, sunny_last = min(sunny_first, first), last
        first = last
    return shining, sunny_first, sunny_last


@row_kernel(error_model="numpy")
def _light_panel(
    light: BakedArrays,
    panel: int,
    row: int,
    first: np.uint64,
    last: np.uint64,
    depth_m: NDArray[np.float32],
    scratch: BakedScratch,
) -> bool:
    """Write the light on a run of pixels of a panel; return whether the sun may fall on it."""
    sample, x, y = scratch.sample, scratch.x, scratch.y
    start, wide, high = light.maps[panel, 0], light.maps[panel, 1], light.maps[panel, 2]
    place_run(light.place, panel, row, start, wide, high, first, last, depth_m, sample, x, y)
    mix_light(light.light, wide, first, last, sample, scratch.lines)
    is_sunny = light.sun[1] > ZERO and light.sun_maps[panel, 1] > 0
    if is_sunny:
        start, wide, high = light.sun_maps[panel, 0], light.sun_maps[panel, 1], light.sun_maps[panel, 2]
        place_run(light.place, panel, row, start, wide, high, first, last, depth_m, sample, x, y)
        _fill(light.shadow_cosine[panel], first, last, scratch.cosine)
        mix_run(light.sun_share, wide, first, last, sample, x, y, light.sun_cosine[panel], scratch.sun_lit)
    dark, bright = np.uint64(light.contact_within[row, 0]), np.uint64(light.contact_within[row, 1])
    dark, bright = max(first, dark), min(last, bright)
    if light.is_floor[panel] and dark < bright:
        columns, rows = light.contact_columns, light.contact.shape[0] // light.contact_columns
        place_run(light.contact_place, 0, row, 0, columns, rows, dark, bright, depth_m, sample, x, y)
        mix_run(light.contact, columns, dark, bright, sample, x, y, ONE, scratch.darkening)
        _darken(scratch.darkening, dark, bright, scratch.red, scratch.green, scratch.blue)
    return is_sunny


@row_kernel(error_model="numpy")
def _light_body(
    light: BakedArrays, body: int, first: np.uint64, last: np.uint64, normal: NDArray[np.float32], scratch: BakedScratch
) -> bool:
    """Write the light on a run of pixels of a body that is no panel; return whether the sun may fall on it."""
    body_run(light.cubes, body, first, last, normal, scratch.red, scratch.green, scratch.blue)
    is_sunny = light.sun[1] > ZERO and light.body_sun[body] > ZERO
    if is_sunny:
        sun_on_body(light.towards_sun, light.body_sun[body], first, last, normal, scratch.cosine, scratch.sun_lit)
    return is_sunny


@row_kernel(error_model="numpy")
def _add_sunshine(
    light: BakedArrays, row: int, depth_m: NDArray[np.float32], scratch: BakedScratch, first: np.uint64, last: np.uint64
) -> None:
    """Add direct sunlight to columns first … last - 1, with the shadows of moving bodies."""
    sun_lit = scratch.sun_lit
    while first < last and sun_lit[first] == ZERO:
        first += np.uint64(1)
    while first < last and sun_lit[last - np.uint64(1)] == ZERO:
        last -= np.uint64(1)
    if first < last:
        lit = sun_lit[first:last]
        if light.casts:
            cosine = scratch.cosine[first:last]
            shadow_row(light.shadows, row, first, depth_m[first:last], cosine, scratch.shadow, lit)
        _add_sun(light.sun[0], lit, scratch.red[first:last])
        _add_sun(light.sun[1], lit, scratch.green[first:last])
        _add_sun(light.sun[2], lit, scratch.blue[first:last])


@row_kernel(error_model="numpy")
def _show_shining(
    light: BakedArrays,
    row: int,
    instance_id: NDArray[np.int32],
    scratch: BakedScratch,
    shining: int,
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance of the runs that shine: bright areas, and the sky."""
    red, green, blue = radiance[0], radiance[1], radiance[2]
    for n in range(shining):
        first, last = np.uint64(scratch.shining_first[n]), np.uint64(scratch.shining_last[n])
        body = instance_id[first]
        if body < 0:
            sky_run(light.sky, light.rays, row, first, last, red, green, blue)
        else:
            _fill(light.own_nit[body, 0], first, last, red)
            _fill(light.own_nit[body, 1], first, last, green)
            _fill(light.own_nit[body, 2], first, last, blue)


@row_kernel()
def _fill(value: np.float32, first: np.uint64, last: np.uint64, line: NDArray[np.float32]) -> None:
    for k in range(first, last):
        line[k] = value


@row_kernel()
def _darken(
    factor: NDArray[np.float32],
    first: np.uint64,
    last: np.uint64,
    red: NDArray[np.float32],
    green: NDArray[np.float32],
    blue: NDArray[np.float32],
) -> None:
    for k in range(first, last):
        red[k] *= factor[k]
        green[k] *= factor[k]
        blue[k] *= factor[k]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _add_sun(sun: np.float32, lit: NDArray[np.float32], radiance: NDArray[np.float32]) -> None:
    for k in range(radiance.shape[0]):
        radiance[k] += sun * lit[k]
