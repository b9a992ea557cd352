"""Jobs in worker processes, which a tracker may kill."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from numbers import Integral
from typing import Any, TypeVar

import cloudpickle
import joblib
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.run.jobs import Job, JobResult, read_note, run_job
from benchmarks.run.own_modules import load_modules
from sim.checks import check
from trackers.clients.remote import end_idle

_Given = TypeVar("_Given")
_Made = TypeVar("_Made")

# joblib replaces a worker that has grown by 300 MB, for which a kept town is enough, and warns as of a fault.
warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)


def cores(workers: int | None) -> int:
    """Return the number of workers, by default one for each core of this process.

    Raises:
        ValueError: unless it is a whole number >= 0.
    """
    good = workers is None or (isinstance(workers, Integral) and workers >= 0)
    check("workers", good, "a whole number >= 0", repr(workers))
    return joblib.cpu_count() if workers is None else workers


def results(jobs: Iterable[Job], workers: int) -> Iterator[tuple[Job, JobResult]]:
    """Yield jobs with their results as they arrive.

    A job whose worker died is run again without the tracker that ended it.

    Args:
        jobs: consumed one by one. workers: processes; 0 = this process.

    Raises:
        ChildProcessError: if a process ends outside of any tracker.
    """
    coming = iter(jobs)
    waiting: dict[str, Job] = {}
    ended = False
    while not ended:
        try:
            for result in _run(_taken(coming, waiting), workers):
                yield waiting.pop(result.name), result
            ended = True
        except BrokenProcessPool:
            # One dead worker ends the whole pool: each job that was running is suspect and is run alone.
            suspects = [job for job in waiting.values() if job.note_file is not None and job.note_file.exists()]
            if not suspects:
                raise ChildProcessError(
                    "a worker process ended outside of any episode; the same command continues"
                ) from None
            for job in suspects:
                del waiting[job.name]
                yield job, _alone(job)


def _taken(coming: Iterator[Job], waiting: dict[str, Job]) -> Iterator[Job]:
    """Yield the jobs that an earlier pool did not finish, then the new ones, which are added to ``waiting``."""
    yield from tuple(waiting.values())
    for job in coming:
        waiting[job.name] = job
        yield job


def _alone(job: Job) -> JobResult:
    """Run one job in its own process until it completes, each time without the tracker that ended it."""
    while True:
        try:
            return next(_run([job], 1))
        except BrokenProcessPool:
            note = read_note(job.note_file)
            if note is None or note[0] in job.deadly:
                words = f"{job.episode.in_words}: its process ends outside of any tracker"
                raise ChildProcessError(words) from None
            job = replace(job, deadly={**job.deadly, note[0]: note[1]})


def _run(jobs: Iterable[Job], workers: int) -> Iterator[JobResult]:
    return in_processes(run_job, jobs, workers, modules=lambda job: job.modules)


def in_processes(
    function: Callable[[_Given], _Made],
    given: Iterable[_Given],
    workers: int,
    *,
    modules: Callable[[_Given], tuple[str, ...]] = lambda each: (),
) -> Iterator[_Made]:
    """Yield what a function makes of each of ``given``, as it comes.

    Args:
        given: consumed one by one. workers: processes; 0 = this process.
        modules: users' own modules that a worker imports before it unpacks one of ``given``, which may hold what they
            define.

    Raises:
        BrokenProcessPool: if a process ended.
    """
    if workers == 0:
        yield from map(function, given)
        return
    # joblib runs n_jobs = 1 in this process: two processes with one job in flight act as one worker.
    parallel = joblib.Parallel(
        n_jobs=max(workers, 2),
        pre_dispatch=workers if workers == 1 else "2 * n_jobs",
        batch_size=1,
        return_as="generator_unordered",
    )
    packed = (joblib.delayed(_unpacked)(modules(each), cloudpickle.dumps((function, each))) for each in given)
    yield from parallel(packed)


def end_workers(workers: int) -> None:
    """End the processes that wait for more jobs, and with them those of trackers that wait for another episode.

    Args:
        workers: as of the jobs before; with 0 these are processes of this one.
    """
    end_idle()
    if workers > 0:
        get_reusable_executor().shutdown(wait=True)


def _unpacked(modules: tuple[str, ...], packed: bytes) -> Any:
    load_modules(modules)
    function, given = cloudpickle.loads(packed)
    return function(given)
