"""Time limit, CPU time and wall time of a tracker's work, without compilation.

On a fresh machine a kernel is compiled at its first call, which may be anywhere in an episode and takes seconds: that
is not the tracker's fault or its speed. Nor is it that other processes hold the cores: Linux counts for how long a
thread was ready and waited for one.
"""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FrameType
from typing import NamedTuple

from numba.core import event

_CLOCKS = tuple(getattr(signal, name) for name in ("ITIMER_REAL", "ITIMER_VIRTUAL") if hasattr(signal, name))
"""Alarm clocks; Windows has none."""
_SCHEDULED = Path("/proc/thread-self/schedstat")
"""Nanoseconds on a core, nanoseconds of waiting for one, number of times on one."""


class TooSlow(Exception):
    """The work exceeded its time limit."""


class Taken(NamedTuple):
    """Seconds that some work took.

    Attributes:
        cpu_s: of all threads of this process.
        wall_s: that went by, waiting for a sleep, a device or another process included; without the time in which the
            thread waited for a core, where the system tells it (Linux).
    """

    cpu_s: float
    wall_s: float


class Stopwatch(event.Listener):
    """Times work since construction, without numba's compilation."""

    def __init__(self) -> None:
        self._compiling = 0
        self._compile_began = self._compiled = Taken(0.0, 0.0)
        self._left_s = [0.0 for _ in _CLOCKS]
        self._began = _now()

    @property
    def taken(self) -> Taken:
        """Seconds so far."""
        return Taken(*(now - a - b for now, a, b in zip(_now(), self._began, self._compiled, strict=True)))

    def on_start(self, event: event.Event) -> None:
        """Stop the clocks. Called by numba, also for nested compilations."""
        self._compiling += 1
        if self._compiling == 1:
            self._compile_began = _now()
            self._left_s = [_set(clock, 0.0) for clock in _CLOCKS]

    def on_end(self, event: event.Event) -> None:
        """Restart the clocks."""
        self._compiling -= 1
        if self._compiling == 0:
            parts = zip(self._compiled, _now(), self._compile_began, strict=True)
            self._compiled = Taken(*(sum_s + now - began for sum_s, now, began in parts))
            for clock, left_s in zip(_CLOCKS, self._left_s, strict=True):
                _set(clock, left_s)


@contextmanager
def at_most(limit_s: float) -> Iterator[Stopwatch]:
    """Raise TooSlow after ``limit_s`` > 0; code that never returns to Python is ended later, with its process.

    For the main thread only and not nested: there is one alarm clock. Without one nothing is stopped, which is told.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        raise TooSlow

    if not _CLOCKS:
        _tell_without_limit()
    previous = signal.signal(signal.SIGALRM, stop) if _CLOCKS else None
    watch = Stopwatch()
    event.register("numba:compile", watch)
    # The default action of the second clock's signal ends the process without Python.
    for clock, seconds in zip(_CLOCKS, (limit_s, 3.0 * limit_s), strict=False):
        _set(clock, seconds)
    try:
        yield watch
    finally:
        for clock in _CLOCKS:
            _set(clock, 0.0)
        event.unregister("numba:compile", watch)
        if _CLOCKS:
            signal.signal(signal.SIGALRM, previous)


@cache
def _tell_without_limit() -> None:
    """Say once a process that nothing is stopped."""
    print("note: trackers have no time limit here, as this system has no alarm clock", file=sys.stderr)


def _now() -> Taken:
    """Return the state of both clocks; only differences count."""
    return Taken(time.process_time(), time.perf_counter() - _waited_s())


def _waited_s() -> float:
    """Return for how many seconds this thread was ready and waited for a core; 0 where the system does not tell it."""
    try:
        return 1e-9 * int(_SCHEDULED.read_text().split()[1])
    except (OSError, IndexError, ValueError):
        return 0.0


def _set(clock: int, seconds: float) -> float:
    """Set an alarm clock, 0 = off; return the time that was left."""
    return signal.setitimer(clock, seconds)[0]
