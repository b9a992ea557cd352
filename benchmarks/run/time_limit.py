"""Time limits, CPU time and wall time of a tracker's work, without compilation.

On a fresh machine a kernel is compiled at its first call, which may be anywhere in an episode and takes seconds: that
is not the tracker's fault or its speed. Nor is it that other processes hold the cores: Linux counts for how long a
thread was ready and waited for one.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

from numba.core import event

from sim.checks import check

_CLOCKS = (signal.ITIMER_PROF, signal.ITIMER_REAL, signal.ITIMER_VIRTUAL)
"""Alarm clocks of CPU time, wall time and CPU time outside of the system."""
WALL = 10.0
"""Limit of wall time over that of CPU time: for what sleeps or waits for ever, not for what waits for a busy core."""
_LONGEST_S = 1_000_000
_DEAF = 3
"""Limits after which work that has not ended is ended with its process."""
_SCHEDULED = Path("/proc/thread-self/schedstat")
"""Nanoseconds on a core, nanoseconds of waiting for one, number of times on one."""


class TooSlow(Exception):
    """The work exceeded a limit; the text says how long it took."""


class Taken(NamedTuple):
    """Seconds that some work took.

    Attributes:
        cpu_s: of all threads of this process.
        wall_s: that went by, waiting for a sleep, a device or another process included; without the time in which the
            thread waited for a core, where the system counts that (Linux).
    """

    cpu_s: float
    wall_s: float


class Stopwatch(event.Listener):
    """Times work since construction, without numba's compilation.

    Attributes:
        clocks: alarm clocks that stand still during compilation.
    """

    def __init__(self, clocks: Sequence[int] = ()) -> None:
        self.clocks = clocks
        self._compiling = 0
        self._compile_began = self._compiled = Taken(0.0, 0.0)
        self._left_s = [(0.0, 0.0) for _ in clocks]
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
            self._left_s = [signal.setitimer(clock, 0.0) for clock in self.clocks]

    def on_end(self, event: event.Event) -> None:
        """Restart the clocks."""
        self._compiling -= 1
        if self._compiling == 0:
            parts = zip(self._compiled, _now(), self._compile_began, strict=True)
            self._compiled = Taken(*(sum_s + now - began for sum_s, now, began in parts))
            for clock, (left_s, every_s) in zip(self.clocks, self._left_s, strict=True):
                signal.setitimer(clock, left_s, every_s)


def check_limit(limit_s: Any) -> None:
    """Raise ValueError for what is no limit of CPU time: longer ones no alarm clock takes."""
    good = isinstance(limit_s, int | float) and 0 < limit_s <= _LONGEST_S
    check("limit_s", good, f"a number of seconds > 0, at most {_LONGEST_S:,}", repr(limit_s))


@contextmanager
def at_most(limit_s: float) -> Iterator[Stopwatch]:
    """Raise TooSlow after ``limit_s`` > 0 seconds of CPU time of the process, or ten times that of wall time.

    Code that never returns to Python, or goes on all the same, is ended after three times these limits, with its
    process. Not nested: there is one alarm clock of each kind. Alarms reach the main thread alone: in another one
    nothing is stopped, and a note says so.
    """
    calls = 0

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal calls
        calls += 1
        if calls == _DEAF:
            os._exit(1)
        raise TooSlow(f"{limit_s:g} s of CPU time" if number == signal.SIGPROF else f"{WALL * limit_s:g} s")

    clocks = _CLOCKS if threading.current_thread() is threading.main_thread() else ()
    if not clocks:
        _note_without_limit()
    previous = {number: signal.signal(number, stop) for number in (signal.SIGPROF, signal.SIGALRM)} if clocks else {}
    watch = Stopwatch(clocks)
    event.register("numba:compile", watch)
    # The default action of the third clock's signal ends the process without Python.
    for clock, seconds in zip(clocks, (limit_s, WALL * limit_s, _DEAF * limit_s), strict=False):
        signal.setitimer(clock, seconds, seconds)
    try:
        yield watch
    finally:
        for clock in clocks:
            signal.setitimer(clock, 0.0)
        event.unregister("numba:compile", watch)
        for number, action in previous.items():
            signal.signal(number, action)


@cache
def _note_without_limit() -> None:
    """Say once a process that nothing is stopped."""
    print("note: trackers have no time limit here, which needs the main thread", file=sys.stderr)


def _now() -> Taken:
    """Return the state of both clocks; only differences count."""
    return Taken(time.process_time(), time.perf_counter() - _waited_s())


def _waited_s() -> float:
    """Return for how many seconds this thread was ready and waited for a core; 0 where the system does not count it."""
    try:
        return 1e-9 * int(_SCHEDULED.read_text().split()[1])
    except (OSError, IndexError, ValueError):
        return 0.0
