"""How a car looks on ground that is seen from straight above, and where in a patch of ground it looks like that."""

from __future__ import annotations

from typing import NamedTuple, Protocol

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
