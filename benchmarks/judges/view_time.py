"""Time in view of the target, and losses: the same definitions in every suite.

Frames are those of an episode, from frame 0. No command led to frame 0, so shares are over the steps, frames 1 to
F - 1. *In view* is a frame with the target's centre in the picture, hidden or not, its amodal box at least
``shortest_length_px`` long, and a view no wider than its scene allows (``Scenario.widest_view_m``); *seen* is a frame
in view on which at least half of the target is visible (``MOSTLY_SEEN``). All of this is in ``scenarios.visibility``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity
from benchmarks.judges.runs import runs
from scenarios.visibility import MOSTLY_SEEN

LOSS_S = 1.0
"""A loss is a stretch out of view longer than this."""


@dataclass(frozen=True, slots=True)
class Loss:
    """A stretch of frames out of view that lasts longer than ``LOSS_S``.

    Its rows: ``watched_frames`` is its length; ``recovery_frames`` is the same, or null if the target never came back;
    ``rate_hz``, frames a second, converts both to seconds.

    Attributes:
        index: its place in the episode, from 0.
        first_frame: first frame out of view. length_frames: number of frames.
        back_frame: first frame in view again; None if the episode ended before.
    """

    index: int
    first_frame: int
    length_frames: int
    back_frame: int | None

    def attributes(self) -> dict[str, Any]:
        """Return its attributes in rows."""
        return {"kind": "loss", **asdict(self)}


def find_losses(in_view: NDArray[np.bool_], rate_hz: float, longer_than_s: float = LOSS_S) -> list[Loss]:
    """Return the stretches out of view (F,) that last longer than ``longer_than_s``, in order."""
    long = [(first, end) for first, end in runs(~in_view) if end - first > longer_than_s * rate_hz]
    return [
        Loss(index, first, end - first, end if end < len(in_view) else None) for index, (first, end) in enumerate(long)
    ]


def view_scores(in_view: NDArray[np.bool_], visible_fraction: NDArray[np.float64], rate_hz: float) -> Iterator[Score]:
    """Yield ``time_seen``, ``time_in_view`` and ``losses_per_minute`` of an episode, all of its steps.

    Args:
        in_view: (F,) see above. visible_fraction: (F,) visible share of the target, in [0, 1].
    """
    steps = float(len(in_view) - 1)
    seen = in_view & (visible_fraction >= MOSTLY_SEEN)
    yield Score("time_seen", float(seen[1:].mean()), steps)
    yield Score("time_in_view", float(in_view[1:].mean()), steps)
    yield Score("losses_per_minute", 60.0 * len(find_losses(in_view, rate_hz)) * rate_hz / steps, steps)


def _metric(name: str, summary: str, unit: str, better: Better, high: float, *defined_by: Any) -> Metric:
    steps = "every frame but the first, of episodes in closed loop"
    return Metric(name, summary, unit, better, Mean(Quantity(name, 0, high, steps, OWN, defined_by)))


_THIS_MODULE = sys.modules[__name__]
_SEEN = f"time in view with at least {MOSTLY_SEEN:.0%} of the target visible"
_IN_VIEW = "time with the target's centre in the picture, hidden or not, as large as its scene asks (12 px or more)"
_LOSSES = f"stretches out of view longer than {LOSS_S:g} s"
TIME_SEEN = _metric("time_seen", _SEEN, "fraction", "higher", 1, _THIS_MODULE)
TIME_IN_VIEW = _metric("time_in_view", _IN_VIEW, "fraction", "higher", 1, _THIS_MODULE)
LOSSES_PER_MINUTE = _metric("losses_per_minute", _LOSSES, "1/min", "lower", inf, view_scores, Loss)
