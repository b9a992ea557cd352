"""Roads as arrays that kernels take: a graph of centre lines, and which of its points is nearest to a place."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SPACING_M = 1.0
"""Distance between the points of a centre line."""


class RoadGraph(NamedTuple):
    """Roads as they are believed to run. All points of all edges lie one after the other, ``SPACING_M`` apart.

    Attributes:
        points_m: (P, 2) centre lines; edge e holds rows ``first[e]`` to ``first[e + 1]`` (not included), at least two.
        tangents: (P, 2) unit vectors from start to end.
        edge_of_point: (P,).
        first: (E + 1,).
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
    """Roads around the target as believed at one instant.

    Attributes:
        graph: centre lines.
        origin_m, cell_m: grid on the map: (2,) of its first cell's corner, and the width of a cell.
        nearest: (H, W) int32, the graph's point nearest to each cell of the grid; -1 where none is near.
    """

    graph: RoadGraph
    origin_m: NDArray[np.float64]
    cell_m: float
    nearest: NDArray[np.int32]


NO_ROADS = Roads(
    RoadGraph(
        points_m=np.zeros((0, 2)),
        tangents=np.zeros((0, 2)),
        edge_of_point=np.zeros(0, np.int64),
        first=np.zeros(1, np.int64),
        ends=np.zeros((0, 2), np.int64),
        node_first=np.zeros(1, np.int64),
        node_edges=np.zeros(0, np.int64),
        node_sides=np.zeros(0, np.int64),
    ),
    origin_m=np.zeros(2),
    cell_m=1.0,
    nearest=np.full((1, 1), -1, np.int32),
)
