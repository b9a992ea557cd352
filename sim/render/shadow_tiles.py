"""Tiles of shadow maps: which of them are drawn, and the greatest heights of blocks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

BLOCK = 16
"""Side of the blocks of texels whose greatest height is kept; a power of two, as the shader requires."""
TILE = 2 * BLOCK
"""Side of the tiles of texels, each drawn when it is first needed."""
NOTHING = np.float32(-1e30)
"""Height in a texel without a caster."""


class MapArrays(NamedTuple):
    """A map of N x N texels, drawn in part.

    Attributes:
        fixed_m: (N, N) float32 heights of what never moves.
        height_m: (N, N) float32 heights of all.
        highest_m: (N / BLOCK, N / BLOCK) float32, the greatest height in each block of texels and the first row and
            column of the next ones.
        drawn: (n, n) bool, the tiles in which these are valid; the last ones may be cut.
        changed: (M, 4) boxes that movers cover.
        poses_drawn: (M, 4, 4) of the movers.
        is_current: (1,) False before the first drawing.
    """

    fixed_m: NDArray[np.float32]
    height_m: NDArray[np.float32]
    highest_m: NDArray[np.float32]
    drawn: NDArray[np.bool_]
    changed: NDArray[np.int64]
    poses_drawn: NDArray[np.float64]
    is_current: NDArray[np.bool_]


def new_map(size: int, mover_count: int) -> MapArrays:
    """Return a map of ``size`` x ``size`` texels in which nothing is drawn."""
    tiles, blocks = -(-size // TILE), size // BLOCK
    # Memory of zeros is allocated at the first write: most of a map never is written.
    return MapArrays(
        np.zeros((size, size), np.float32),
        np.zeros((size, size), np.float32),
        np.zeros((blocks, blocks), np.float32),
        np.zeros((tiles, tiles), np.bool_),
        np.zeros((mover_count, 4), np.int64),
        np.zeros((mover_count, 4, 4)),
        np.zeros(1, np.bool_),
    )


def forget(drawn_map: MapArrays) -> None:
    """Reset a map."""
    drawn_map.drawn[:], drawn_map.is_current[:], drawn_map.changed[:] = False, False, 0


@njit(cache=True)
def new_tiles(wanted: NDArray[np.bool_], drawn: NDArray[np.bool_], new: NDArray[np.bool_]) -> bool:
    """Set the tiles to draw: if one is missing, also the neighbours of the wanted ones, which are needed soon."""
    tiles = wanted.shape[0]
    missing = False
    for i in range(tiles):
        for j in range(tiles):
            missing |= wanted[i, j] and not drawn[i, j]
    if not missing:
        return False
    for i in range(tiles):
        for j in range(tiles):
            if wanted[i, j]:
                for row in range(max(i - 1, 0), min(i + 2, tiles)):
                    for column in range(max(j - 1, 0), min(j + 2, tiles)):
                        new[row, column] = not drawn[row, column]
    return True


@njit(cache=True)
def span_tiles(tiles: NDArray[np.bool_], size: int, spans: NDArray[np.int64]) -> None:
    """Write the first and the last but one column of texels (n, 2) of what is set in each row of tiles."""
    for i in range(tiles.shape[0]):
        spans[i, 0], spans[i, 1] = size, 0
        for j in range(tiles.shape[1]):
            if tiles[i, j]:
                spans[i, 0] = min(spans[i, 0], j * TILE)
                spans[i, 1] = min(j * TILE + TILE, size)


@njit(cache=True)
def fill_tiles(tiles: NDArray[np.bool_], height_m: NDArray[np.float32]) -> None:
    for i in range(tiles.shape[0]):
        for j in range(tiles.shape[1]):
            if tiles[i, j]:
                height_m[i * TILE : (i + 1) * TILE, j * TILE : (j + 1) * TILE] = NOTHING


@njit(cache=True)
def copy_tiles(
    tiles: NDArray[np.bool_], fixed_m: NDArray[np.float32], height_m: NDArray[np.float32], stale: NDArray[np.bool_]
) -> None:
    size = height_m.shape[0]
    box = np.empty(4, np.int64)
    for i in range(tiles.shape[0]):
        for j in range(tiles.shape[1]):
            if tiles[i, j]:
                box[0], box[1] = i * TILE, min(i * TILE + TILE, size)
                box[2], box[3] = j * TILE, min(j * TILE + TILE, size)
                height_m[box[0] : box[1], box[2] : box[3]] = fixed_m[box[0] : box[1], box[2] : box[3]]
                mark_blocks(box, stale)


@njit(cache=True)
def mark_blocks(changed: NDArray[np.int64], stale: NDArray[np.bool_]) -> None:
    """Set the blocks with texels in a box of rows and columns.

    A block ends with the first row and column of the next, so that it holds all of the 2x2 texels that begin in it.
    """
    if changed[0] >= changed[1] or changed[2] >= changed[3]:
        return
    for block_row in range(max(changed[0] - 1, 0) // BLOCK, (changed[1] - 1) // BLOCK + 1):
        for block_column in range(max(changed[2] - 1, 0) // BLOCK, (changed[3] - 1) // BLOCK + 1):
            stale[block_row, block_column] = True


@njit(cache=True, fastmath={"nnan", "nsz", "reassoc"})
def find_highest(height_m: NDArray[np.float32], stale: NDArray[np.bool_], highest_m: NDArray[np.float32]) -> None:
    """Write the greatest height of each block that is stale."""
    size = height_m.shape[0]
    for block_row in range(stale.shape[0]):
        for block_column in range(stale.shape[1]):
            if not stale[block_row, block_column]:
                continue
            first_row, first_column = block_row * BLOCK, block_column * BLOCK
            highest = NOTHING
            for row in range(first_row, min(first_row + BLOCK + 1, size)):
                line = height_m[row, first_column : min(first_column + BLOCK + 1, size)]
                for k in range(line.shape[0]):
                    highest = max(highest, line[k])
            highest_m[block_row, block_column] = highest
