"""Boxes around the visible pixels of objects."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


def visible_boxes(instance_map: NDArray[np.int32], instance_id: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the tight boxes (N, 4) around the pixels of ``instance_map`` (H, W) that show the objects ``instance_id``
    (N,), as x_min, y_min, x_max, y_max; NaN for objects of which none does.
    """
    ends = _ends(instance_map, max(int(instance_map.max(initial=0)), int(instance_id.max(initial=0))) + 1)
    boxes = ends[instance_id].astype(np.float64)
    boxes[boxes[:, 2] < 0] = np.nan
    return boxes


@njit(cache=True)
def _ends(instance_map: NDArray[np.int32], ids: int) -> NDArray[np.int64]:
    """Return first column and row, and those after the last (``ids``, 4), of each id >= 0; -1 at the end of others."""
    height, width = instance_map.shape
    ends = np.empty((ids, 4), np.int64)
    for i in range(ids):
        ends[i, 0], ends[i, 1], ends[i, 2], ends[i, 3] = width, height, -1, -1
    for row in range(height):
        column = 0
        while column < width:
            which, first = instance_map[row, column], column
            while column < width and instance_map[row, column] == which:
                column += 1
            if which >= 0:
                ends[which, 0] = min(ends[which, 0], first)
                ends[which, 1] = min(ends[which, 1], row)
                ends[which, 2] = max(ends[which, 2], column)
                ends[which, 3] = row + 1
    return ends
