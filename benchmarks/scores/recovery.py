"""Does a tracker get its target back that was away or hidden, how soon, and does it stay on it?"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import stats

RECOVERY_WINDOW_FRAMES = 5
"""A tracker has recovered if it is on the car on ``back_frame`` or one of so many frames after it."""


class Absence(Protocol):
    """A stretch of frames on which the target cannot be seen.

    Attributes:
        back_frame: first frame on which it can be seen again; None if it is away again, or the episode ends, before.
        watch_end_frame: first frame of the next absence, or the number of frames.
    """

    @property
    def back_frame(self) -> int | None: ...

    @property
    def watch_end_frame(self) -> int: ...


@dataclass(frozen=True, slots=True)
class Recovery:
    """How one absence ended for one tracker.

    Attributes:
        recovered: on the target within the window.
        kept: recovered, and on the target one second after the frame it recovered on (or on the last frame
            before the next exit or the episode's end, if that is sooner).
        frames: from ``back_frame`` to the first frame on the target; None = never while watched.
        watched_frames: from ``back_frame`` to the next exit or the episode's end.
        locked_on_other: on one and the same other object in most frames of the window.
    """

    recovered: bool
    kept: bool
    frames: int | None
    watched_frames: int
    locked_on_other: bool


NEVER_BACK = Recovery(False, False, None, 0, False)
"""In closed loop, of a target that the camera never showed again: the tracker steered, so it did not recover."""


def never_back(absence: Absence, frame_count: int) -> bool:
    """Return whether the target stays away until the episode's end."""
    return absence.back_frame is None and absence.watch_end_frame == frame_count


def judge_recovery(
    absence: Absence,
    on_target: NDArray[np.bool_],
    on_other: NDArray[np.int64],
    rate_hz: float,
    window_frames: int = RECOVERY_WINDOW_FRAMES,
) -> Recovery | None:
    """Judge one absence.

    Args:
        on_target: (F,) the estimate is on the target. on_other: (F,) index of the wrong object it is on, -1 =
            none.
        window_frames: recovered is who is on the target on ``back_frame`` or one of so many frames after it.

    Returns:
        None where it cannot be judged: the target was never back, or it was not recovered and the episode
        ended before the window did.
    """
    back, end = absence.back_frame, absence.watch_end_frame
    if back is None:
        return None
    window_end = min(back + window_frames + 1, end)
    hits = np.flatnonzero(on_target[back:end])
    frames = int(hits[0]) if len(hits) else None
    recovered = frames is not None and back + frames < window_end
    cut_short = end == len(on_target) and back + window_frames >= end
    if not recovered and cut_short:
        return None
    kept = False
    if recovered and frames is not None:
        kept = bool(on_target[min(back + frames + round(rate_hz), end - 1)])
    others = on_other[back:window_end]
    locked = any(np.count_nonzero(others == other) > len(others) / 2 for other in np.unique(others[others >= 0]))
    return Recovery(recovered, kept, frames, end - back, bool(locked))


@dataclass(frozen=True, eq=False)
class RecoveryCurve:
    """Share of cars not yet recovered so many frames after they came back in full.

    Attributes:
        frames: (K,) increasing.
        waiting: (K,) share still not recovered *after* that frame, in [0, 1].
        low, high: (K,) 95 % confidence band (log-log); where its formula is undefined, before the first recovery and
            after the last, the curve itself.
    """

    frames: NDArray[np.float64]
    waiting: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def recovery_curve(frames: Sequence[float | None], watched_frames: Sequence[float]) -> RecoveryCurve:
    """Return the Kaplan-Meier estimate of the time to recover.

    ``S(t) = prod_{t_i <= t} (1 - d_i / n_i)``, d_i recoveries at t_i among the n_i cars still watched and not
    yet recovered. A car that is never recovered is censored at the end of its watch (Kaplan and Meier 1958;
    computed by SciPy).

    Args:
        frames: time to recover, None = never. watched_frames: how long each was watched; same length, not
            empty.
    """
    never = np.array([value is None for value in frames])
    data = stats.CensoredData(
        uncensored=np.array([value for value in frames if value is not None], dtype=float),
        right=np.asarray(watched_frames, dtype=float)[never],
    )
    survival = stats.ecdf(data).sf
    with warnings.catch_warnings(), np.errstate(divide="ignore", invalid="ignore"):
        warnings.simplefilter("ignore", RuntimeWarning)
        band = survival.confidence_interval(0.95, method="log-log")
    return RecoveryCurve(
        survival.quantiles,
        survival.probabilities,
        np.where(np.isnan(band.low.probabilities), survival.probabilities, band.low.probabilities),
        np.where(np.isnan(band.high.probabilities), survival.probabilities, band.high.probabilities),
    )
