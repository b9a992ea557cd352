"""Recovery of a target after an absence: whether, how soon, and whether the tracker stays on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Event, Score
from benchmarks.contract.metric import Quantity

RECOVERY_WINDOW_FRAMES = 5
"""A tracker has recovered if it is on the target on ``back_frame`` or within this number of frames after it."""


class Absence(Event, Protocol):
    """A stretch of frames on which the target cannot be seen.

    Attributes:
        first_frame: the first of them.
        back_frame: first frame on which it can be seen again; None if the next absence or the episode's end is sooner.
        watch_end_frame: first frame of the next absence, or the number of frames.
    """

    @property
    def first_frame(self) -> int: ...

    @property
    def back_frame(self) -> int | None: ...

    @property
    def watch_end_frame(self) -> int: ...


@dataclass(frozen=True, slots=True)
class Recovery:
    """The outcome of one absence for one tracker.

    Attributes:
        recovered: on the target within the window, and before the next absence.
        kept: recovered, and on the target a while after the frame it recovered on (or on the last frame before the next
            absence, if that is sooner).
        locked_on_other: on the same other object in most frames of the window.
    """

    recovered: bool
    kept: bool
    locked_on_other: bool


NEVER_BACK = Recovery(False, False, False)
"""In closed loop, for a target that never came back into the picture: the tracker steered, so it did not recover."""


def judge_recovery(
    absence: Absence,
    on_target: NDArray[np.bool_],
    on_other: NDArray[np.int64],
    *,
    window_frames: int = RECOVERY_WINDOW_FRAMES,
    kept_frames: int = 0,
    closed_loop: bool,
) -> Recovery | None:
    """Judge one absence.

    The truth alone decides which absences are judged: those followed by at least ``window_frames + kept_frames``
    frames. Otherwise late successes would count and late failures would not. The frames are counted from the target's
    return; in closed loop, where the return depends on the tracker, from the start of the absence.

    Args:
        on_target: (F,) the estimate is on the target. on_other: (F,) index of the wrong object it is on, -1 = none.
        window_frames: the tracker has recovered if it is on the target on ``back_frame`` or within so many frames.
        kept_frames: number of frames after the recovery at which the tracker must still be on the target.

    Returns:
        None if it cannot be judged: too near the episode's end, or the next absence began before the return.
    """
    back, end, frame_count = absence.back_frame, absence.watch_end_frame, len(on_target)
    since = absence.first_frame if closed_loop else back
    if since is None or since + window_frames + kept_frames >= frame_count:
        return None
    if back is None:
        return NEVER_BACK if end == frame_count else None
    window = slice(back, min(back + window_frames + 1, end))
    hits = np.flatnonzero(on_target[window])
    kept = len(hits) > 0 and bool(on_target[min(back + int(hits[0]) + kept_frames, end - 1)])
    others = on_other[window]
    most = np.bincount(others[others >= 0]).max(initial=0)
    return Recovery(len(hits) > 0, kept, bool(most > len(others) / 2))


def time_scores(absence: Absence, on_target: NDArray[np.bool_], *, closed_loop: bool) -> Iterator[Score]:
    """Yield ``recovery_frames``, from ``back_frame`` to the first frame on the target, None = never while watched, and
    ``watched_frames``, from ``back_frame`` to the next absence or the episode's end.

    A missing recovery is censored there, so that late returns count too. In closed loop a target that never returned
    was watched for 0 frames; otherwise nothing is yielded without a return.
    """
    back, end = absence.back_frame, absence.watch_end_frame
    if back is None and not (closed_loop and end == len(on_target)):
        return
    first = end if back is None else back
    hits = np.flatnonzero(on_target[first:end])
    yield Score("recovery_frames", float(hits[0]) if len(hits) else None, event=absence)
    yield Score("watched_frames", float(end - first), event=absence)


KAPLAN_MEIER = "Kaplan and Meier, Nonparametric estimation from incomplete observations, JASA 53, 1958"


def recovery_times(conditions: str, *defined_by: Any) -> list[Quantity]:
    """Return the quantities ``recovery_frames`` and ``watched_frames`` of a suite, in whose events they are counted."""
    by = time_scores, *defined_by
    return [Quantity(f"{name}_frames", 0, inf, conditions, KAPLAN_MEIER, by) for name in ("recovery", "watched")]
