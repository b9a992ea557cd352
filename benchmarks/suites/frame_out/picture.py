"""The report's look at one frame-out: found in the rows, lived through again, drawn as a contact sheet."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.report.pictures import made_from, remove_picture, write_picture
from benchmarks.run.jobs import Job, job_of, opened
from benchmarks.run.records import Row
from benchmarks.run.replay import made_by_this_code, replay
from benchmarks.scores.recovery import RECOVERY_WINDOW_FRAMES
from benchmarks.suites.registry import Condition
from benchmarks.video.contact_sheet import contact_sheet
from benchmarks.video.instant import Instant

_LENGTHS = range(25, 91)
"""A frame-out to look at lasts so many frames: long enough to lose a car, short enough to see where it went."""
_SCALE = 2.5
_CAPTION = (
    "Seed {seed}: the first frame-out of 25 to 90 frames, just before, in its middle, at its end, and five "
    "frames after the whole car is back. White: what the camera sees; what is around it is shown to you alone. "
    "Blue: the car. Orange: the estimate. Yellow: the particles."
)


def show_frame_out(
    directory: Path, condition: Condition, trackers: Mapping[str, Sequence[Row]], shown: Sequence[str]
) -> None:
    """Keep a picture of one frame-out beside the rows, a line for each of the trackers ``shown``.

    Which one is a rule, not a choice: the first by seed that lasts 25 to 90 frames and can be judged. There
    is none where no frame-out is like that, or where other code than this made the rows: it would show
    something else than was scored.
    """
    name = "-".join(filter(None, condition))
    found = _first_frame_out(trackers[shown[0]])
    key = json.dumps([found, [(tracker, trackers[tracker][0]["versions"]) for tracker in shown]])
    if made_from(directory, name) == key:
        return
    remove_picture(directory, name)
    if found is not None and all(made_by_this_code(tracker, trackers[tracker]) for tracker in shown):
        seed, frame_out = found
        jobs = {tracker: job_of(trackers[tracker][0], seed) for tracker in shown}
        sheet = contact_sheet({tracker: _instants(job, frame_out) for tracker, job in jobs.items()})
        write_picture(directory, name, sheet, condition, "One frame-out", _CAPTION.format(seed=seed), key)


def _instants(job: Job, frame_out: dict[str, Any]) -> list[Instant]:
    exit_frame, length, back = frame_out["exit_frame"], frame_out["length_frames"], frame_out["back_frame"]
    wanted = (exit_frame - 1, exit_frame + length // 2, exit_frame + length - 1, back + RECOVERY_WINDOW_FRAMES)
    with opened(job) as live:
        count = min(wanted[-1] + 1, live.loop.episode.frame_count)
        last = (*wanted[:-1], count - 1)
        return list(replay(live, scale=_SCALE, wanted=last, frame_count=count))


def _first_frame_out(rows: Sequence[Row]) -> tuple[int, dict[str, Any]] | None:
    judged = [row for row in rows if row["metric"] == "recovered" and row["frame_out"]["back_frame"]]
    for row in sorted(judged, key=lambda row: (row["seed"], row["frame_out"]["index"])):
        if row["frame_out"]["length_frames"] in _LENGTHS and row["frame_out"]["exit_frame"] > 0:
            return row["seed"], row["frame_out"]
    return None
