"""What several formats say of objects: classes, boxes, identities."""

from __future__ import annotations

import numpy as np
import pyarrow.compute as pc
from numpy.typing import NDArray

from benchmarks.data_sets.data_set import DataSet


def kinds_of(data: DataSet) -> list[str]:
    """Return all kinds of objects of a data set, in alphabetic order: the classes of an export.

    Raises:
        ValueError: if there are no objects.
    """
    kinds: set[str] = set()
    for batch in data.batches("objects", {"kinds": pc.field("kinds")}):
        kinds.update(batch["kinds"].unique().to_pylist())
    if not kinds:
        raise ValueError(f"data: expected a data set with objects, got {data.url} without any")
    return sorted(kinds)


def as_xywh(box_xyxy: NDArray[np.float64], first: float = 0.0) -> list[float]:
    """Return a box (4,) as left, top, width, height, where the picture's top left corner is at (first, first)."""
    x_min, y_min, x_max, y_max = box_xyxy.tolist()
    return [x_min + first, y_min + first, x_max - x_min, y_max - y_min]


class Identities:
    """Numbers the objects of an episode by name, from 1 on, in order of their appearance."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def of(self, name: str) -> int:
        """Return an object's number."""
        return self.numbers.setdefault(name, 1 + len(self.numbers))
