"""Fair time: pictures arrive at a fixed rate, whether a tracker is ready for them or not.

The rule is that of the real-time experiment of VOT (Kristan et al., The Visual Object Tracking VOT2017 challenge
results, ICCV workshops 2017), with the grace of its toolkit (``RealtimeTrackerRuntime``, and ``grace: 3`` of its
stacks):

- Picture k arrives k periods after the first one. A tracker that is idle then takes it; one that still works on an
  earlier one never gets it.
- The answer that stands for picture k is the latest one that was ready when picture k + 1 arrived (zero-order hold).
- Three calls, the start included, may take longer than a period and count as one period: they load code and models.

The clock is simulated, so that nothing sleeps: each call takes its measured wall time, see ``time_limit.Taken``. That
is without compilation and, on Linux, without waiting for a busy core; construction is not timed, as VOT's start of a
process is not. What a failed tracker answered before is not held: it answers nothing from there on, as elsewhere.

The toolkit is milder in two points: a late answer stands for its own picture already, and what is left of a period
when a tracker becomes ready is forgiven.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from benchmarks.contract.judging import Score
from benchmarks.judges.tracker_speed import frames_seen
from benchmarks.run.guards import GuardedTracker
from scenarios.scenario import Frame
from trackers.types import Answer, Start

GRACE = 3
"""Calls that may take longer than a period and count as one."""


class RealTimeTracker(GuardedTracker):
    """A guarded tracker that gets the pictures that arrive while it is idle; its answers are those that stand.

    It does not revise its answers: the last picture has gone by then.
    """

    def __init__(self, *given: Any, rate_hz: float, **how: Any) -> None:
        """``rate_hz``: pictures a second. ``given``, ``how``: see ``GuardedTracker``."""
        self._rate_hz, self._grace, self._pictures = rate_hz, GRACE, 0
        self._ready_at = 0.0
        """When the latest answer was ready, in periods since the first picture."""
        self._standing: Answer = ()
        self._latest: Answer = ()
        super().__init__(*given, **how)

    def initialise(self, frame: Frame, start: Start) -> Answer:
        """See ``LoopTracker``. Until the tracker has started a given box stands."""
        self._standing = self.before(start)
        return self._standing_after(frame, super().initialise(frame, start))

    def update(self, frame: Frame) -> Answer:
        """See ``LoopTracker``."""
        if self.reason is None and self._ready_at > frame.truth.frame:
            return self.watched(frame, self._standing_at(frame))
        return self._standing_after(frame, super().update(frame))

    def _standing_after(self, frame: Frame, answer: Answer) -> Answer:
        """Return what stands for a picture that the tracker has taken."""
        self._latest, periods = answer, self.took.wall_s * self._rate_hz
        if periods > 1 and self._grace > 0:
            self._grace, periods = self._grace - 1, 1.0
        self._ready_at = frame.truth.frame + periods
        return self._standing_at(frame)

    def _standing_at(self, frame: Frame) -> Answer:
        self._pictures = frame.truth.frame + 1
        if self.reason is not None or self._ready_at <= self._pictures:
            self._standing = self._latest
        return self._standing

    def revises(self) -> bool:
        """See ``GuardedTracker``."""
        return False

    def scores(self) -> Iterator[Score]:
        """See ``GuardedTracker``; and the share of pictures that it saw."""
        yield from super().scores()
        if self._pictures:
            yield frames_seen(len(self.taken), self._pictures, self.failed_at_frame)
