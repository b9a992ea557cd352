"""The report's picture of one event, kept in the result folder as long as the rows do not change."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Condition
from benchmarks.run.jobs import Job
from benchmarks.run.selection import job_of
from benchmarks.show.pictures import made_from, remove_picture, write_picture
from benchmarks.show.replay import is_of_present_editions

Sheet = tuple[NDArray[np.uint8], str, str]
"""Picture (H, W, 3), title and caption."""


def keep_event_picture(
    directory: Path,
    condition: Condition,
    trackers: Mapping[str, Sequence[Row]],
    shown: Sequence[str],
    found: tuple[int, dict[str, Any]] | None,
    draw: Callable[[Sequence[Job], dict[str, Any]], Sheet],
) -> None:
    """Write the picture of an event, unless it exists; remove it where it is out of date.

    Args:
        trackers: rows by tracker. shown: the trackers in the picture.
        found: seed and attributes of the event. No picture is written for None, nor for rows of other editions, whose
            runs cannot be repeated.
        draw: returns the picture from the jobs, which have the trackers in order, and the event.
    """
    name = "-".join(filter(None, condition))
    key = json.dumps([found, [(tracker, trackers[tracker][0].get("editions")) for tracker in shown]])
    if made_from(directory, name) == key:
        return
    remove_picture(directory, name)
    if found is not None and all(is_of_present_editions(trackers[tracker][0]) for tracker in shown):
        seed, event = found
        sheet, title, caption = draw(_jobs([trackers[tracker][0] for tracker in shown], seed), event)
        write_picture(directory, name, sheet, condition, title, f"Seed {seed}: {caption}", key)


def _jobs(rows: Sequence[Row], seed: int) -> list[Job]:
    """Return the jobs that repeat the runs of rows: on a set path one, as all trackers see the same pictures."""
    jobs = [job_of(row, seed) for row in rows]
    if any(job.episode.steering is not None for job in jobs):
        return jobs
    modules = tuple(dict.fromkeys(name for job in jobs for name in job.modules))
    trackers = {name: spec for job in jobs for name, spec in job.trackers.items()}
    return [replace(jobs[0], trackers=trackers, modules=modules, limit_s=min(job.limit_s for job in jobs))]
