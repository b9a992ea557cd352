"""Small bright things in the picture that are no surfaces: lamps seen directly, their mirror images, flakes and drops.

A speck is an ellipse of pixels with the weight ``(1 - q²)²``, q the distance from its middle over that of its edge. It
adds light, or takes the place of what lies behind.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.optics import Camera, project
from sim.render.compilation import row_kernel


class Column(IntEnum):
    """Columns of a table of specks."""

    X = 0
    Y = 1
    AHEAD_X = 2
    """Unit vector of the longer axis: AHEAD_X and AHEAD_Y."""
    AHEAD_Y = 3
    LONG = 4
    SHORT = 5
    """Half axes in pixels."""
    COVER = 6
    """Share of what lies behind that the middle hides: 0 for light that is added."""
    RED = 7
    GREEN = 8
    BLUE = 9
    """Luminance in the middle, cd/m²."""
    DEPTH = 10
    """What is nearer hides it; 0: nothing does."""
    MIRRORED = 11
    """1: a mirror image, seen where the ground is under water, 0: the thing itself."""


X, Y, AHEAD_X, AHEAD_Y, LONG, SHORT, COVER, RED, GREEN, BLUE, DEPTH, MIRRORED = (int(each) for each in Column)
COLUMNS = len(Column)
ONE, ZERO, HALF = np.float32(1.0), np.float32(0.0), np.float32(0.5)
_BEHIND_M = np.float32(0.35)
_ON_GROUND_M = np.float32(0.12)


class Specks(NamedTuple):
    """Specks of one picture.

    Attributes:
        table: (K, 12) float32, columns as in ``Column``.
        first, number: (H + 1,) and (M,) int32: ``number[first[row] : first[row + 1]]`` are those that touch a row.
    """

    table: NDArray[np.float32]
    first: NDArray[np.int32]
    number: NDArray[np.int32]


def specks_of(table: NDArray[np.float32], camera: Camera) -> Specks:
    """Return specks (K, 12) for kernels, those out of the picture left out."""
    reach = table[:, LONG]
    seen = (
        (table[:, X] > -reach)
        & (table[:, X] < camera.width_px + reach)
        & (table[:, Y] > -reach)
        & (table[:, Y] < camera.height_px + reach)
    )
    table = np.ascontiguousarray(table[seen], dtype=np.float32)
    first = np.zeros(camera.height_px + 1, np.int32)
    return Specks(table, first, _by_row(table, first))


@njit(cache=True)
def _by_row(table: NDArray[np.float32], first: NDArray[np.int32]) -> NDArray[np.int32]:
    """Write ``first`` and return ``number``, see ``Specks``."""
    height = first.shape[0] - 1
    rows = np.empty((table.shape[0], 2), np.int32)
    for k in range(table.shape[0]):
        ahead, aside = table[k, LONG] * table[k, AHEAD_Y], table[k, SHORT] * table[k, AHEAD_X]
        reach = np.sqrt(ahead * ahead + aside * aside)
        rows[k, 0] = max(int(np.ceil(table[k, Y] - reach - 0.5)), 0)
        rows[k, 1] = max(min(int(np.floor(table[k, Y] + reach - 0.5)) + 1, height), rows[k, 0])
        for row in range(rows[k, 0], rows[k, 1]):
            first[row + 1] += 1
    for row in range(height):
        first[row + 1] += first[row]
    number, filled = np.empty(first[height], np.int32), first.copy()
    for k in range(table.shape[0]):
        for row in range(rows[k, 0], rows[k, 1]):
            number[filled[row]] = k
            filled[row] += 1
    return number


def round_specks(
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    places_m: NDArray[np.float64],
    radius_px: NDArray[np.float64] | float,
    nit: NDArray[np.float64],
    *,
    mirrored: bool = False,
) -> NDArray[np.float32]:
    """Return a table (K, 12) of round specks that add light (K, 3) at world places (K, 3); NaN behind the camera.

    Args:
        mirrored: the places are mirror images below the ground.
    """
    pixels, depth_m = project(camera, T_world_camera, places_m)
    table = np.zeros((len(places_m), COLUMNS), np.float32)
    table[:, [X, Y]], table[:, AHEAD_X] = pixels, 1.0
    table[:, LONG] = table[:, SHORT] = radius_px
    table[:, RED : BLUE + 1], table[:, DEPTH], table[:, MIRRORED] = nit, depth_m, mirrored
    return table


@row_kernel(fastmath={"contract", "arcp", "nsz", "afn"}, error_model="numpy")
def speck_row(
    specks: Specks,
    row: int,
    behind: bool,
    depth_m: NDArray[np.float32],
    height_m: NDArray[np.float32],
    film: NDArray[np.float32],
    radiance: NDArray[np.float32],
) -> None:
    """Add specks to the radiance (3, W) of a row.

    Args:
        behind: those that air and surfaces hide, else those directly before the camera.
        height_m: of surfaces above the ground. film: share of water on them, times what it mirrors.
    """
    width = radiance.shape[1]
    for index in range(specks.first[row], specks.first[row + 1]):
        k = specks.number[index]
        far, cover, mirrored = specks.table[k, DEPTH], specks.table[k, COVER], specks.table[k, MIRRORED] > ZERO
        if (far > ZERO) != behind:
            continue
        x, dy = specks.table[k, X], np.float32(row) + HALF - specks.table[k, Y]
        ax, ay = specks.table[k, AHEAD_X], specks.table[k, AHEAD_Y]
        along, across = ONE / specks.table[k, LONG], ONE / specks.table[k, SHORT]
        reach = np.sqrt((specks.table[k, LONG] * ax) ** 2 + (specks.table[k, SHORT] * ay) ** 2)
        first, last = max(int(x - reach), 0), min(int(x + reach) + 1, width)
        for column in range(first, last):
            dx = np.float32(column) + HALF - x
            u, v = (dx * ax + dy * ay) * along, (dy * ax - dx * ay) * across
            w = max(ONE - u * u - v * v, ZERO)
            w *= w
            if mirrored:
                w *= film[column] if height_m[column] < _ON_GROUND_M else ZERO
            elif behind and depth_m[column] < far - _BEHIND_M:
                w = ZERO
            kept = ONE - cover * w
            for channel in range(3):
                radiance[channel, column] = kept * radiance[channel, column] + w * specks.table[k, RED + channel]
