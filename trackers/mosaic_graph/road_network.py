"""Roads in the mosaic: colours learnt where the target drove, classified over the mosaic, thinned to a graph."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.mosaic_graph.colour_model import CELLS, count_colours, look_up, smooth_counts
from trackers.mosaic_graph.kernels.road_position import RoadGraph, Roads
from trackers.mosaic_graph.kernels.skeleton import thin, trace_lines
from trackers.mosaic_graph.mosaic import Mosaic, draw_disc
from trackers.mosaic_graph.road_graph import RoadSketch, build_graph

GRID_M = 0.5
"""Side of a cell of the grid of roads."""
_REACH_M = 120.0
_TYPICAL_QUANTILE = 0.5
_ROAD_PROBABILITY = 0.3
_NARROWEST_M = 5.0
_CLOSING_M = 2.5
_CONTINUED_M = 5.0
_NEAREST_REACH_M = 12.0
_SAMPLE_RADIUS_M = 1.3
_OFTEN_SEEN = 5
# Asphalt differs in wear: the colours driven over are also counted brighter and darker.
_WEAR = np.linspace(-0.33, 0.33, 7)
_WEAR_DEVIATION = 0.2


@dataclass(frozen=True, eq=False)
class SeenGround:
    """A part of a mosaic, in cells of ``GRID_M``.

    Attributes:
        origin_m: (2,) map position of the corner of cell (0, 0).
        rgb: (H, W, 3) uint8; 0 where nothing was seen. count: (H, W) uint8, see ``Mosaic``.
        seen: (H, W) whether the picture of a cell is whole: at the edge of what was seen it is mixed with black.
    """

    origin_m: NDArray[np.float64]
    rgb: NDArray[np.uint8]
    count: NDArray[np.uint8]
    seen: NDArray[np.bool_]


def seen_ground(mosaic: Mosaic, centre_m: NDArray[np.float64]) -> SeenGround | None:
    """Return what a mosaic holds within 120 m of a map point (2,), None if nothing."""
    low = np.maximum(mosaic.cells_of(centre_m[None] - _REACH_M)[0], 0)
    high = np.minimum(mosaic.cells_of(centre_m[None] + _REACH_M)[0], mosaic.count.shape[::-1])
    if (high <= low).any():
        return None
    cells = slice(low[1], high[1]), slice(low[0], high[0])
    size = tuple(np.maximum(((high - low) * mosaic.cell_m / GRID_M).astype(int), 4).tolist())
    rgb = cv2.resize(mosaic.rgb[cells], size, interpolation=cv2.INTER_AREA)
    count = cv2.resize(mosaic.count[cells], size, interpolation=cv2.INTER_NEAREST)
    seen = cv2.erode((count > 0).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    return SeenGround(mosaic.origin_m + low * mosaic.cell_m, rgb, count, seen)


class RoadFinder(ABC):
    """Draws ``Roads`` on ground of which it says how likely it is road; see ``RoadSource``."""

    has_learnt = True

    def learn(self, driven_m: NDArray[np.float64]) -> None:  # noqa: B027
        """Take in a map point (2,) that the target has left."""

    @abstractmethod
    def probability(self, ground: SeenGround) -> NDArray[np.float32]:
        """Return the probability of road (H, W) of ground; that of cells that were not seen does not count."""

    def draw(self, mosaic: Mosaic, centre_m: NDArray[np.float64]) -> Roads:
        """Return the roads within 120 m of a map point."""
        ground = seen_ground(mosaic, centre_m)
        if ground is None:
            return NO_ROADS
        mask = _road_mask(_continued(self.probability(ground) * ground.seen, ground.seen))
        cells, offsets = trace_lines(thin(mask))
        points = ground.origin_m + GRID_M * (cells[:, ::-1] + 0.5)
        lines = [points[a:b] for a, b in pairwise(offsets)]
        graph = build_graph(lines, partial(_unseen, ground))
        return roads_about(graph, centre_m)


class ColourRoads(RoadFinder):
    """Learns the colours of roads where the target drove."""

    def __init__(self) -> None:
        self._driven_m: list[NDArray[np.float64]] = []

    @property
    def has_learnt(self) -> bool:  # type: ignore[override]
        """Whether any ground has been learnt as road."""
        return len(self._driven_m) > 0

    def learn(self, driven_m: NDArray[np.float64]) -> None:
        """Learn the ground around a map point (2,), which the target has left, as road."""
        self._driven_m.append(driven_m)

    def probability(self, ground: SeenGround) -> NDArray[np.float32]:
        """See ``RoadFinder``.

        ``p(road | colour) ~ p(colour | road) / p(colour)``, scaled to 1 at the median of the pixels driven over.
        """
        driven_rgb = ground.rgb[self._driven_cells(ground)][None]
        everything, driven, road = np.zeros((3, CELLS), np.float32)
        count_colours(everything, ground.rgb, (ground.count > 0).astype(np.float32), 2)
        count_colours(driven, driven_rgb, np.ones(driven_rgb.shape[:2], np.float32), 1)
        for wear in _WEAR if driven_rgb.size else ():
            weight = np.full(driven_rgb.shape[:2], np.exp(-0.5 * (wear / _WEAR_DEVIATION) ** 2), np.float32)
            count_colours(road, cv2.convertScaleAbs(driven_rgb, alpha=float(np.exp(wear))), weight, 1)
        ratio = smooth_counts(road) / np.maximum(smooth_counts(everything), 1e-9)
        order = np.argsort(ratio)
        share = np.cumsum(driven[order]) / max(float(driven.sum()), 1.0)
        typical = ratio[order[min(int(np.searchsorted(share, _TYPICAL_QUANTILE)), CELLS - 1)]]
        table = np.minimum(ratio / max(float(typical), 1e-9), 1.0)
        return look_up(table.astype(np.float32), ground.rgb)

    def _driven_cells(self, ground: SeenGround) -> NDArray[np.bool_]:
        """Return the cells (H, W) that the target drove over and that were seen often enough without it."""
        driven = np.zeros(ground.count.shape, np.uint8)
        for point_m in self._driven_m:
            draw_disc(driven, np.floor((point_m - ground.origin_m) / GRID_M), _SAMPLE_RADIUS_M / GRID_M - 1, 1)
        return (driven > 0) & (ground.count >= _OFTEN_SEEN)


def _unseen(ground: SeenGround, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether each map point (n, 2) was not seen."""
    cells = np.floor((points_m - ground.origin_m) / GRID_M).astype(int)
    inside = ((cells >= 0) & (cells < ground.seen.shape[::-1])).all(axis=1)
    result = np.ones(len(points_m), np.bool_)
    result[inside] = ~ground.seen[cells[inside, 1], cells[inside, 0]]
    return result


def _continued(probability: NDArray[np.float32], seen: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the probability (H, W), extended by 5 m into unseen cells, each with the value of the nearest seen one.

    A side street of which only the mouth was seen then reaches out of the crossing.
    """
    nearest, distance = _nearest(probability, seen)
    return np.where(distance * GRID_M < _CONTINUED_M, nearest, 0.0).astype(np.float32)


def _nearest(values: NDArray[Any], known: NDArray[np.bool_]) -> tuple[NDArray[Any], NDArray[np.float32]]:
    """Return the value (H, W) of the known cell nearest to each cell, and the distance (H, W) to it in cells."""
    unknown = np.where(known, 0, 255).astype(np.uint8)
    distance, label = cv2.distanceTransformWithLabels(
        unknown, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    value_of_label = np.zeros(int(label.max()) + 1, values.dtype)
    value_of_label[label[known]] = values[known]
    return value_of_label[label], distance


def _road_mask(probability: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the mask (H, W) of road: gaps such as lane markings closed, parts narrower than a lane removed."""
    mask = (cv2.GaussianBlur(probability, (0, 0), 0.8 / GRID_M) > _ROAD_PROBABILITY).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, _disc(_CLOSING_M))
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, _disc(_NARROWEST_M))
    mask[[0, -1], :] = mask[:, [0, -1]] = 0
    return mask


def _disc(diameter_m: float) -> NDArray[np.uint8]:
    size = round(diameter_m / GRID_M) | 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))


def roads_about(graph: RoadGraph, centre_m: NDArray[np.float64]) -> Roads:
    """Return a graph with a grid around ``centre_m`` (2,) of its nearest points, up to 12 m away from them."""
    cell_m = 1.0
    reach_m = _REACH_M + 60.0
    side = int(2 * reach_m / cell_m)
    origin_m = centre_m - reach_m
    cells = np.floor((graph.points_m - origin_m) / cell_m).astype(int)
    inside = ((cells >= 0) & (cells < side)).all(axis=1)
    points = np.full((side, side), -1, np.int32)
    points[cells[inside, 1], cells[inside, 0]] = np.flatnonzero(inside)
    nearest, distance = _nearest(points, points >= 0)
    nearest[distance >= _NEAREST_REACH_M / cell_m] = -1
    return Roads(graph, origin_m, cell_m, nearest)


NO_ROADS = Roads(RoadSketch([]).finished(), np.zeros(2), 1.0, np.full((1, 1), -1, np.int32))
