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
MEAN_SIZE_M = {"person": (0.36, 0.53, 1.73), "car": (4.79, 1.99, 1.70), "boat": (8.26, 2.68, 3.76)}
"""Mean sizes of the scene's intruders by class, of the first 40 seeds of ``standard``: the guess of who knows the class
and the scene, and measures nothing.
"""


def measured_scores(visits: Sequence[Visit], history: History, size_m: NDArray[np.float64]) -> Iterator[Score]:
    """Yield errors of the one track on each intruder, a row a visit.

    ``position_error_m``: mean distance over the ground of the two centres, at most 3 m, since beyond it is not on it.
    ``kind_right``: share of its frames with a class in which that is right. ``depth_error``, ``width_error``,
    ``height_error``: of the median of its sizes, the difference from the true one relative to that;
    ``depth_error_of_mean`` …: the same of the mean size of its class.

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
            yield Score(f"{name}_error", float(abs(said_m / true_m - 1.0)), 1.0, visit)
            yield Score(f"{name}_error_of_mean", float(abs(mean_m / true_m - 1.0)), 1.0, visit)


def region_scores(visits: Sequence[Visit], met: Met) -> Iterator[Score]:
    """Yield places and sizes of the tracks that paper D counts: whose region overlaps an intruder four frames running.

    ``beyond_m``: how far they lie behind it as the camera sees it, over the ground; negative before it. A mean over
    frames, a row a visit. ``region_depth_m``, ``region_width_m``, ``region_height_m``: medians of their sizes.
    """
    for visit in visits:
        mine = met.target == visit.index
        beyond_m = met.beyond_m[mine & np.isfinite(met.beyond_m)]
        if len(beyond_m):
            yield Score("beyond_m", float(beyond_m.mean()), float(len(beyond_m)), visit)
        sizes_m = met.size_m[mine & np.isfinite(met.size_m).all(axis=1)]
        if len(sizes_m):
            for name, said_m in zip(DIMENSIONS, np.median(sizes_m, axis=0), strict=True):
                yield Score(f"region_{name}_m", float(said_m), 1.0, visit)
