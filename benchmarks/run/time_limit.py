"""How long a piece of a tracker's work may take, and how much CPU time it took. Compiling counts for neither.

On a fresh machine a kernel is compiled when it is first called, which may be anywhere in an episode and takes
seconds: that is no fault of the tracker, and says nothing of its speed.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from numba.core import event


class TooSlow(Exception):
    """The work took longer than it may."""


class Stopwatch(event.Listener):
    """CPU time of this thread since it was made, without what numba compiled meanwhile."""

    def __init__(self) -> None:
        self._began_s = time.thread_time()
        self._compiling = 0
        self._compile_began_s = 0.0
        self._compiled_s = 0.0
        self._left_s = (0.0, 0.0)

    @property
    def cpu_s(self) -> float:
        """Seconds so far."""
        return time.thread_time() - self._began_s - self._compiled_s

    def on_start(self, event: event.Event) -> None:
        """Stop the clocks. Called by numba, also for functions that are compiled on behalf of others."""
        self._compiling += 1
        if self._compiling == 1:
            self._compile_began_s = time.thread_time()
            self._left_s = (_set(signal.ITIMER_REAL, 0.0), _set(signal.ITIMER_VIRTUAL, 0.0))

    def on_end(self, event: event.Event) -> None:
        """Let the clocks go on."""
        self._compiling -= 1
        if self._compiling == 0:
            self._compiled_s += time.thread_time() - self._compile_began_s
            for clock, left_s in zip((signal.ITIMER_REAL, signal.ITIMER_VIRTUAL), self._left_s, strict=True):
                _set(clock, left_s)


@contextmanager
def at_most(limit_s: float) -> Iterator[Stopwatch]:
    """Raise TooSlow after ``limit_s`` > 0; code that never comes back to Python is ended with its process, later.

    Only in the main thread, and not within itself: there is one alarm clock.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        raise TooSlow

    previous = signal.signal(signal.SIGALRM, stop)
    watch = Stopwatch()
    event.register("numba:compile", watch)
    _set(signal.ITIMER_REAL, limit_s)
    # The default action of this signal ends the process, without Python's help.
    _set(signal.ITIMER_VIRTUAL, 3.0 * limit_s)
    try:
        yield watch
    finally:
        _set(signal.ITIMER_REAL, 0.0)
        _set(signal.ITIMER_VIRTUAL, 0.0)
        event.unregister("numba:compile", watch)
        signal.signal(signal.SIGALRM, previous)


def _set(clock: int, seconds: float) -> float:
    """Set an alarm clock, 0 = off; return what was left on it."""
    return signal.setitimer(clock, seconds)[0]
