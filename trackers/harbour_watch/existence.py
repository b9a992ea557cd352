"""How likely a region's score is of an object, and of the background, learnt from pictures without objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
_STRONG = 6.0
"""Deviations above the least score from which a false region is no chance of the noise but a body, e.g. a bird."""
_STRONG_REGIONS = 0.05
"""Strong false regions a picture, anywhere: pictures without objects are minutes apart, and between them sun and cloud
change more than from picture to picture; so this is not learnt."""
_LEAST_RESIDENT = 0.01
"""Regions of something moored that are expected anywhere, as if one picture more had shown them."""
_KERNEL, _KERNEL_LOG = 0.7, 0.5
"""Spread of such a region's place in units of its sides, and of the logarithms of these: it varies from day to day."""
_MOORED_SHARE = 0.2
"""Share of its pixels, on which something moored moves, from which a region shows that."""
_NEUTRAL_SHARE = 0.05
"""Share of pictures on which it moves from which on a region is no evidence."""
_RESIDENT_PX2 = 300.0
"""Area in which it moves about: a small boat's in the picture."""
_OBJECT_TAIL = 12.0
"""Decay of the scores of objects above the least one, deviations: broad, from just visible to very hot."""


@dataclass(frozen=True, eq=False)
class ClutterRates:
    """Rates of false regions, from pictures without objects.

    Attributes:
        per_cell: (H / 16, W / 16) float32, rounded up, weak regions a picture.
        tail: () decay of their scores above the least one, deviations.
        residents: (M, 4) middles and logarithms of sides of regions that showed something moored.
        pictures: () their number.
    """

    per_cell: NDArray[np.float32]
    tail: NDArray[np.float64]
    residents: NDArray[np.float64]
    pictures: NDArray[np.int64]


def cells_of(shape: tuple[int, int]) -> tuple[int, int]:
    """Return the rows and columns of cells of a picture (H, W)."""
    return -(-shape[0] // _CELL_PX), -(-shape[1] // _CELL_PX)


def clutter_rates(
    shape: tuple[int, int], least_score: float, pictures: Sequence[Sequence[Region]], moving: NDArray[np.float32]
) -> ClutterRates:
    """Learn the rates.

    Args:
        shape: of the picture.
        least_score: of any region.
        pictures: the regions found on each picture without objects.
        moving: (H, W) share of these pictures on which something moored moved at a pixel.
    """
    cells = np.zeros(cells_of(shape), np.float32)
    weak = [each for regions in pictures for each in regions if each.score < least_score + _STRONG]
    for region in weak:
        cells[_cell(region, cells.shape)] += 1.0
    per_cell = (_blurred(cells) + _PRIOR_REGIONS * _PRIOR_PICTURES) / (len(pictures) + _PRIOR_PICTURES)
    beyond = sum(each.score - least_score for each in weak)
    tail = (beyond + _PRIOR_TAIL * _PRIOR_WEIGHT) / (len(weak) + _PRIOR_WEIGHT)
    return ClutterRates(per_cell, np.array(tail), _residents(pictures, moving), np.array(len(pictures)))


class Clutter:
    """Density of false regions by place and score: those of the noise, and strong ones of birds and swinging boats."""

    def __init__(self, rates: ClutterRates, least_score: float) -> None:
        """Begin with the rates of the background pictures; ``least_score``: of any region."""
        self._residents, self._pictures = rates.residents, int(rates.pictures)
        self._per_cell, self._tail = rates.per_cell.copy(), float(rates.tail)
        self._strong_per_cell, self._least = _STRONG_REGIONS / rates.per_cell.size, least_score
        self._least_per_cell = float(rates.per_cell.min())

    def learn(self, regions: Sequence[Region], claimed: NDArray[np.uint8]) -> None:
        """Take in the regions of a picture that no object claims: ``claimed`` (H, W)."""
        seen = np.zeros_like(self._per_cell)
        for region in regions:
            x0, _, x1, y1 = region.box_xyxy
            row, column = min(int(y1) - 1, len(claimed) - 1), min(int(0.5 * (x0 + x1)), claimed.shape[1] - 1)
            if not claimed[row, column] and region.score < self._least + _STRONG:
                seen[_cell(region, seen.shape)] += 1.0
        self._per_cell += _RATE * (np.maximum(_blurred(seen), self._least_per_cell) - self._per_cell)

    def log_ratio(self, region: Region) -> float:
        """Return log of (density of the score for an object / density of false regions of that score per pixel)."""
        beyond = max(region.score - self._least, 0.0)
        of_object = -beyond / _OBJECT_TAIL - np.log(_OBJECT_TAIL)
        cell = _cell(region, self._per_cell.shape)
        noise = np.log(self._per_cell[cell] / self._tail) - beyond / self._tail
        strong = np.log(self._strong_per_cell) + of_object
        ratio = float(of_object - np.logaddexp(noise, strong) + np.log(_CELL_PX**2))
        resident = -np.log(self._resident(region) / _RESIDENT_PX2)
        return min(ratio, float(resident))

    def most_log_odds(self, region: Region) -> float:
        """Return the most that a region may add to the log odds of a track that expects it.

        What belongs there and moves, e.g. a moored boat, explains the region as well as the track does, and stays
        there as long: beyond a share of pictures a region is evidence against an intruder.
        """
        return float(np.log(_NEUTRAL_SHARE / self._resident(region)))

    def _resident(self, region: Region) -> float:
        """Return the expected number of regions like this one, of what is moored, on a picture without objects.

        Normal kernels about the regions of training: places in units of the sides, and the logarithms of these.
        """
        middle, sides = _middle_and_sides(region)
        off = np.hstack([(self._residents[:, :2] - middle) / (_KERNEL * sides), self._residents[:, 2:] - np.log(sides)])
        off[:, 2:] /= _KERNEL_LOG
        alike = float(np.exp(-0.5 * np.einsum("mi,mi->m", off, off)).sum())
        return min((alike + _LEAST_RESIDENT) / (self._pictures + 1.0), 1.0 - _LEAST_RESIDENT)


def _cell(region: Region, shape: tuple[int, ...]) -> tuple[int, int]:
    x0, _, x1, y1 = region.box_xyxy
    row, column = int(y1 - 1) // _CELL_PX, int(0.5 * (x0 + x1)) // _CELL_PX
    return min(max(row, 0), shape[0] - 1), min(max(column, 0), shape[1] - 1)


def _residents(pictures: Sequence[Sequence[Region]], moving: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return middles and logarithms of sides (M, 4) of the regions that show something moored."""
    found = [np.zeros((0, 4))]
    for region in (each for regions in pictures for each in regions):
        x0, y0, x1, y1 = np.maximum(np.round(region.box_xyxy), 0).astype(int)
        if np.mean(moving[y0 : y1 + 1, x0 : x1 + 1] > 0) > _MOORED_SHARE:
            middle, sides = _middle_and_sides(region)
            found.append(np.concatenate([middle, np.log(sides)])[None])
    return np.vstack(found)


def _middle_and_sides(region: Region) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    box = region.box_xyxy
    return 0.5 * (box[:2] + box[2:]), np.maximum(box[2:] - box[:2], 1.0)


def _blurred(cells: NDArray[np.float32]) -> NDArray[np.float32]:
    blurred: NDArray[np.float32] = cv2.GaussianBlur(cells, (0, 0), _BLUR_CELLS, borderType=cv2.BORDER_REFLECT)
    return blurred
