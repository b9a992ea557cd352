"""How likely a region's score is of an object, and of the background, learnt from pictures without objects."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.harbour_watch.detection import Region

_CELL_PX = 16
_BLUR_CELLS = 1.5
_PRIOR_REGIONS, _PRIOR_PICTURES = 0.02, 10.0
"""Regions a cell and picture that are expected before any training, and for how many pictures this counts."""
_RATE = 0.01
_PRIOR_TAIL, _PRIOR_WEIGHT = 0.7, 10.0
"""Decay of the scores of false regions above the least one, deviations, and its weight in regions (a Gaussian's tail
beyond 4 deviations decays by about a quarter of a deviation; waves and edges have heavier tails)."""
_OBJECT_TAIL = 12.0
"""Decay of the scores of objects above the least one, deviations: broad, from just visible to very hot."""


class Clutter:
    """Density of false regions by place and score."""

    def __init__(self, shape: tuple[int, int], least_score: float, pictures: Sequence[Sequence[Region]]) -> None:
        """``shape``: of the picture; ``pictures``: the regions found on each picture without objects."""
        cells = np.zeros((-(-shape[0] // _CELL_PX), -(-shape[1] // _CELL_PX)), np.float32)
        beyond = []
        for regions in pictures:
            for region in regions:
                cells[self._cell(region, cells.shape)] += 1.0
                beyond.append(region.score - least_score)
        n = max(len(pictures), 1)
        blurred = cv2.GaussianBlur(cells, (0, 0), _BLUR_CELLS, borderType=cv2.BORDER_REFLECT)
        self._per_cell = (blurred + _PRIOR_REGIONS * _PRIOR_PICTURES) / (n + _PRIOR_PICTURES)
        self._least_per_cell = float(self._per_cell.min())
        self._tail = (sum(min(each, 20.0) for each in beyond) + _PRIOR_TAIL * _PRIOR_WEIGHT) / (
            len(beyond) + _PRIOR_WEIGHT
        )
        self._least = least_score

    def learn(self, regions: Sequence[Region], claimed: NDArray[np.uint8]) -> None:
        """Take in the regions of a picture that no object claims: ``claimed`` (H, W)."""
        seen = np.zeros_like(self._per_cell)
        for region in regions:
            x0, _, x1, y1 = region.box_xyxy
            row, column = min(int(y1) - 1, len(claimed) - 1), min(int(0.5 * (x0 + x1)), claimed.shape[1] - 1)
            if not claimed[row, column]:
                seen[self._cell(region, seen.shape)] += 1.0
        blurred = cv2.GaussianBlur(seen, (0, 0), _BLUR_CELLS, borderType=cv2.BORDER_REFLECT) if seen.any() else seen
        self._per_cell += _RATE * (np.maximum(blurred, self._least_per_cell) - self._per_cell)

    @staticmethod
    def _cell(region: Region, shape: tuple[int, ...]) -> tuple[int, int]:
        x0, _, x1, y1 = region.box_xyxy
        row, column = int(y1 - 1) // _CELL_PX, int(0.5 * (x0 + x1)) // _CELL_PX
        return min(max(row, 0), shape[0] - 1), min(max(column, 0), shape[1] - 1)

    def log_ratio(self, region: Region) -> float:
        """Return log of (density of the score for an object / density of false regions of that score per pixel)."""
        beyond = max(region.score - self._least, 0.0)
        false = (
            np.log(self._per_cell[self._cell(region, self._per_cell.shape)] / _CELL_PX**2 / self._tail)
            - beyond / self._tail
        )
        return float(-np.log(_OBJECT_TAIL) - beyond / _OBJECT_TAIL - false)
