"""Jobs in worker processes, which a tracker may kill."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import joblib
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.run.jobs import Job, JobResult, run_job
from benchmarks.run.notes import read_note


def results(jobs: Sequence[Job], workers: int, backend: str) -> Iterator[JobResult]:
    """Yield results as they come; a job whose worker dies is run again without the tracker that killed it.

    Args:
        workers: processes; 0 = this very one. backend: joblib's.
    """
    if workers == 0:
        yield from map(run_job, jobs)
        return
    waiting = {job.note_file: job for job in jobs}
    while waiting:
        try:
            for result in _in_processes(tuple(waiting.values()), workers, backend):
                del waiting[result.job.note_file]
                yield result
        except BrokenProcessPool:
            # One death ends the whole pool: who was at work is suspect, and is tried alone.
            suspects = [job for job in waiting.values() if job.note_file.exists()]
            if not suspects:
                raise RuntimeError("a worker process ended outside of any episode; the same command goes on") from None
            for job in suspects:
                del waiting[job.note_file]
                yield _alone(job, backend)


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
