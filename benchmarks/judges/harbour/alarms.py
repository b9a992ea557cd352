"""False alarms and their causes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.judges.harbour.matching import History
from benchmarks.judges.harbour.streaks import RUNNING, streaks
from benchmarks.statistics import froc

CAUSES = ("tide", "wave", "bird", "agc_step", "shadow", "other")
_OF_CLUTTER = {
    "moored": "tide",
    "rope": "tide",
    "sea": "wave",
    "bird": "bird",
    "parked": "shadow",
    "land": "shadow",
    "building": "shadow",
}
PAUSE_S = 60.0
_HOUR_S = 3600.0
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
        # Ids of intruders and crews, and those below zero, which are large without a sign, take the last place.
        known = np.minimum(ids.view(np.uint32), len(self._cause_of) - 1)
        counts = np.bincount(self._cause_of[known].ravel(), minlength=len(CAUSES))
        if counts[CAUSES.index("bird")]:
            return CAUSES.index("bird")
        if counts[CAUSES.index("tide")] > _SHARE * ids.size:
            return CAUSES.index("tide")
        return int(counts.argmax()) if ids.size else CAUSES.index("other")


def alarm_scores(history: History, agc_step: NDArray[np.bool_], interval_s: float) -> Iterator[Score]:
    """Yield the false alarms: identities that lie on nothing four frames running. One that does so again counts again
    only after ``PAUSE_S`` = 60 s in which it does not, so that one identity for all that ever moves is not one alarm.

    ``false_alarms_per_hour``, ``false_alarms_per_hour_CAUSE``: a step of the AGC on the frame on which the alarm begins
    or the one before, else what lies in its box on the frame on which it is raised, the last of its first four running;
    on land (``shadow``) ground, buildings and parked cars. ``false_tracks_per_frame``: tracks on nothing, whether they
    are alarms or not. ``watched_hours``: length of the episode.

    Args:
        agc_step: (T,) of each frame.
    """
    frame, identity, confidence = history.false_tracks()
    order = np.lexsort((frame, identity))
    frame, identity, confidence, cause = frame[order], identity[order], confidence[order], history.cause[order]
    number = _numbered(frame, identity, PAUSE_S / interval_s)
    alarms = streaks(frame, number, confidence)
    first = np.searchsorted(number * len(agc_step) + frame, alarms.key * len(agc_step) + alarms.begins)
    cause = cause[first + RUNNING - 1]
    cause[agc_step[alarms.begins] | agc_step[np.maximum(alarms.begins - 1, 0)]] = CAUSES.index("agc_step")
    hours = len(agc_step) * interval_s / _HOUR_S
    yield Score("false_alarms_per_hour", len(cause) / hours, hours)
    for index, name in enumerate(CAUSES):
        yield Score(f"false_alarms_per_hour_{name}", int((cause == index).sum()) / hours, hours)
    yield Score("false_tracks_per_frame", len(frame) / len(agc_step), float(len(agc_step)))
    yield Score("watched_hours", hours)


def froc_alarms(
    frame: NDArray[np.int64], identity: NDArray[np.int64], confidence: NDArray[np.float64], pause_frames: float
) -> Iterator[Score]:
    """Yield ``froc_alarms`` (*series* over ``statistics.froc.THRESHOLDS``): alarms as if only tracks with such
    confidence were answered, so that the pause after which an identity is another alarm is one of such tracks.

    Arrays are (R,), of all tracks on nothing.
    """
    order = np.lexsort((frame, identity))
    frame, identity, confidence = frame[order], identity[order], confidence[order]
    alarms: list[float] = []
    last = RUNNING - 1
    for threshold in froc.THRESHOLDS:
        kept = confidence >= threshold
        if not alarms or not kept.all():
            frame, identity, confidence = frame[kept], identity[kept], confidence[kept]
            number = _numbered(frame, identity, pause_frames)
            whole = (number[:-last] == number[last:]) & (frame[last:] - frame[:-last] == last)
            count = len(np.unique(number[last:][whole]))
        alarms.append(float(count))
    yield Score("froc_alarms", alarms)


def _numbered(frame: NDArray[np.int64], identity: NDArray[np.int64], pause_frames: float) -> NDArray[np.int64]:
    """Return a number (R,) for each track on nothing, the same as long as its identity does not pause for longer.

    Tracks are in order of identities, then of frames, and so are the numbers.
    """
    another = (np.diff(identity) != 0) | (np.diff(frame) > pause_frames)
    return np.cumsum(np.concatenate([[False], another]))[: len(identity)]
