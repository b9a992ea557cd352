"""The time limit: slow work is stopped, compiling is not counted, the clocks are right afterwards."""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest

from benchmarks.run import time_limit
from benchmarks.run.time_limit import Stopwatch, TooSlow, at_most


def burn(seconds: float) -> None:
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def compile_something() -> None:
    """Compile a function and one that it calls; a second or so of work."""

    @numba.njit
    def inner(values: np.ndarray) -> float:
        return float(np.sort(values)[::2].sum())

    @numba.njit
    def outer(values: np.ndarray) -> float:
        return inner(values) + np.median(values)

    outer(np.arange(5.0))


def test_slow_work_is_stopped() -> None:
    began = time.perf_counter()
    with pytest.raises(TooSlow, match=r"^0.3 s$"), at_most(0.03):
        time.sleep(5)
    assert time.perf_counter() - began < 5


def test_the_limit_is_one_of_cpu_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """What waits for others, e.g. for a core, has longer than what computes: here much longer, for busy machines."""
    monkeypatch.setattr(time_limit, "WALL", 600.0)
    with at_most(0.1):
        time.sleep(0.3)
    with pytest.raises(TooSlow, match=r"^0.1 s of CPU time$"), at_most(0.1):
        burn(5.0)


@pytest.mark.heavy
def test_work_that_goes_on_after_its_limit_is_ended_with_its_process() -> None:
    child = multiprocessing.get_context("spawn").Process(target=never_end)
    child.start()
    child.join()
    assert child.exitcode == 1


def never_end() -> None:
    """Ignore what the limit raises."""
    with at_most(0.02):
        while True:
            with contextlib.suppress(TooSlow):
                time.sleep(100)


def test_beside_the_main_thread_there_is_no_limit_which_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    time_limit._note_without_limit.cache_clear()
    with ThreadPoolExecutor() as pool:
        assert pool.submit(taken_asleep).result() >= 0.05
    assert capsys.readouterr().err.startswith("note: trackers have no time limit here")


def taken_asleep() -> float:
    """Return the wall time of a sleep longer than its limit."""
    with at_most(0.005) as watch:
        time.sleep(0.06)
        return watch.taken.wall_s


def test_work_in_time_is_timed_and_leaves_no_alarm() -> None:
    before = signal.getsignal(signal.SIGALRM)
    with at_most(5.0) as watch:
        burn(0.05)
        taken = watch.taken
    assert taken.cpu_s >= 0.05
    assert taken.wall_s >= 0.05
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)
    assert signal.getitimer(signal.ITIMER_VIRTUAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) == before


def test_wall_time_counts_what_is_waited_for_but_no_waiting_for_a_core(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A clock that is told how long the thread was ready; without it all that went by counts."""
    scheduled = tmp_path / "schedstat"
    scheduled.write_text("7 0 1\n")
    monkeypatch.setattr(time_limit, "_SCHEDULED", scheduled)
    now = iter([100.0, 103.0])
    monkeypatch.setattr(time_limit.time, "perf_counter", lambda: next(now))
    watch = Stopwatch()
    scheduled.write_text("7 2000000000 1\n")
    assert watch.taken.wall_s == pytest.approx(1.0)
    scheduled.unlink()
    now = iter([100.0, 103.0])
    assert Stopwatch().taken.wall_s == pytest.approx(3.0)


@pytest.mark.heavy
def test_compiling_counts_neither_against_the_limit_nor_as_work() -> None:
    compile_something()  # What numba itself loads at its first compilation is not the point.
    began = time.thread_time()
    compile_something()
    compiling_s = time.thread_time() - began
    assert compiling_s > 0.15, "too quick here to show anything"
    began = time.thread_time()
    with at_most(0.6 * compiling_s) as watch:
        compile_something()
        worked_s = watch.taken.cpu_s
    assert time.thread_time() - began > 0.6 * compiling_s
    assert worked_s < 0.4 * compiling_s


@pytest.mark.heavy
def test_the_limit_holds_again_after_compiling() -> None:
    began = time.perf_counter()

    def compile_then_sleep() -> None:
        compile_something()
        time.sleep(20)

    with pytest.raises(TooSlow), at_most(0.1):
        compile_then_sleep()
    assert time.perf_counter() - began < 15


def test_a_compilation_shortly_before_the_limit_leaves_the_time_between_alarms() -> None:
    """Else one that cleans up after the first alarm has the next ones at once, and is ended with its process."""
    with at_most(5.0) as watch:
        signal.setitimer(signal.ITIMER_REAL, 0.5, 50.0)
        watch.on_start(None)  # type: ignore[arg-type]
        assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
        watch.on_end(None)  # type: ignore[arg-type]
        left_s, every_s = signal.getitimer(signal.ITIMER_REAL)
        assert 0.0 < left_s <= 0.5
        assert every_s == 50.0
