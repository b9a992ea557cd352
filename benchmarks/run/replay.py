"""Runs an episode again for pictures: instants with truth, estimate and larger view."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

from benchmarks.run.contestants import entrant
from benchmarks.run.jobs import OpenJob
from benchmarks.run.records import Row
from benchmarks.run.versions import versions_of
from benchmarks.video.instant import Instant
from scenarios import catalog
from trackers.controllers import catalogue


def replay(live: OpenJob, *, scale: float, wanted: Container[int], frame_count: int) -> Iterator[Instant]:
    """Yield the instants of the ``wanted`` frames among the first ``frame_count`` of a job.

    Each has the answer of the first contestant. At a ``scale`` of 1 the larger view is the observed frame itself.
    """
    for instants in replay_all(live, scale=scale, wanted=wanted, frame_count=frame_count):
        yield instants[0]


def replay_all(live: OpenJob, *, scale: float, wanted: Container[int], frame_count: int) -> Iterator[list[Instant]]:
    """Yield for each of the ``wanted`` frames the instants of all contestants in order, see ``replay``.

    Without contestants it is one instant without an answer.
    """
    for frame in live.frames(frame_count):
        if frame.truth.frame in wanted:
            view = frame.observation.image_rgb if scale == 1 else live.loop.episode.larger_view(scale)
            targets, decides_at = live.targets(frame.truth), [each.guard.decides_at for each in live.watchers]
            answered = zip(live.loop.answers or [None], decides_at or [0.0], strict=True)
            yield [Instant(frame, targets, answer, view, from_on) for answer, from_on in answered]


def made_by_this_code(tracker: str, rows: Sequence[Row]) -> bool:
    """Return whether the current code made a tracker's rows, the controller's code included."""
    made, steered_by = rows[0], rows[0]["controller"]
    carrier = catalog.scenario(made["scenario"]).carrier.name
    try:
        controller = None if steered_by is None else catalogue.controller_entry(steered_by, carrier)
        now = versions_of(made["suite"], made["scenario"], made["preset"], entrant(tracker), controller)
        return now == made["versions"]
    except ValueError:
        return False
