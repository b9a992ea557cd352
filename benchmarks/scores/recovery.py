"""Does a tracker get its target back that was away or hidden, how soon, and does it stay on it?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from benchmarks.suites.judging import Event, Score

RECOVERY_WINDOW_FRAMES = 5
"""A tracker has recovered if it is on the car on ``back_frame`` or one of so many frames after it."""


class Absence(Event, Protocol):
    """A stretch of frames on which the target cannot be seen.

    Attributes:
        first_frame: the first of them.
        back_frame: first frame on which it can be seen again; None if it is away again, or the episode ends, before.
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
    """How one absence ended for one tracker.

    Attributes:
        recovered: on the target within the window, and before the next absence.
        kept: recovered, and on the target a while after the frame it recovered on (or on the last frame before the next
            absence, if that is sooner).
        locked_on_other: on one and the same other object in most frames of the window.
    """

    recovered: bool
    kept: bool
    locked_on_other: bool


NEVER_BACK = Recovery(False, False, False)
"""In closed loop, of a target that the camera never showed again: the tracker steered, so it did not recover."""


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

    Which ones can be judged is decided by the truth alone, whatever the tracker says: those since which the episode
    goes on for ``window_frames + kept_frames``. Otherwise late successes would count and late failures would not. The
    time runs from the target's return on; in closed loop, where the tracker steers and the return is its doing, from
    the beginning of the absence on.

    Args:
        on_target: (F,) the estimate is on the target. on_other: (F,) index of the wrong object it is on, -1 = none.
        window_frames: the tracker has recovered if it is on the target on ``back_frame`` or one of so many after it.
        kept_frames: so many frames after the one it recovered on it is asked again.

    Returns:
        None where it cannot be judged: too near the episode's end, or away again before it was back.
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
    locked = any(np.count_nonzero(others == other) > len(others) / 2 for other in np.unique(others[others >= 0]))
    return Recovery(len(hits) > 0, kept, bool(locked))


def time_scores(absence: Absence, on_target: NDArray[np.bool_], *, closed_loop: bool) -> Iterator[Score]:
    """Yield ``recovery_frames``, from ``back_frame`` to the first frame on the target, None = never while watched, and
    ``watched_frames``, from ``back_frame`` to the next absence or the episode's end.

    One that is not recovered is censored there, so that every return counts, late ones too. In closed loop a target
    that never returned was watched for 0 frames; otherwise there is nothing to tell without a return.
    """
    back, end = absence.back_frame, absence.watch_end_frame
    if back is None and not (closed_loop and end == len(on_target)):
        return
    first = end if back is None else back
    hits = np.flatnonzero(on_target[first:end])
    yield Score("recovery_frames", float(hits[0]) if len(hits) else None, event=absence)
    yield Score("watched_frames", float(end - first), event=absence)
