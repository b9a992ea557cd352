"""False alarms and their causes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.judges.harbour.streaks import RUNNING, Streaks
from benchmarks.statistics import froc

Cause = Literal["tide", "wave", "bird", "agc_step", "shadow", "other"]
CAUSES: tuple[Cause, ...] = get_args(Cause)
_OF_CLUTTER: dict[str, Cause] = {
    "moored": "tide",
    "rope": "tide",
    "sea": "wave",
    "bird": "bird",
    "parked": "shadow",
    "land": "shadow",
    "building": "shadow",
}
PAUSE_S = 60.0
_GROWN_PX = 2
"""A boat that has moved leaves its old place beside it: boxes are so much larger on each side."""
_SHARE = 0.1
"""Share of a box from which on moored boats and ropes are the cause."""


class Clutter:
    """What there is to see beside intruders, by instance id."""

    def __init__(self, clutter: Mapping[int, str]) -> None:
        """``clutter``: instance id -> kind, see ``HarbourMap``."""
        self._cause_of = np.full(max(clutter, default=-1) + 2, CAUSES.index("other"), np.uint8)
        for instance, kind in clutter.items():
            self._cause_of[instance] = CAUSES.index(_OF_CLUTTER[kind])

    def causes(self, instance_map: NDArray[np.int32], boxes_xyxy: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return (M,) the index in ``CAUSES`` of what lies in each box (M, 4), never that of a step of the AGC.

        A bird if there is one; moored boats and ropes if they fill a tenth of it; otherwise what fills most of it.
        """
        height, width = instance_map.shape
        low = np.floor(boxes_xyxy[:, :2]) - _GROWN_PX
        high = np.ceil(boxes_xyxy[:, 2:]) + _GROWN_PX
        corners = np.clip(np.hstack([low, high]), 0, [width, height, width, height]).astype(int)
        return np.array([self._cause(instance_map[y0:y1, x0:x1]) for x0, y0, x1, y1 in corners], np.uint8)

    def _cause(self, ids: NDArray[np.int32]) -> int:
        # Ids of intruders and those below zero, which are large without a sign, take the last place.
        known = np.minimum(ids.view(np.uint32), len(self._cause_of) - 1)
        counts = np.bincount(self._cause_of[known].ravel(), minlength=len(CAUSES))
        if counts[CAUSES.index("bird")]:
            return CAUSES.index("bird")
        if counts[CAUSES.index("tide")] > _SHARE * ids.size:
            return CAUSES.index("tide")
        return int(counts.argmax()) if ids.size else CAUSES.index("other")


def raised(frame: NDArray[np.int64], identity: NDArray[np.int64], pause_frames: float) -> NDArray[np.int64]:
    """Return a number (R,) for each track on nothing, the same as long as its identity (R,) does not pause for longer.

    So that one identity for all that ever moves is not one alarm. ``frame`` (R,) is in order.
    """
    order = np.lexsort((frame, identity))
    another = _is_another(frame[order], identity[order], pause_frames)
    numbers = np.empty_like(identity)
    numbers[order] = np.cumsum(np.concatenate([[0], another])) if len(order) else 0
    return numbers


def causes_of_alarms(
    alarms: Streaks,
    frame: NDArray[np.int64],
    number: NDArray[np.int64],
    cause: NDArray[np.uint8],
    agc_step: NDArray[np.bool_],
) -> list[Cause]:
    """Return the cause of each alarm: a step of the AGC on the frame on which it begins or the one before, or ``cause``
    (R,) of its track on the frame on which it is raised, the last of its first four running.

    Args:
        frame, number: (R,) of all tracks on nothing, in order of ``frame``, see ``raised``.
        agc_step: (T,) of each frame.
    """
    found: list[Cause] = []
    for name, begins in zip(alarms.key.tolist(), alarms.begins.tolist(), strict=True):
        if agc_step[max(begins - 1, 0) : begins + 1].any():
            found.append("agc_step")
            continue
        first, end = np.searchsorted(frame, [begins + RUNNING - 1, begins + RUNNING])
        found.append(CAUSES[int(cause[first:end][number[first:end] == name][0])])
    return found


def alarm_scores(causes: list[Cause], false_tracks: int, frames: int, hours: float) -> Iterator[Score]:
    """Yield the false alarms: identities that lie on nothing four frames running. One that does so again counts again
    only after ``PAUSE_S`` = 60 s in which it does not.

    ``false_alarms_per_hour``, ``false_alarms_per_hour_CAUSE``: see ``causes_of_alarms``; on land (``shadow``) ground,
    buildings and parked cars. ``false_tracks_per_frame``: tracks on nothing, whether they are alarms or not.
    ``watched_hours``: length of the episode.
    """
    yield Score("false_alarms_per_hour", len(causes) / hours, hours)
    for cause in CAUSES:
        yield Score(f"false_alarms_per_hour_{cause}", causes.count(cause) / hours, hours)
    yield Score("false_tracks_per_frame", false_tracks / frames, float(frames))
    yield Score("watched_hours", hours)


def froc_alarms(
    frame: NDArray[np.int64], identity: NDArray[np.int64], confidence: NDArray[np.float64], pause_frames: float
) -> Iterator[Score]:
    """Yield ``froc_alarms`` (*series* over ``scores.froc.THRESHOLDS``): alarms as if only tracks with such confidence
    were answered, so that the pause after which an identity is another alarm is one of such tracks.

    Arrays are (R,), of all tracks on nothing.
    """
    order = np.lexsort((frame, identity))
    frame, identity, confidence = frame[order], identity[order], confidence[order]
    alarms: list[float] = []
    for threshold in froc.THRESHOLDS:
        kept = confidence >= threshold
        if alarms and kept.all():
            alarms.append(alarms[-1])
            continue
        frame, identity, confidence = frame[kept], identity[kept], confidence[kept]
        alarms.append(float(_count_alarms(frame, identity, pause_frames)))
    yield Score("froc_alarms", alarms)


def _count_alarms(frame: NDArray[np.int64], identity: NDArray[np.int64], pause_frames: float) -> int:
    """Return the number of alarms of tracks on nothing (R,), in order of identities and then of frames."""
    last = RUNNING - 1
    if len(frame) <= last:
        return 0
    number = np.concatenate([[0], np.cumsum(_is_another(frame, identity, pause_frames))])
    runs = number[last:][(identity[:-last] == identity[last:]) & (frame[last:] - frame[:-last] == last)]
    return int(np.count_nonzero(np.diff(runs)) + (len(runs) > 0))


def _is_another(frame: NDArray[np.int64], identity: NDArray[np.int64], pause_frames: float) -> NDArray[np.bool_]:
    """Return (R - 1,) whether a track begins another alarm than the one before, see ``raised``."""
    return np.asarray((np.diff(identity) != 0) | (np.diff(frame) > pause_frames))
