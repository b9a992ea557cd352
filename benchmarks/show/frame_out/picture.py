"""The report's picture of one frame-out: found in the rows, run again, drawn as a contact sheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Condition
from benchmarks.judges.recovery import RECOVERY_WINDOW_FRAMES
from benchmarks.run.jobs import Job, opened
from benchmarks.show.event_picture import Sheet, keep_event_picture
from benchmarks.show.replay import replay_all
from benchmarks.show.video.contact_sheet import contact_sheet
from benchmarks.show.video.instant import Instant

_LENGTHS = range(25, 91)
"""Lengths of a frame-out to show: long enough to lose a car, short enough to see where it went."""
_SCALE = 2.5
_CAPTION = (
    "the first frame-out of 25 to 90 frames, just before, in its middle, at its end, and five frames after the whole "
    "car is back. White: the camera's picture; its surroundings are not shown to trackers. Blue: the car. Orange: the "
    "estimate. Yellow: the particles."
)


def show_frame_out(
    directory: Path, condition: Condition, trackers: Mapping[str, Sequence[Row]], shown: Sequence[str]
) -> None:
    """Keep a picture of one frame-out in the result folder, a line for each of the trackers ``shown``.

    A rule chooses it: the first by seed that lasts 25 to 90 frames and can be judged.
    """
    keep_event_picture(directory, condition, trackers, shown, _first_frame_out(trackers[shown[0]]), _sheet)


def _sheet(jobs: Sequence[Job], frame_out: dict[str, Any]) -> Sheet:
    instants = {tracker: shown for job in jobs for tracker, shown in _instants(job, frame_out).items()}
    return contact_sheet(instants), "One frame-out", _CAPTION


def _instants(job: Job, frame_out: dict[str, Any]) -> dict[str, list[Instant]]:
    exit_frame, length, back = frame_out["exit_frame"], frame_out["length_frames"], frame_out["back_frame"]
    wanted = (exit_frame - 1, exit_frame + length // 2, exit_frame + length - 1, back + RECOVERY_WINDOW_FRAMES)
    with opened(job) as live:
        count = min(wanted[-1] + 1, live.loop.episode.frame_count)
        last = (*wanted[:-1], count - 1)
        shown = list(replay_all(live, scale=_SCALE, wanted=last, frame_count=count))
    return {tracker: [instants[k] for instants in shown] for k, tracker in enumerate(job.trackers)}


def _first_frame_out(rows: Sequence[Row]) -> tuple[int, dict[str, Any]] | None:
    judged = [row for row in rows if row["metric"] == "recovered" and row["frame_out"]["back_frame"]]
    for row in sorted(judged, key=lambda row: (row["seed"], row["frame_out"]["index"])):
        if row["frame_out"]["length_frames"] in _LENGTHS and row["frame_out"]["exit_frame"] > 0:
            return row["seed"], row["frame_out"]
    return None
