"""What is found: single visits, beside what would be found by chance, over thresholds, and in single pictures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.judges.harbour.answers import Answers, Objects
from benchmarks.judges.harbour.matching import RADIUS_M, History, overlaps_of
from benchmarks.judges.harbour.streaks import RUNNING, highest, streaks
from benchmarks.judges.harbour.visits import Visit
from benchmarks.statistics import froc
from benchmarks.statistics.average_precision import told_right

DRAWS = 20
"""Times that the truth is shifted."""


def visit_scores(
    visits: Sequence[Visit],
    history: History,
    by_region: NDArray[np.int64],
    by_chance: NDArray[np.float64],
    interval_s: float,
) -> Iterator[Score]:
    """Yield what is found at the tracker's own operating point: by all that it answers, or, if it answers with more
    than it decides for, by tracks with the confidence from which on it decides.

    ``found``: of an intruder that can be seen, ``(f - c) / (1 - c)``, weight ``1 - c``: f is 1 if one track lies on it
    four frames running, see ``matching.match_frame``, c the share of shuffled truths with which tracks on nothing would
    have found it by chance (Abbott 1925), so that means over visits are ``(F - C) / (N - C)``. ``found_unseen``: the
    same of those that nobody could see. ``chance_rate``: c. ``found_as_in_paper``: 1 if one identity's region overlaps
    it in the picture four frames running, wherever in the world; of all, nothing subtracted. ``time_to_detect_s``: of
    those found, from the first frame that is judged to the fourth one running.

    Args:
        by_region: intruders that are found as in the paper. by_chance: (N,) share of shuffled truths.
    """
    level, begins = reached(history)
    for visit in visits:
        k = visit.index
        found, chance = float(level[k] > -np.inf), float(by_chance[k])
        likely = 1.0 - chance
        value = (found - chance) / likely if likely > 0 else None
        yield Score("found" if visit.seeable else "found_unseen", value, likely, visit)
        yield Score("chance_rate", chance, 1.0, visit)
        yield Score("found_as_in_paper", float(k in by_region), 1.0, visit)
        if found:
            frames = int(begins[k]) + RUNNING - 1 - visit.first_frame
            yield Score("time_to_detect_s", frames * interval_s, 1.0, visit)


def froc_scores(visits: Sequence[Visit], history: History, by_chance: NDArray[np.float64]) -> Iterator[Score]:
    """Yield *series* over ``statistics.froc.THRESHOLDS``, as if only tracks with such confidence were answered.

    ``froc_found``: F - C, of the intruders that can be seen those found less those expected by chance, see ``found``.
    ``froc_findable``: N - C.
    """
    seeable = [visit.index for visit in visits if visit.seeable]
    chance = froc.reached(by_chance[:, seeable].ravel()) / len(by_chance)
    yield Score("froc_found", (froc.reached(reached(history)[0][seeable]) - chance).tolist())
    yield Score("froc_findable", (len(seeable) - chance).tolist())


def reached(history: History) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return for each intruder (N,) the highest threshold at which it is found, and the first frame on which it begins
    to be; -inf and inf where it is not.
    """
    target, count = history.matches.target, history.matches.overlapping.shape[1]
    on = target >= 0
    key = target[on] * history.names + history.identity[on]
    own = streaks(history.frame[on], key, history.answers.confidence[on])
    found = own.key // history.names
    return highest(found, own.level, count), -highest(found, -own.begins.astype(float), count)


def chance_levels(history: History, objects: Objects, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return (``DRAWS``, N) the highest threshold at which each intruder is found four frames running by tracks that
    have nothing to do with it, -inf where it is not.

    These tracks are the identities that lie on nothing more often than not. The truth of all frames is shifted in time
    against them by a random number of frames, round the end of the episode.
    """
    frames, count = objects.judged.shape
    levels = np.full((DRAWS, count), -np.inf)
    own = np.flatnonzero(history.on_nothing())
    if len(own) == 0 or frames < 2:
        return levels
    place_m, box_xyxy = history.answers.place_m[:, :2], history.answers.box_xyxy
    for draw, shift in enumerate(rng.integers(1, frames, DRAWS)):
        at = (history.frame[own] - shift) % frames
        which, target = np.nonzero(objects.judged[at])
        row, then = own[which], at[which]
        on = np.linalg.norm(place_m[row] - objects.place_m[then, target, :2], axis=1) <= RADIUS_M
        on[on] = overlaps_of(box_xyxy[row[on]], objects.box_xyxy[then[on], target[on]])
        key = target[on] * history.names + history.identity[row[on]]
        found = streaks(then[on], key, history.answers.confidence[row[on]])
        levels[draw] = highest(found.key // history.names, found.level, count)
    return levels


def box_scores(objects: Sequence[Objects], answers: Sequence[Answers]) -> Iterator[Score]:
    """Yield *series* over ``statistics.froc.THRESHOLDS``, as if only tracks with such confidence were answered.

    ``boxes_right``: boxes, picture by picture, that overlap that of an intruder that is judged by an intersection over
    union of 0.5 at least, each intruder once, the surest first. ``boxes_told``: all boxes but those that lie, by half
    of their area, in the box of an intruder that is not judged. ``boxes_true``: of the intruders that are judged.
    """
    boxes, true = [np.empty((0, 2))], 0
    for there, answered in zip(objects, answers, strict=True):
        present = np.flatnonzero(there.present & np.isfinite(there.box_xyxy).all(axis=1))
        counted = there.judged[present]
        right, counts = told_right(answered.box_xyxy, answered.confidence, there.box_xyxy[present], counted)
        boxes.append(np.column_stack([answered.confidence, right])[counts])
        true += int(counted.sum())
    confidence, is_right = np.concatenate(boxes).T
    yield Score("boxes_right", froc.reached(confidence[is_right > 0]).tolist())
    yield Score("boxes_told", froc.reached(confidence).tolist())
    yield Score("boxes_true", float(true))
