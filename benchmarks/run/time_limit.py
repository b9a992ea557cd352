"""Time limit and CPU time of a tracker's work, without compilation.

On a fresh machine a kernel is compiled at its first call, which may be anywhere in an episode and takes seconds: that
is not the tracker's fault or its speed.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from numba.core import event


class TooSlow(Exception):
    """The work exceeded its time limit."""


class Stopwatch(event.Listener):
    """CPU time of this thread since construction, without numba's compilation."""

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
        """Stop the clocks. Called by numba, also for nested compilations."""
        self._compiling += 1
        if self._compiling == 1:
            self._compile_began_s = time.thread_time()
            self._left_s = (_set(signal.ITIMER_REAL, 0.0), _set(signal.ITIMER_VIRTUAL, 0.0))

    def on_end(self, event: event.Event) -> None:
        """Restart the clocks."""
        self._compiling -= 1
        if self._compiling == 0:
            self._compiled_s += time.thread_time() - self._compile_began_s
            for clock, left_s in zip((signal.ITIMER_REAL, signal.ITIMER_VIRTUAL), self._left_s, strict=True):
                _set(clock, left_s)


@contextmanager
def at_most(limit_s: float) -> Iterator[Stopwatch]:
    """Raise TooSlow after ``limit_s`` > 0; code that never returns to Python is ended later, with its process.

    For the main thread only and not nested: there is one alarm clock.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        raise TooSlow

    previous = signal.signal(signal.SIGALRM, stop)
    watch = Stopwatch()
    event.register("numba:compile", watch)
    _set(signal.ITIMER_REAL, limit_s)
    # The default action of this signal ends the process without Python.
    _set(signal.ITIMER_VIRTUAL, 3.0 * limit_s)
    try:
        yield watch
    finally:
        _set(signal.ITIMER_REAL, 0.0)
        _set(signal.ITIMER_VIRTUAL, 0.0)
        event.unregister("numba:compile", watch)
        signal.signal(signal.SIGALRM, previous)


def _set(clock: int, seconds: float) -> float:
    """Set an alarm clock, 0 = off; return the time that was left."""
    return signal.setitimer(clock, seconds)[0]
