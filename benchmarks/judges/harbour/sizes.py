"""Places and sizes of the intruders that are found, against truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.judges.harbour.answers import Objects
from benchmarks.judges.harbour.matching import History
from benchmarks.judges.harbour.streaks import streaks
from benchmarks.judges.harbour.visits import Visit

DIMENSIONS = ("depth", "width", "height")
"""Of ``Track.size_m``: an intruder's own length is called its depth, as in paper D."""
MEAN_SIZE_M = {"person": (0.35, 0.51, 1.73), "car": (4.80, 1.99, 1.70), "boat": (8.24, 2.68, 3.59)}
"""Mean sizes of the scene's intruders by class, of the first 40 seeds of ``standard``: the guess from class and scene
alone, without a measurement.
"""

AT_100_M = (80.0, 120.0)
"""Distances from the camera over the ground at which sizes are those at 100 m."""


def measured_scores(visits: Sequence[Visit], history: History, objects: Objects) -> Iterator[Score]:
    """Yield errors of the one track on each intruder, a row a visit.

    ``position_error_m``: mean distance over the ground of the two centres, at most 3 m, since beyond it is not on it.
    ``duplicate_rate``: share of its frames on which another track is on the same intruder. ``kind_right``: share of its
    frames with a class in which that is right. ``depth_error``, ``width_error``, ``height_error``: of the median of its
    sizes, the difference from the true one relative to that.
    ``depth_error_at_100_m`` …: the same of its sizes while the intruder is 80 to 120 m away from the camera over the
    ground; ``depth_error_of_mean`` …: for the same intruders that of the mean size of their class.

    Args:
        objects: of all frames.
    """
    answers, target = history.answers, history.matches.target
    for visit in visits:
        index, on_it = visit.index, target == visit.index
        own = history.matches.first & on_it
        if not own.any():
            continue
        count, frames = float(own.sum()), history.frame[own]
        error_m = np.linalg.norm(answers.place_m[own, :2] - objects.place_m[frames, index, :2], axis=1)
        yield Score("position_error_m", float(error_m.mean()), count, visit)
        yield Score("duplicate_rate", len(np.unique(history.frame[on_it & ~own])) / count, count, visit)
        named = answers.kind[own][answers.kind[own] != ""]
        if len(named):
            yield Score("kind_right", float((named == visit.kind).mean()), float(len(named)), visit)
        size_m, true_m = answers.size_m[own], objects.size_m[0, index]
        measured = np.isfinite(size_m).all(axis=1)
        away_m = objects.distance_m[frames, index]
        near = measured & (away_m >= AT_100_M[0]) & (away_m <= AT_100_M[1])
        if measured.any():
            yield from _errors("error", np.median(size_m[measured], axis=0), true_m, visit)
        if near.any():
            yield from _errors("error_at_100_m", np.median(size_m[near], axis=0), true_m, visit)
            yield from _errors("error_of_mean", np.array(MEAN_SIZE_M[visit.kind]), true_m, visit)


def _errors(suffix: str, said_m: NDArray[np.float64], true_m: NDArray[np.float64], visit: Visit) -> Iterator[Score]:
    for name, error in zip(DIMENSIONS, np.abs(said_m / true_m - 1.0), strict=True):
        yield Score(f"{name}_{suffix}", float(error), 1.0, visit)


def overlapping_regions(history: History) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return row and intruder (K,) of each time that a track overlaps an intruder that is seen, where it does so on
    four frames running: what paper D counts as found.
    """
    row, target = np.nonzero(history.matches.overlapping)
    pair = target * history.names + history.identity[row]
    counted = np.isin(pair, streaks(history.frame[row], pair, history.answers.confidence[row]).key)
    return row[counted], target[counted]


def region_scores(
    visits: Sequence[Visit], history: History, objects: Objects, regions: tuple[NDArray[np.int64], NDArray[np.int64]]
) -> Iterator[Score]:
    """Yield places and sizes of the tracks that paper D counts, ``regions`` of ``overlapping_regions``.

    ``beyond_m``: how far they lie behind the intruder as the camera sees it, over the ground; negative before it. A
    mean over frames, a row a visit. ``region_depth_m``, ``region_width_m``, ``region_height_m``: medians of their
    sizes.
    """
    for visit in visits:
        row = regions[0][regions[1] == visit.index]
        frame = history.frame[row]
        off_m = history.answers.place_m[row, :2] - objects.place_m[frame, visit.index, :2]
        beyond_m = (off_m * objects.ahead[frame, visit.index]).sum(axis=1)
        beyond_m = beyond_m[np.isfinite(beyond_m)]
        if len(beyond_m):
            yield Score("beyond_m", float(beyond_m.mean()), float(len(beyond_m)), visit)
        sizes_m = history.answers.size_m[row]
        sizes_m = sizes_m[np.isfinite(sizes_m).all(axis=1)]
        if len(sizes_m):
            for name, said_m in zip(DIMENSIONS, np.median(sizes_m, axis=0), strict=True):
                yield Score(f"region_{name}_m", float(said_m), 1.0, visit)
