"""Places and sizes of the intruders that are found, against truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.suites.harbour.history import History, Met
from benchmarks.suites.harbour.visits import Visit
from benchmarks.suites.judging import Score

DIMENSIONS = ("depth", "width", "height")
"""Of ``Track.size_m``: an intruder's own length is called its depth, as in paper D."""
MEAN_SIZE_M = {"person": (0.36, 0.53, 1.73), "car": (4.77, 1.97, 1.66), "boat": (8.26, 2.68, 3.74)}
"""Mean sizes of the scene's intruders by class: the best guess of who knows the class and this scene alone."""


def measured_scores(visits: Sequence[Visit], history: History, size_m: NDArray[np.float64]) -> Iterator[Score]:
    """Yield errors of the one track on each intruder, a row a visit.

    ``position_error_m``: mean distance over the ground of the two centres, at most 3 m, since beyond it is not on it.
    ``kind_right``: share of its frames with a class in which that is right. ``depth_m``, ``width_m``, ``height_m``:
    median of its sizes; ``depth_error`` …: their difference from the true ones, ``true_depth_m`` …, relative to these;
    ``depth_error_of_mean`` …: the error of the mean size of the class.

    Args:
        size_m: (N, 3) true sizes.
    """
    for visit in visits:
        mine = history.first & (history.target == visit.index)
        if not mine.any():
            continue
        yield Score("position_error_m", float(history.error_m[mine].mean()), float(mine.sum()), visit)
        named = history.kind[mine][history.kind[mine] != ""]
        if len(named):
            yield Score("kind_right", float((named == visit.kind).mean()), float(len(named)), visit)
        sizes_m = history.size_m[mine]
        sizes_m = sizes_m[np.isfinite(sizes_m).all(axis=1)]
        if len(sizes_m) == 0:
            continue
        values = zip(DIMENSIONS, np.median(sizes_m, axis=0), size_m[visit.index], MEAN_SIZE_M[visit.kind], strict=True)
        for name, said_m, true_m, mean_m in values:
            yield Score(f"{name}_m", float(said_m), 1.0, visit)
            yield Score(f"true_{name}_m", float(true_m), 1.0, visit)
            yield Score(f"{name}_error", float(abs(said_m / true_m - 1.0)), 1.0, visit)
            yield Score(f"{name}_error_of_mean", float(abs(mean_m / true_m - 1.0)), 1.0, visit)


def range_scores(visits: Sequence[Visit], met: Met) -> Iterator[Score]:
    """Yield ``beyond_m``: how far the places of tracks whose region overlaps an intruder lie behind it as the camera
    sees it, over the ground; negative before it. A mean over frames, a row a visit.
    """
    known = np.isfinite(met.beyond_m)
    for visit in visits:
        mine = known & (met.target == visit.index)
        if mine.any():
            yield Score("beyond_m", float(met.beyond_m[mine].mean()), float(mine.sum()), visit)
