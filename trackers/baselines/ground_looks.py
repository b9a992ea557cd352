"""Search for a car in a patch of ground seen from straight above, by its colours or by a template that is turned."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.histogram import hs_bins, picture_histogram, rectangle_similarities

Patch = NDArray[np.uint8]
"""(H, W, 3) ground seen from straight above, in square cells; cell (row i, column j) covers [j, j+1) x [i, i+1)."""


class Spot(NamedTuple):
    """A place in a patch that looks like the target.

    Attributes:
        centre: (2,) column and row, in cells.
        similarity: at most 1.
        turn_rad: how far the target has turned since the first picture, from the columns' to the rows' direction; 0 if
            the look does not depend on it.
    """

    centre: NDArray[np.float64]
    similarity: float
    turn_rad: float


class Look(Protocol):
    """Compares patches with the target in the first picture.

    Attributes:
        margin_cells: width of the border of a patch in which the target's centre is not looked for.
    """

    margin_cells: int

    def near(self, patch: Patch, allowed: NDArray[np.bool_], turn_rad: float) -> Spot | None:
        """Return the most similar of the cells (H, W) that are ``allowed``, for a target that turned by about
        ``turn_rad``; None if no cell is.
        """
        ...

    def anywhere(self, patch: Patch, allowed: NDArray[np.bool_]) -> Spot | None:
        """Return the same for a target that may have turned by any angle."""
        ...


def middle_of(patch: Patch, side_cells: int) -> Patch:
    """Return the middle (side, side, 3) of a patch."""
    row, column = ((cells - side_cells) // 2 for cells in patch.shape[:2])
    return np.ascontiguousarray(patch[row : row + side_cells, column : column + side_cells])


class ColourLook:
    """Similarity, as in ``hold``, of the HS histogram of a square that lies inside the car for every heading."""

    def __init__(self, patch: Patch, side_cells: int) -> None:
        """Take the histogram from the middle of a patch."""
        self.margin_cells = side_cells
        self._size = np.full(2, float(side_cells))
        self._histogram = picture_histogram(hs_bins(middle_of(patch, side_cells)))

    def near(self, patch: Patch, allowed: NDArray[np.bool_], turn_rad: float) -> Spot | None:
        """See ``Look``. The turn has no effect."""
        return self.anywhere(patch, allowed)

    def anywhere(self, patch: Patch, allowed: NDArray[np.bool_]) -> Spot | None:
        """See ``Look``. A grid in steps of a third of the square is refined to cells around its best place."""
        bins, step = hs_bins(patch), max(1, int(self._size[0]) // 3)
        coarse = self._best(bins, allowed, np.zeros(2, int), np.array(allowed.shape), step)
        if coarse is None or step == 1:
            return coarse
        row, column = coarse.centre[::-1].astype(int)
        low, high = np.maximum([row - step, column - step], 0), np.array([row + step + 1, column + step + 1])
        return self._best(bins, allowed, low, high, 1)

    def _best(
        self,
        bins: NDArray[np.uint8],
        allowed: NDArray[np.bool_],
        low: NDArray[np.int64],
        high: NDArray[np.int64],
        step: int,
    ) -> Spot | None:
        """Return the best cell of every ``step``-th from (row, column) ``low`` to before ``high``."""
        rows, columns = np.nonzero(allowed[low[0] : high[0] : step, low[1] : high[1] : step])
        if len(rows) == 0:
            return None
        centres = np.column_stack([low[1] + step * columns, low[0] + step * rows]) + 0.5
        similarities = rectangle_similarities(bins, centres, self._size, self._histogram, 0.0)
        best = int(np.argmax(similarities))
        return Spot(centres[best], float(similarities[best]), 0.0)


_NEAR_TURNS_RAD = (-0.15, 0.0, 0.15)
_ALL_TURNS_RAD = np.arange(24) * (np.pi / 12)
_FINE_TURNS_RAD = (-0.09, 0.0, 0.09)
_REFINED, _REFINED_CELLS = 4, 3
_LEAST_DEVIATION = 1.0


class TemplateLook:
    """``cv2.TM_CCOEFF_NORMED`` of a square around the car's middle in the first picture, which is never updated.

    The similarity is the mean of this correlation at its best place and of the similarity of the HS histograms of a
    smaller square there: the light on a car changes as it turns, its colours hardly. A search for any turn compares 24
    turns at half the resolution; the best four places are refined.
    """

    def __init__(self, patch: Patch, side_cells: int, colour_cells: int) -> None:
        """Take the template from the middle of a patch, which is at least twice as wide.

        Args:
            side_cells, colour_cells: side of the template, and of the square whose colours are compared.
        """
        self.margin_cells = max(side_cells // 2 + 1, colour_cells)
        self._side = side_cells
        self._around = middle_of(patch, 2 * side_cells)
        self._colour_size = np.full(2, float(colour_cells))
        self._histogram = picture_histogram(hs_bins(middle_of(patch, colour_cells)))

    def near(self, patch: Patch, allowed: NDArray[np.bool_], turn_rad: float) -> Spot | None:
        """See ``Look``."""
        turns = [turn_rad + turn for turn in _NEAR_TURNS_RAD]
        best = _best([_match(patch, allowed, self._turned(turn), turn) for turn in turns])
        return None if best is None else self._with_colours(patch, best)

    def anywhere(self, patch: Patch, allowed: NDArray[np.bool_]) -> Spot | None:
        """See ``Look``."""
        half = _halved(patch)
        allowed_half = cv2.resize(allowed.astype(np.uint8), half.shape[1::-1], interpolation=cv2.INTER_NEAREST) > 0
        coarse = [_match(half, allowed_half, _halved(self._turned(turn)), turn) for turn in _ALL_TURNS_RAD.tolist()]
        found = sorted((spot for spot in coarse if spot is not None), key=lambda spot: -spot.similarity)
        return _best([self._refined(patch, allowed, spot) for spot in found[:_REFINED]])

    def _refined(self, patch: Patch, allowed: NDArray[np.bool_], coarse: Spot) -> Spot | None:
        """Return the best spot within three cells of one that was found at half the resolution."""
        low = np.maximum((2.0 * coarse.centre).astype(int) - _REFINED_CELLS - self.margin_cells, 0)
        column, row = low
        extent = 2 * (_REFINED_CELLS + self.margin_cells) + 1
        window = slice(row, row + extent), slice(column, column + extent)
        part, cells = np.ascontiguousarray(patch[window]), allowed[window]
        turns = [coarse.turn_rad + turn for turn in _FINE_TURNS_RAD]
        best = _best([_match(part, cells, self._turned(turn), turn) for turn in turns])
        return None if best is None else self._with_colours(patch, best._replace(centre=best.centre + low))

    def _with_colours(self, patch: Patch, spot: Spot) -> Spot:
        """Return the spot with the mean of its correlation and the similarity of its colours."""
        half = np.ceil(self._colour_size).astype(int)
        low = np.maximum(np.floor(spot.centre).astype(int) - half, 0)
        part = np.ascontiguousarray(patch[low[1] : low[1] + 2 * half[1] + 1, low[0] : low[0] + 2 * half[0] + 1])
        colours = rectangle_similarities(
            hs_bins(part), (spot.centre - low)[None], self._colour_size, self._histogram, 0.0
        )
        return spot._replace(similarity=0.5 * (spot.similarity + float(colours[0])))

    def _turned(self, turn_rad: float) -> Patch:
        side = 2 * self._side
        M = cv2.getRotationMatrix2D((self._side - 0.5, self._side - 0.5), -np.rad2deg(turn_rad), 1.0)
        return middle_of(cv2.warpAffine(self._around, M, (side, side)), self._side)


def _halved(patch: Patch) -> Patch:
    height, width = patch.shape[:2]
    return cv2.resize(patch, (max(width // 2, 1), max(height // 2, 1)), interpolation=cv2.INTER_AREA)


def _match(patch: Patch, allowed: NDArray[np.bool_], template: Patch, turn_rad: float) -> Spot | None:
    """Return the allowed cell of a patch around which it resembles the template most.

    None if no cell is allowed, or if the template shows one even colour, which correlates with nothing.
    """
    side = len(template)
    if min(patch.shape[:2]) < side or template.std() < _LEAST_DEVIATION:
        return None
    similarity = cv2.matchTemplate(patch, template, cv2.TM_CCOEFF_NORMED)
    rows, columns = similarity.shape
    first = side // 2
    usable = allowed[first : first + rows, first : first + columns] & np.isfinite(similarity)
    if not usable.any():
        return None
    row, column = np.unravel_index(int(np.argmax(np.where(usable, similarity, -2.0))), similarity.shape)
    centre = np.array([column, row]) + 0.5 * side
    return Spot(centre, min(float(similarity[row, column]), 1.0), turn_rad)


def _best(spots: list[Spot | None]) -> Spot | None:
    return max((spot for spot in spots if spot is not None), key=lambda spot: spot.similarity, default=None)
