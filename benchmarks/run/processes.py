"""Jobs in worker processes, which a tracker may kill."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import joblib
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.run.jobs import Job, JobResult, run_job
from benchmarks.run.notes import read_note


def results(jobs: Iterable[Job], workers: int, backend: str) -> Iterator[JobResult]:
    """Yield results as they come; a job whose worker dies is run again without the tracker that killed it.

    Args:
        jobs: taken one after the other, as they are worked at. workers: processes; 0 = this very one.
        backend: joblib's.
    """
    if workers == 0:
        yield from map(run_job, jobs)
        return
    coming = iter(jobs)
    waiting: dict[str, Job] = {}
    ended = False
    while not ended:
        try:
            for result in _in_processes(_taken(coming, waiting), workers, backend):
                del waiting[result.job.name]
                yield result
            ended = True
        except BrokenProcessPool:
            # One death ends the whole pool: who was at work is suspect, and is tried alone.
            suspects = [job for job in waiting.values() if job.note_file is not None and job.note_file.exists()]
            if not suspects:
                raise RuntimeError("a worker process ended outside of any episode; the same command goes on") from None
            for job in suspects:
                del waiting[job.name]
                yield _alone(job, backend)


def _taken(coming: Iterator[Job], waiting: dict[str, Job]) -> Iterator[Job]:
    """Yield the jobs that an earlier pool was given and did not end, then those to come, which are noted in
    ``waiting``.
    """
    yield from tuple(waiting.values())
    for job in coming:
        waiting[job.name] = job
        yield job


def _alone(job: Job, backend: str) -> JobResult:
    """Run one job in a process of its own until it comes through, each time without what killed it."""
    while True:
        try:
            return next(_in_processes([job], 1, backend))
        except BrokenProcessPool:
            said = read_note(job.note_file)
            if said is None or said[0] in job.deadly:
                raise RuntimeError(
                    f"{job.scenario} {job.preset}, seed {job.seed}: its process ends outside of any tracker"
                ) from None
            job = replace(job, deadly={**job.deadly, said[0]: said[1]})


def _in_processes(jobs: Iterable[Job], workers: int, backend: str) -> Iterator[JobResult]:
    # With one job in flight two processes take turns: one worker, but never this process.
    parallel = joblib.Parallel(
        n_jobs=max(workers, 2),
        pre_dispatch=workers if workers == 1 else "2 * n_jobs",
        batch_size=1,
        return_as="generator_unordered",
        backend=backend,
    )
    yield from parallel(joblib.delayed(run_job)(job) for job in jobs)
