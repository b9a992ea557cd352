"""Runs of neighbouring pixels of a row that show the same body or triangle, for loops in vector code.

Runs are too short for ordinary vector code. So run loops process whole blocks of ``LANES`` pixels and write beyond the
end of the run, where the next run writes later. Their arrays are lines of one *line buffer*: line n begins at
``n * PITCH``. From the fixed distance the compiler knows that lines do not overlap; it leaves space behind the last
column.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel

LANES = 16
_SEARCHED = 32
"""Pixels searched at once for the first one of a run."""
WIDEST = 4096
"""Columns of the widest picture."""
PITCH = WIDEST + 5 * LANES
"""No power of two, with which all lines would map to the same part of the processor's cache."""


@njit(cache=True)
def new_lines(lines: int, width: int) -> NDArray[np.float32]:
    """Return ``lines`` lines of zeros for rows of ``width`` pixels.

    Raises:
        ValueError: for pictures that are wider than ``WIDEST``.
    """
    if width > WIDEST:
        raise ValueError("width: expected at most 4096 pixels")
    return np.zeros(lines * PITCH, np.float32)


@row_kernel()
def find_runs(values: NDArray[np.int32], firsts: NDArray[np.uint32]) -> np.uint64:
    """Write the first column of each run of equal values (W,), and W behind the last; return the number of runs.

    Args:
        firsts: (> W,).
    """
    one, block = np.uint64(1), np.uint64(_SEARCHED)
    count, column, width = one, one, np.uint64(values.shape[0])
    firsts[0] = np.uint32(0)
    while column + block <= width:
        change = np.int32(0)
        for k in range(column, column + block):
            change |= values[k] ^ values[k - one]
        if change != 0:
            count = _find_firsts(values, column, column + block, count, firsts)
        column += block
    count = _find_firsts(values, column, width, count, firsts)
    firsts[count] = np.uint32(width)
    return count


@row_kernel(forceinline=True)
def _find_firsts(
    values: NDArray[np.int32], start: np.uint64, end: np.uint64, count: np.uint64, firsts: NDArray[np.uint32]
) -> np.uint64:
    """Write the columns from start to end that begin a run behind the ``count`` known ones; return how many are known.

    Without branches: a mispredicted one costs more than a needless write.
    """
    for column in range(start, end):
        firsts[count] = np.uint32(column)
        count += np.uint64(values[column] != values[column - np.uint64(1)])
    return count
