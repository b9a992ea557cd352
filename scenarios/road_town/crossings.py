"""Which cars may drive onto a crossing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_APART_M = 2.6
"""Two cars pass each other on ways that are so far apart."""
_SAME_LINE_M = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """A car at a crossing.

    Attributes:
        car: index. node: of the crossing.
        line_m: distance from its front to where the crossing begins; negative beyond that.
        is_first: whether no other car stands in between.
        way_m: (K, 2) points of its way over the crossing, from the line on.
    """

    car: int
    node: int
    line_m: float
    is_first: bool
    way_m: NDArray[np.float64]

    def is_in_the_way_of(self, other: Approach) -> bool:
        """Return whether two cars would meet; one that follows another over the same line keeps its distance."""
        if np.linalg.norm(self.way_m[0] - other.way_m[0]) < _SAME_LINE_M:
            return False
        return bool(np.linalg.norm(self.way_m[:, None] - other.way_m, axis=2).min() < _APART_M)


class Crossings:
    """All crossings of a town: a car waits until all that came before it, and are in its way, have left."""

    def __init__(self, at_start: Sequence[Approach]) -> None:
        """Begin with the cars that are near a crossing at frame 0, those that are furthest over the line first."""
        # Node → car → its approach, and the cars for which it waits.
        self._came: defaultdict[int, dict[int, tuple[Approach, list[int]]]] = defaultdict(dict)
        for approach in sorted(at_start, key=lambda each: each.line_m):
            self.may_enter(approach)

    def may_enter(self, approach: Approach) -> bool:
        """Return whether a car that has come near may drive on; it asks again in every frame.

        A car behind another one has not come yet, or both would wait for each other.
        """
        came = self._came[approach.node]
        if approach.car not in came:
            if not approach.is_first:
                return False
            waits_for = [car for car, (before, _) in came.items() if before.is_in_the_way_of(approach)]
            came[approach.car] = (approach, waits_for)
        return not any(car in came for car in came[approach.car][1])

    def leave(self, car: int, node: int) -> None:
        """Give the crossing to other cars."""
        self._came[node].pop(car, None)
