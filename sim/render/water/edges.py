"""Edges of the inner picture's depth map, and the parts of the picture whose bent rays may end at one."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.water.rays import STEP_PX, ZERO
from sim.render.water.ways import ALONG_X, ALONG_Y, ENTRY_X, ENTRY_Y, FLOOR_SHARE

TILE, EDGE_TILE = 8, 4
"""Sides of the tiles of the picture whose rays are followed or not, and of those of the inner picture that have an edge
or none."""
NODES = TILE // STEP_PX
EDGE = 0.01
"""Share of the water's depth by which a surface must jump or fold to be an edge."""


@njit(cache=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
def find_edges(nearness: NDArray[np.float32], jump_m: np.float32, edges: NDArray[np.bool_]) -> None:
    """Mark the tiles where nearness, which is linear on a plane, is not: ``|n - 2 n' + n''| > jump n'²``."""
    rows, columns = nearness.shape
    worst = np.empty(columns, np.float32)
    for tile_row in range(edges.shape[0]):
        worst[:] = ZERO
        for row in range(tile_row * EDGE_TILE, min(tile_row * EDGE_TILE + EDGE_TILE, rows)):
            above, here, below = nearness[max(row - 1, 0)], nearness[row], nearness[min(row + 1, rows - 1)]
            if 0 < row < rows - 1:
                for k in range(columns):
                    fold = np.abs(above[k] + below[k] - np.float32(2.0) * here[k]) - jump_m * here[k] * here[k]
                    worst[k] = max(worst[k], fold)
            for k in range(1, columns - 1):
                fold = np.abs(here[k - 1] + here[k + 1] - np.float32(2.0) * here[k]) - jump_m * here[k] * here[k]
                worst[k] = max(worst[k], fold)
        for tile in range(edges.shape[1]):
            for k in range(tile * EDGE_TILE, min(tile * EDGE_TILE + EDGE_TILE, columns)):
                edges[tile_row, tile] |= worst[k] > ZERO


@row_kernel(error_model="numpy")
def find_near_edges(
    ways: NDArray[np.float32], edges: NDArray[np.bool_], kinds: NDArray[np.int8], near_edge: NDArray[np.bool_]
) -> None:
    """Mark the tiles of the picture whose rays pass a tile with an edge on their way to the floor, or are of two kinds.

    Args:
        kinds: (R, C) of the nodes.
    """
    rows, columns = kinds.shape
    for tile_row in range(near_edge.shape[0]):
        for tile in range(near_edge.shape[1]):
            left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
            first_i, first_j = min(NODES * tile_row, rows - 1), min(NODES * tile, columns - 1)
            last_i, last_j = min(first_i + NODES, rows - 1), min(first_j + NODES, columns - 1)
            is_near = False
            for i in range(first_i, last_i + 1):
                for j in range(first_j, last_j + 1):
                    is_near |= kinds[i, j] != kinds[first_i, first_j]
                    x, y, share = ways[ENTRY_X, i, j], ways[ENTRY_Y, i, j], ways[FLOOR_SHARE, i, j]
                    end_x, end_y = x + share * ways[ALONG_X, i, j], y + share * ways[ALONG_Y, i, j]
                    left, right = min(left, x, end_x), max(right, x, end_x)
                    top, bottom = min(top, y, end_y), max(bottom, y, end_y)
            first_row, last_row = max(int(top + 0.5) // EDGE_TILE, 0), int(bottom + 0.5) // EDGE_TILE
            first_column, last_column = max(int(left + 0.5) // EDGE_TILE, 0), int(right + 0.5) // EDGE_TILE
            for i in range(first_row, min(last_row + 1, edges.shape[0])):
                for j in range(first_column, min(last_column + 1, edges.shape[1])):
                    is_near |= edges[i, j]
            near_edge[tile_row, tile] = is_near
