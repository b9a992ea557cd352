"""Rows of pixels as runs: neighbours that show the same thing, for loops that become vector code.

A loop over a run is over before vector code of the usual kind has started. So run loops work on whole blocks of
``LANES`` pixels and write beyond the end of the run, where the next run writes later. The arrays that they write to are
lines of one *bench*: line n begins at ``n * PITCH``. The fixed distance tells the compiler that lines do not overlap,
and leaves room behind the last column.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.compilation import row_kernel

LANES = 16
WIDEST = 4096
"""Columns of the widest picture."""
PITCH = WIDEST + 5 * LANES
"""No power of two, at which all lines would fall on the same part of the processor's nearest memory."""


@njit(cache=True)
def new_bench(lines: int, width: int) -> NDArray[np.float32]:
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

    Without branches: what no processor can foresee costs it more than a write too many.

    Args:
        firsts: (> W,).
    """
    one = np.uint64(1)
    count, width = one, np.uint64(values.shape[0])
    firsts[0] = np.uint32(0)
    for column in range(one, width):
        firsts[count] = np.uint32(column)
        count += np.uint64(values[column] != values[column - one])
    firsts[count] = np.uint32(width)
    return count
