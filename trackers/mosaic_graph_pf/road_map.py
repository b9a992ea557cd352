"""Where the roads are: colours learnt where the target drove, found again all over the mosaic, thinned to a graph."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.colour_table import CELLS, count_colours, look_up
from trackers.kernels.skeleton import thin, trace_lines
from trackers.mosaic_graph_pf.colour_model import smooth_counts
from trackers.mosaic_graph_pf.mosaic import Mosaic
from trackers.mosaic_graph_pf.road_graph import RoadGraph, build_graph

_GRID_M = 0.5
_REACH_M = 120.0
_ROAD_SHARE = 0.25
_NARROWEST_M = 4.0
_CLOSING_M = 2.5
_NEAREST_REACH_M = 12.0
_SAMPLE_RADIUS_M = 1.3


@dataclass(frozen=True, eq=False)
class RoadMap:
    """Roads around the target as believed at one instant.

    Attributes:
        graph: centre lines.
        origin_m, cell_m: grid on the map, as ``Mosaic``'s.
        nearest: (H, W) int32, index of the centre-line point nearest to each cell; -1 further than 12 m away.
    """

    graph: RoadGraph
    origin_m: NDArray[np.float64]
    cell_m: float
    nearest: NDArray[np.int32]


class RoadFinder:
    """Learns the colour of the road and draws ``RoadMap``s."""

    def __init__(self) -> None:
        self._road_counts = np.zeros(CELLS, np.float32)

    def learn(self, mosaic: Mosaic, driven_m: NDArray[np.float64]) -> None:
        """Take the ground around a map point (2,) that the target has driven over, and left, as road."""
        centre = mosaic.cells_of(driven_m[None])[0]
        radius = int(np.ceil(_SAMPLE_RADIUS_M / mosaic.cell_m))
        column, row = centre
        if min(row, column) < radius:
            return
        patch = mosaic.rgb[row - radius : row + radius + 1, column - radius : column + radius + 1]
        seen = mosaic.count[row - radius : row + radius + 1, column - radius : column + radius + 1] > 0
        count_colours(self._road_counts, patch, seen.astype(np.float32), 1)

    def road_probability(
        self, mosaic: Mosaic, centre_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.float64]]:
        """Return, on a grid of 0.5 m around a map point: the probability of road (H, W), which cells were seen, and the grid's
        origin (2,)."""
        low = np.maximum(mosaic.cells_of(centre_m[None] - _REACH_M)[0], 0)
        high = np.minimum(mosaic.cells_of(centre_m[None] + _REACH_M)[0], mosaic.count.shape[::-1])
        cells = slice(low[1], high[1]), slice(low[0], high[0])
        size = tuple(np.maximum(((high - low) * mosaic.cell_m / _GRID_M).astype(int), 4).tolist())
        rgb = cv2.resize(mosaic.rgb[cells], size, interpolation=cv2.INTER_AREA)
        seen = cv2.resize(mosaic.count[cells], size, interpolation=cv2.INTER_NEAREST) > 0
        everything = np.zeros(CELLS, np.float32)
        count_colours(everything, rgb, seen.astype(np.float32), 2)
        road, everything = smooth_counts(self._road_counts), smooth_counts(everything)
        table = _ROAD_SHARE * road / np.maximum(everything, 1e-9)
        probability = np.minimum(look_up(table.astype(np.float32), rgb), 1.0) * seen
        return probability, seen, mosaic.origin_m + low * mosaic.cell_m

    def draw(self, mosaic: Mosaic, centre_m: NDArray[np.float64]) -> RoadMap:
        """Return the roads within 120 m of a map point."""
        probability, _, origin_m = self.road_probability(mosaic, centre_m)
        mask = _road_mask(probability)
        cells, offsets = trace_lines(thin(mask))
        points = origin_m + _GRID_M * (cells[:, ::-1] + 0.5)
        lines = [points[a:b] for a, b in zip(offsets[:-1], offsets[1:], strict=True)]
        graph = build_graph(lines)
        return RoadMap(graph, *_nearest_points(graph, centre_m))


def _road_mask(probability: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return where a car's width of road is (H, W): lines and small spots closed, what is narrower than a lane opened away."""
    mask = (cv2.GaussianBlur(probability, (0, 0), 0.8 / _GRID_M) > 0.4).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _disc(_CLOSING_M))
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, _disc(_NARROWEST_M))
    mask[[0, -1], :] = mask[:, [0, -1]] = 0
    return mask


def _disc(diameter_m: float) -> NDArray[np.uint8]:
    size = int(round(diameter_m / _GRID_M)) | 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))


def _nearest_points(
    graph: RoadGraph, centre_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float, NDArray[np.int32]]:
    """Return origin, cell size and, for every cell around ``centre_m``, the nearest centre-line point of the graph."""
    cell_m = 1.0
    reach_m = _REACH_M + 60.0
    side = int(2 * reach_m / cell_m)
    origin_m = centre_m - reach_m
    free = np.full((side, side), 255, np.uint8)
    index_of_label = np.full(len(graph.points_m) + 1, -1, np.int32)
    nearest = np.full((side, side), -1, np.int32)
    cells = np.floor((graph.points_m - origin_m) / cell_m).astype(int)
    inside = ((cells >= 0) & (cells < side)).all(axis=1)
    if not inside.any():
        return origin_m, cell_m, nearest
    free[cells[inside, 1], cells[inside, 0]] = 0
    distance, labels = cv2.distanceTransformWithLabels(
        free, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    index_of_label[labels[cells[inside, 1], cells[inside, 0]]] = np.flatnonzero(inside)
    near = distance < _NEAREST_REACH_M / cell_m
    nearest[near] = index_of_label[labels[near]]
    return origin_m, cell_m, nearest
