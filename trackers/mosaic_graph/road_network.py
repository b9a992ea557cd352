"""Where the roads are: colours learnt where the target drove, found again all over the mosaic, thinned to a
graph.
"""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.colour_model import smooth_counts
from trackers.mosaic_graph.kernels.colour_table import CELLS, count_colours, look_up
from trackers.mosaic_graph.kernels.roads import NO_ROADS, RoadGraph, Roads
from trackers.mosaic_graph.kernels.skeleton import thin, trace_lines
from trackers.mosaic_graph.mosaic import Mosaic
from trackers.mosaic_graph.road_graph import build_graph
from trackers.mosaic_graph.small_picture import draw_disc

_GRID_M = 0.5
_REACH_M = 120.0
_TYPICAL_QUANTILE = 0.5
_ROAD_PROBABILITY = 0.3
_NARROWEST_M = 5.0
_CLOSING_M = 2.5
_CONTINUED_M = 5.0
_NEAREST_REACH_M = 12.0
_SAMPLE_RADIUS_M = 1.3
_OFTEN_SEEN = 5
# Streets are of one colour but not worn alike: what was driven over counts also for brighter and darker asphalt.
_WEAR = np.linspace(-0.33, 0.33, 7)
_WEAR_DEVIATION = 0.2


class RoadFinder:
    """Learns the colour of the road from where the target drove, and draws ``Roads``s."""

    def __init__(self) -> None:
        self._driven_m: list[NDArray[np.float64]] = []

    @property
    def has_learnt(self) -> bool:
        """Whether any ground is known to be road."""
        return len(self._driven_m) > 0

    def learn(self, driven_m: NDArray[np.float64]) -> None:
        """Take the ground around a map point (2,) that the target has driven over, and left, as road."""
        self._driven_m.append(driven_m)

    def _probability(
        self, mosaic: Mosaic, low: NDArray[np.int64], high: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_], NDArray[np.float64]]:
        """Return the probability of road (H, W) on a grid of 0.5 m over the mosaic's cells (column, row) from ``low``
        to below ``high``, where it was seen (H, W), and the grid's origin (2,) on the map.

        ``p(road | colour) ~ p(colour | road) / p(colour)``, scaled so that the middle one of the pixels driven
        over has 1; 0 where nothing was seen.
        """
        cells = slice(low[1], high[1]), slice(low[0], high[0])
        size = tuple(np.maximum(((high - low) * mosaic.cell_m / _GRID_M).astype(int), 4).tolist())
        rgb = cv2.resize(mosaic.rgb[cells], size, interpolation=cv2.INTER_AREA)
        count = cv2.resize(mosaic.count[cells], size, interpolation=cv2.INTER_NEAREST)
        origin_m = mosaic.origin_m + low * mosaic.cell_m
        driven_rgb = rgb[self._driven_cells(count, origin_m)][None]
        everything, driven, road = np.zeros((3, CELLS), np.float32)
        count_colours(everything, rgb, (count > 0).astype(np.float32), 2)
        count_colours(driven, driven_rgb, np.ones(driven_rgb.shape[:2], np.float32), 1)
        for wear in _WEAR if driven_rgb.size else ():
            weight = np.full(driven_rgb.shape[:2], np.exp(-0.5 * (wear / _WEAR_DEVIATION) ** 2), np.float32)
            count_colours(road, cv2.convertScaleAbs(driven_rgb, alpha=float(np.exp(wear))), weight, 1)
        ratio = smooth_counts(road) / np.maximum(smooth_counts(everything), 1e-9)
        order = np.argsort(ratio)
        share = np.cumsum(driven[order]) / max(float(driven.sum()), 1.0)
        typical = ratio[order[min(int(np.searchsorted(share, _TYPICAL_QUANTILE)), CELLS - 1)]]
        table = np.minimum(ratio / max(float(typical), 1e-9), 1.0)
        # Cells at the edge of what was seen are mixed with nothing.
        seen = cv2.erode((count > 0).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
        return look_up(table.astype(np.float32), rgb) * seen, seen, origin_m

    def _driven_cells(self, count: NDArray[np.uint8], origin_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return the cells (H, W) that were driven over, but not those seen only while the target hid them."""
        driven = np.zeros(count.shape, np.uint8)
        for point_m in self._driven_m:
            draw_disc(driven, np.floor((point_m - origin_m) / _GRID_M), _SAMPLE_RADIUS_M / _GRID_M - 1, 1)
        return (driven > 0) & (count >= _OFTEN_SEEN)

    def draw(self, mosaic: Mosaic, centre_m: NDArray[np.float64]) -> Roads:
        """Return the roads within 120 m of a map point."""
        low = np.maximum(mosaic.cells_of(centre_m[None] - _REACH_M)[0], 0)
        high = np.minimum(mosaic.cells_of(centre_m[None] + _REACH_M)[0], mosaic.count.shape[::-1])
        if (high <= low).any():
            return NO_ROADS
        probability, seen, origin_m = self._probability(mosaic, low, high)
        mask = _road_mask(_continued(probability, seen))
        cells, offsets = trace_lines(thin(mask))
        points = origin_m + _GRID_M * (cells[:, ::-1] + 0.5)
        lines = [points[a:b] for a, b in pairwise(offsets)]
        graph = build_graph(lines, partial(_unseen, seen, origin_m))
        return roads_about(graph, centre_m)


def _unseen(seen: NDArray[np.bool_], origin_m: NDArray[np.float64], points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which map points (n, 2) lie where nothing was seen, of a grid (H, W) that begins at ``origin_m``."""
    cells = np.floor((points_m - origin_m) / _GRID_M).astype(int)
    inside = ((cells >= 0) & (cells < seen.shape[::-1])).all(axis=1)
    result = np.ones(len(points_m), np.bool_)
    result[inside] = ~seen[cells[inside, 1], cells[inside, 0]]
    return result


def _continued(probability: NDArray[np.float32], seen: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the probability (H, W) carried on a little way into the unseen, each cell taking that of the
    nearest seen one: a side street of which only the mouth was seen then reaches out of the crossing.
    """
    unseen = np.where(seen, 0, 255).astype(np.uint8)
    distance, label = cv2.distanceTransformWithLabels(
        unseen, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    value_of_label = np.zeros(int(label.max()) + 1, np.float32)
    value_of_label[label[seen]] = probability[seen]
    return np.where(distance * _GRID_M < _CONTINUED_M, value_of_label[label], 0.0).astype(np.float32)


def _road_mask(probability: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return where a car's width of road is (H, W): lines and small spots closed, what is narrower than a
    lane opened away.
    """
    mask = (cv2.GaussianBlur(probability, (0, 0), 0.8 / _GRID_M) > _ROAD_PROBABILITY).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _disc(_CLOSING_M))
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, _disc(_NARROWEST_M))
    mask[[0, -1], :] = mask[:, [0, -1]] = 0
    return mask


def _disc(diameter_m: float) -> NDArray[np.uint8]:
    size = round(diameter_m / _GRID_M) | 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))


def roads_about(graph: RoadGraph, centre_m: NDArray[np.float64]) -> Roads:
    """Return a graph with its nearest points to the cells about ``centre_m`` (2,), up to 12 m away from it."""
    cell_m = 1.0
    reach_m = _REACH_M + 60.0
    side = int(2 * reach_m / cell_m)
    origin_m = centre_m - reach_m
    nearest = np.full((side, side), -1, np.int32)
    roads = Roads(graph, origin_m, cell_m, nearest)
    cells = np.floor((graph.points_m - origin_m) / cell_m).astype(int)
    inside = ((cells >= 0) & (cells < side)).all(axis=1)
    if not inside.any():
        return roads
    free = np.full((side, side), 255, np.uint8)
    free[cells[inside, 1], cells[inside, 0]] = 0
    distance, labels = cv2.distanceTransformWithLabels(
        free, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    index_of_label = np.full(len(graph.points_m) + 1, -1, np.int32)
    index_of_label[labels[cells[inside, 1], cells[inside, 0]]] = np.flatnonzero(inside)
    near = distance < _NEAREST_REACH_M / cell_m
    nearest[near] = index_of_label[labels[near]]
    return roads
