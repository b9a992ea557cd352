"""The kernels of ``sim.shaders.baked.shader``, a row of pixels at a time.

A row is a few *runs* of pixels that show the same body. On a panel, the shares u and v of its sides are ``depth (base +
step column) + offset``; its map of light is looked up between four samples. Loops that compute, fetch and mix stand
apart, so that the first and the last become vector code.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.runs import PITCH, new_bench
from sim.shaders.baked.panel_kernels import BENCH_LINES, mix_light, mix_run, place_run
from sim.shaders.daylight_kernels import reflect_row, shadow_row

if TYPE_CHECKING:
    from sim.shaders.daylight import ShadowArrays

ROOM_ROWS, AT_ROWS = 9, 4
"""Rows of the two arrays that ``baked_row`` works in."""
ONE, ZERO = np.float32(1.0), np.float32(0.0)
_SUMMED_AT_ONCE = 2048


class BakedArrays(NamedTuple):
    """Light in one picture as the kernels read it: of B bodies, R panels; float32 but for numbers of things.

    What falls on surfaces is in lux over pi: the radiance of a white one.

    Attributes:
        panel: (B,) int32, number of the panel that a body shows, -1 for none.
        own_nit: (B, 3) luminances of bright areas, -1 for bodies that do not shine.
        place: (R, 8), base, step a column, step a row and offset of u, and those of v.
        maps: (R, 3) int32, first sample, columns and rows of each panel in light: (T, 4) R, G, B and nothing.
        sun_maps: (R, 3) int32, the same in sun_share: (S,); no columns where there is no sun.
        sun_cosine: (R,). sun: (3,) on a surface square to it. towards_sun: (3,) unit vector.
        casts: whether anything that moves may stand in the sun.
        cubes: (B, 6, 3) ambient cubes. body_sun: (B,) share of the sun that arrives.
        is_floor: (R,) bool, things that move darken it by ``contact`` around them: (C,), rows of ``contact_columns``.
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
    sun: NDArray[np.float32]
    towards_sun: NDArray[np.float32]
    casts: bool
    cubes: NDArray[np.float32]
    body_sun: NDArray[np.float32]
    is_floor: NDArray[np.bool_]
    contact: NDArray[np.float32]
    contact_columns: int
    contact_place: NDArray[np.float32]
    contact_within: NDArray[np.int32]
    sky: NDArray[np.float32]
    rays: NDArray[np.float32]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def add_up(weights: NDArray[np.float32], groups: NDArray[np.float32], total: NDArray[np.float32]) -> None:
    """Write ``sum of weights_g groups_g`` (N,) of groups (G, N)."""
    total[:] = ZERO
    # Piece by piece: sums stay in the processor's nearest memory meanwhile.
    for first in range(0, total.shape[0], _SUMMED_AT_ONCE):
        piece = total[first : first + _SUMMED_AT_ONCE]
        for g in range(weights.shape[0]):
            values, weight = groups[g, first : first + _SUMMED_AT_ONCE], weights[g]
            if weight != ZERO:
                for n in range(piece.shape[0]):
                    piece[n] += weight * values[n]


@njit(cache=True)
def shade_baked_picture(
    light: BakedArrays,
    shadows: ShadowArrays,
    base_colour_rgb: NDArray[np.uint8],
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    normal_world: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance (H, 3, W) of a G-buffer's arrays (H, W) or (H, W, 3)."""
    width = depth_m.shape[1]
    room, at = np.empty((ROOM_ROWS, width), np.float32), np.empty((AT_ROWS, width), np.uint32)
    colour, normal = np.empty(width, np.uint32), np.empty((3, width), np.float32)
    bench = new_bench(BENCH_LINES, width)
    for row in range(depth_m.shape[0]):
        for column in range(width):
            colour[column] = (
                np.uint32(base_colour_rgb[row, column, 0])
                | np.uint32(base_colour_rgb[row, column, 1]) << np.uint32(8)
                | np.uint32(base_colour_rgb[row, column, 2]) << np.uint32(16)
            )
            for k in range(3):
                normal[k, column] = normal_world[row, column, k]
        baked_row(light, shadows, row, colour, depth_m[row], instance_id[row], normal, room, at, bench, radiance[row])


@row_kernel(error_model="numpy")
def baked_row(
    light: BakedArrays,
    shadows: ShadowArrays,
    row: int,
    colour: NDArray[np.uint32],
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    normal: NDArray[np.float32],
    room: NDArray[np.float32],
    at: NDArray[np.uint32],
    bench: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Write the radiance (3, W) of one row.

    Args:
        colour: (W,) base colours, ``R | G << 8 | B << 16``.
        normal: (3, >= W).
        room, at: (``ROOM_ROWS``, W) and (``AT_ROWS``, W) to work in.
        bench: of ``BENCH_LINES`` lines to work in, see ``sim.render.runs``.
    """
    width = np.uint64(depth_m.shape[0])
    # Views are made here, once a row: making one costs more than a short run. Numbers of columns are unsigned: signed
    # ones would be checked for counting from the end.
    x, y, factor = bench[:width], bench[PITCH : PITCH + width], room[0]
    sun_lit, cosine = room[7], room[8]
    index, shine_first, shine_last = at[0], at[2], at[3]
    red, green = bench[2 * PITCH : 2 * PITCH + width], bench[3 * PITCH : 3 * PITCH + width]
    blue = bench[4 * PITCH : 4 * PITCH + width]
    panels, own_nit, maps, sun_maps, body_sun = light.panel, light.own_nit, light.maps, light.sun_maps, light.body_sun
    place, samples, sun_share = light.place, light.light, light.sun_share
    contact, columns = light.contact, light.contact_columns
    rows = contact.shape[0] // columns
    row_dark, row_bright = np.uint64(light.contact_within[row, 0]), np.uint64(light.contact_within[row, 1])
    sun_shines = light.sun[1] > ZERO
    shining, sunny_first, sunny_last = 0, width, np.uint64(0)
    sun_lit[:] = ZERO
    cosine[:] = ONE
    first = np.uint64(0)
    while first < width:
        body = instance_id[first]
        last = first + np.uint64(1)
        while last < width and instance_id[last] == body:
            last += np.uint64(1)
        panel = panels[body] if body >= 0 else -1
        if body < 0 or own_nit[body, 0] >= ZERO:
            shine_first[shining], shine_last[shining] = np.uint32(first), np.uint32(last)
            shining += 1
        elif panel >= 0:
            start, wide, high = maps[panel, 0], maps[panel, 1], maps[panel, 2]
            place_run(place, panel, row, start, wide, high, first, last, depth_m, index, x, y)
            mix_light(samples, wide, first, last, index, bench)
            if sun_shines and sun_maps[panel, 1] > 0:
                sunny_first, sunny_last = min(sunny_first, first), last
                start, wide, high = sun_maps[panel, 0], sun_maps[panel, 1], sun_maps[panel, 2]
                place_run(place, panel, row, start, wide, high, first, last, depth_m, index, x, y)
                _fill(light.sun_cosine[panel], first, last, cosine)
                mix_run(sun_share, wide, first, last, index, x, y, light.sun_cosine[panel], sun_lit)
            dark, bright = max(first, row_dark), min(last, row_bright)
            if light.is_floor[panel] and dark < bright:
                place_run(light.contact_place, 0, row, 0, columns, rows, dark, bright, depth_m, index, x, y)
                mix_run(contact, columns, dark, bright, index, x, y, ONE, factor)
                _darken(factor, dark, bright, red, green, blue)
        else:
            _body_run(light.cubes, body, first, last, normal, red, green, blue)
            if sun_shines and body_sun[body] > ZERO:
                sunny_first, sunny_last = min(sunny_first, first), last
                _sun_on_body(light.towards_sun, body_sun[body], first, last, normal, cosine, sun_lit)
        first = last
    while sunny_first < sunny_last and sun_lit[sunny_first] == ZERO:
        sunny_first += np.uint64(1)
    while sunny_first < sunny_last and sun_lit[sunny_last - np.uint64(1)] == ZERO:
        sunny_last -= np.uint64(1)
    if sunny_first < sunny_last:
        lit = sun_lit[sunny_first:sunny_last]
        if light.casts:
            depth, cosine = depth_m[sunny_first:sunny_last], cosine[sunny_first:sunny_last]
            shadow_row(shadows, row, sunny_first, depth, cosine, room, at, lit)
        _add_sun(light.sun[0], lit, red[sunny_first:sunny_last])
        _add_sun(light.sun[1], lit, green[sunny_first:sunny_last])
        _add_sun(light.sun[2], lit, blue[sunny_first:sunny_last])
    reflect_row(colour, np.uint32(0), red, radiance[0])
    reflect_row(colour, np.uint32(8), green, radiance[1])
    reflect_row(colour, np.uint32(16), blue, radiance[2])
    red, green, blue = radiance[0], radiance[1], radiance[2]
    for n in range(shining):
        first, last = np.uint64(shine_first[n]), np.uint64(shine_last[n])
        body = instance_id[first]
        if body < 0:
            _sky_run(light.sky, light.rays, row, first, last, red, green, blue)
        else:
            _fill(own_nit[body, 0], first, last, red)
            _fill(own_nit[body, 1], first, last, green)
            _fill(own_nit[body, 2], first, last, blue)


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


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _body_run(
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
    cube = cubes[body]  # Taken out of the loop, so that it chooses between two numbers each and becomes vector code.
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
def _sun_on_body(
    towards_sun: NDArray[np.float32],
    share: np.float32,
    first: np.uint64,
    last: np.uint64,
    normal: NDArray[np.float32],
    cosine: NDArray[np.float32],
    sun_lit: NDArray[np.float32],
) -> None:
    """Write ``max(0, n . l)`` of pixels of a body, and that times the share of the sun that arrives."""
    for k in range(first, last):
        along = normal[0, k] * towards_sun[0] + normal[1, k] * towards_sun[1] + normal[2, k] * towards_sun[2]
        cosine[k] = max(along, ZERO)
        sun_lit[k] = share * cosine[k]


@row_kernel(fastmath={"contract", "arcp", "nsz"}, error_model="numpy")
def _sky_run(
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
