"""Edges of the inner picture's depth map, and the parts of the picture whose bent rays may end at one."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel
from sim.render.water_rays import ALONG_X, ALONG_Y, STEP_PX, SURFACE_DEPTH, ZERO, WaterRays, floor_depth

TILE = 8
"""Side of the tiles of the inner picture that have an edge or none."""
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
        for row in range(tile_row * TILE, min(tile_row * TILE + TILE, rows)):
            above, here, below = nearness[max(row - 1, 0)], nearness[row], nearness[min(row + 1, rows - 1)]
            if 0 < row < rows - 1:
                for k in range(columns):
                    fold = np.abs(above[k] + below[k] - np.float32(2.0) * here[k]) - jump_m * here[k] * here[k]
                    worst[k] = max(worst[k], fold)
            for k in range(1, columns - 1):
                fold = np.abs(here[k - 1] + here[k + 1] - np.float32(2.0) * here[k]) - jump_m * here[k] * here[k]
                worst[k] = max(worst[k], fold)
        for tile in range(edges.shape[1]):
            for k in range(tile * TILE, min(tile * TILE + TILE, columns)):
                edges[tile_row, tile] |= worst[k] > ZERO


@row_kernel(error_model="numpy")
def find_near_edges(
    rays: WaterRays,
    edges: NDArray[np.bool_],
    wet: NDArray[np.bool_],
    margin_x: int,
    margin_y: int,
    near_edge: NDArray[np.bool_],
) -> None:
    """Mark the tiles of the picture whose rays pass a tile with an edge on their way to the floor, and those partly in
    the water.
    """
    nodes = rays.nodes
    for tile_row in range(near_edge.shape[0]):
        for tile in range(near_edge.shape[1]):
            left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
            for corner in range(4):
                i, j = NODES * (tile_row + corner // 2), NODES * (tile + corner % 2)
                i, j = min(i, nodes.shape[1] - 1), min(j, nodes.shape[2] - 1)
                x, y = STEP_PX * j, STEP_PX * i
                z, ex, ey = nodes[SURFACE_DEPTH, i, j], nodes[ALONG_X, i, j], nodes[ALONG_Y, i, j]
                share = 1.0 - z / floor_depth(rays, x, y, z, ex, ey)
                left, right = min(left, x, x + share * ex), max(right, x, x + share * ex)
                top, bottom = min(top, y, y + share * ey), max(bottom, y, y + share * ey)
            first, last = max(int(left + 0.5 + margin_x) // TILE, 0), int(right + 0.5 + margin_x) // TILE
            upper, lower = max(int(top + 0.5 + margin_y) // TILE, 0), int(bottom + 0.5 + margin_y) // TILE
            i, j = NODES * tile_row, NODES * tile
            for node in range((NODES + 1) ** 2):
                other = wet[
                    min(i + node // (NODES + 1), wet.shape[0] - 1), min(j + node % (NODES + 1), wet.shape[1] - 1)
                ]
                near_edge[tile_row, tile] |= other != wet[i, j]
            for i in range(upper, min(lower + 1, edges.shape[0])):
                for j in range(first, min(last + 1, edges.shape[1])):
                    near_edge[tile_row, tile] |= edges[i, j]
