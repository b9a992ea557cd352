"""Runs an episode again for pictures: instants with truth, estimate and larger view."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

from benchmarks.contract.rows import Row
from benchmarks.run.episodes import EpisodeSpec, editions_of
from benchmarks.run.experiment import Progress
from benchmarks.run.jobs import OpenJob
from benchmarks.run.selection import job_of
from benchmarks.show.video.drawing import Instant
from trackers.types import Answer


def replay(live: OpenJob, *, scale: float, wanted: Container[int], frame_count: int) -> Iterator[Instant]:
    """Yield the instants of the ``wanted`` frames among the first ``frame_count`` of a job.

    Each has the answer of the first tracker. At a ``scale`` of 1 the larger view is the observed frame itself.
    """
    for instants in replay_all(live, scale=scale, wanted=wanted, frame_count=frame_count):
        yield instants[0]


def replay_all(
    live: OpenJob,
    *,
    scale: float,
    wanted: Container[int],
    frame_count: int,
    progress: Progress = lambda done, of: None,
) -> Iterator[list[Instant]]:
    """Yield for each of the ``wanted`` frames the instants of all trackers in order, see ``replay``.

    Without trackers it is one instant without an answer. ``progress``: called with the number of frames that have been
    run, and of all.
    """
    for done, frame in enumerate(live.frames(frame_count), 1):
        progress(done, frame_count)
        if frame.truth.frame in wanted:
            view = frame.observation.image_rgb if scale == 1 else live.loop.episode.larger_view(scale)
            targets, decides_at = live.targets(frame.truth), [each.guard.decides_at for each in live.runs]
            answers: Sequence[Answer | None] = live.loop.answers or [None]
            answered = zip(answers, decides_at or [0.0], strict=True)
            yield [Instant(frame, targets, answer, view, from_on) for answer, from_on in answered]


def is_of_present_editions(row: Row, episode: EpisodeSpec | None = None) -> bool:
    """Return whether a row is of the present editions, the controller's included; ``episode``: see ``job_of``."""
    try:
        job = job_of(row, row["seed"], episode)
        return editions_of(job.suite, job.episode, job.trackers[row["tracker"]]) == row.get("editions")
    except ValueError:
        return False
