"""What is found: the scores of single visits, and their sums over thresholds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.judges.harbour.streaks import RUNNING
from benchmarks.judges.harbour.visits import Visit
from benchmarks.statistics import froc


def visit_scores(
    visits: Sequence[Visit],
    found: NDArray[np.bool_],
    begins: NDArray[np.float64],
    by_region: NDArray[np.bool_],
    by_chance: NDArray[np.float64],
    interval_s: float,
) -> Iterator[Score]:
    """Yield what is found at the tracker's own operating point: by all that it answers, or, if it answers with more
    than it decides for, by tracks with the confidence from which on it decides.

    ``found``: of an intruder that can be seen, ``(f - c) / (1 - c)``, weight ``1 - c``: f is 1 if one track lies on it
    four frames running, see ``matching.match``, c the share of shuffled truths with which tracks on nothing would have
    found it by chance (Abbott 1925), so that means over visits are ``(F - C) / (N - C)``. ``found_unseen``: the same of
    those that nobody could see. ``chance_rate``: c. ``found_as_in_paper``: 1 if one identity's region overlaps it in
    the picture four frames running, wherever in the world; of all, nothing subtracted. ``time_to_detect_s``: of those
    found, from the first frame that is judged to the fourth one running.

    Args:
        found, by_region: (N,) whether it is found, and as in the paper. begins: (N,) first frame of its first run.
        by_chance: (N,) share of shuffled truths.
    """
    for visit in visits:
        k = visit.index
        chance = float(by_chance[k])
        likely = 1.0 - chance
        value = (float(found[k]) - chance) / likely if likely > 0 else None
        yield Score("found" if visit.seeable else "found_unseen", value, likely, visit)
        yield Score("chance_rate", chance, 1.0, visit)
        yield Score("found_as_in_paper", float(by_region[k]), 1.0, visit)
        if found[k]:
            frames = int(begins[k]) + RUNNING - 1 - visit.first_frame
            yield Score("time_to_detect_s", frames * interval_s, 1.0, visit)


def froc_scores(visits: Sequence[Visit], level: NDArray[np.float64], by_chance: NDArray[np.float64]) -> Iterator[Score]:
    """Yield *series* over ``scores.froc.THRESHOLDS``, as if only tracks with such confidence were answered.

    ``froc_found``: F - C, of the intruders that can be seen those found less those expected by chance, see ``found``.
    ``froc_findable``: N - C.
    """
    seeable = [visit.index for visit in visits if visit.seeable]
    chance = froc.reached(by_chance[:, seeable].ravel()) / len(by_chance)
    yield Score("froc_found", (froc.reached(level[seeable]) - chance).tolist())
    yield Score("froc_findable", (len(seeable) - chance).tolist())
