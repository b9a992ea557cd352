"""Roads as arrays for kernels: a graph of centre lines, and a grid of its nearest points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SPACING_M = 1.0
"""Distance between the points of a centre line."""


class RoadGraph(NamedTuple):
    """Estimated centre lines. The points of all edges are concatenated, ``SPACING_M`` apart.

    Attributes:
        points_m: (P, 2) centre lines; edge e has rows ``first[e]`` to ``first[e + 1]`` (not included), at least two.
        tangents: (P, 2) unit vectors from start to end.
        edge_of_point: (P,) edge of each point.
        first: (E + 1,), see above.
        ends: (E, 2) node at the start and at the end of every edge.
        node_first, node_edges, node_sides: the edges that meet in node n are
            ``node_edges[node_first[n]:node_first[n + 1]]``, with their start (side 0) or their end (side 1).
    """

    points_m: NDArray[np.float64]
    tangents: NDArray[np.float64]
    edge_of_point: NDArray[np.int64]
    first: NDArray[np.int64]
    ends: NDArray[np.int64]
    node_first: NDArray[np.int64]
    node_edges: NDArray[np.int64]
    node_sides: NDArray[np.int64]

    @property
    def edge_count(self) -> int:
        """Number of edges."""
        return len(self.first) - 1


class Roads(NamedTuple):
    """Estimated roads around the target.

    Attributes:
        graph: centre lines.
        origin_m, cell_m: grid on the map: (2,) corner of its first cell, and side of a cell.
        nearest: (H, W) int32, the graph's point nearest to each cell of the grid; -1 where none is near.
    """

    graph: RoadGraph
    origin_m: NDArray[np.float64]
    cell_m: float
    nearest: NDArray[np.int32]
