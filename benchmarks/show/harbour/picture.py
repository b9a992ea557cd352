"""The report's picture of one visit: found in the rows, run again, drawn as a sheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Condition
from benchmarks.run.jobs import Job, opened
from benchmarks.show.event_picture import Sheet, keep_event_picture
from benchmarks.show.harbour.drawing import HarbourDrawing
from benchmarks.show.replay import replay_all
from benchmarks.show.video.contact_sheet import picture_sheet

_LONG_FRAMES = 8
"""Least length of a visit to show."""
_AFTER_FRAMES = (3, 30)
"""Frames from its first one to those that are shown, or to its last one."""
_CELL_WIDTH_PX = 900
_CAPTION = (
    "the earliest arrival that can be seen and stays for 8 frames, on its fourth frame and a minute after its first. "
    "Left the thermal picture with 3-D boxes, right all of it from above, the camera below. Blue: intruders. Orange: "
    "tracks on one. Red: tracks on nothing, false alarms from their fourth frame on, with their causes. Grey: tracks "
    "at an intruder that do not count, as they are misplaced, or it is mostly hidden or not watched."
)


def show_visit(
    directory: Path, condition: Condition, trackers: Mapping[str, Sequence[Row]], shown: Sequence[str]
) -> None:
    """Keep a picture of one visit in the result folder, a line for each of the trackers ``shown``.

    A rule chooses it: of the first seed that has one the earliest visit of 8 frames that begins after the first frame
    and can be seen.
    """
    keep_event_picture(directory, condition, trackers, shown, _first_visit(trackers[shown[0]]), _sheet)


def _first_visit(rows: Sequence[Row]) -> tuple[int, dict[str, Any]] | None:
    """Return seed and attributes of the visit to show."""
    visits = [(row["seed"], row["event"]) for row in rows if row["metric"] == "found"]
    long = [each for each in visits if each[1]["first_frame"] > 0 and each[1]["length_frames"] >= _LONG_FRAMES]
    return min(long, key=lambda each: (each[0], each[1]["first_frame"], each[1]["index"]), default=None)


def _sheet(jobs: Sequence[Job], visit: dict[str, Any]) -> Sheet:
    last = visit["first_frame"] + visit["length_frames"] - 1
    wanted = [min(visit["first_frame"] + each, last) for each in _AFTER_FRAMES]
    cells = [row for job in jobs for row in _rows(job, wanted)]
    return picture_sheet(cells, _CELL_WIDTH_PX), f"A {visit['kind']} comes", _CAPTION


def _rows(job: Job, wanted: Sequence[int]) -> list[list[tuple[str, NDArray[np.uint8]]]]:
    """Return the wanted frames of each tracker's run with their words."""
    cells: list[dict[int, tuple[str, NDArray[np.uint8]]]] = [{} for _ in job.trackers]
    with opened(job) as live:
        drawings = [HarbourDrawing(live.loop.episode) for _ in job.trackers]
        # Alarms are raised by frames running: all are drawn, up to the last one that is shown.
        for instants in replay_all(live, scale=1.0, wanted=range(wanted[-1] + 1), frame_count=wanted[-1] + 1):
            for mine, tracker, drawing, instant in zip(cells, job.trackers, drawings, instants, strict=True):
                frame, picture = instant.frame.truth.frame, drawing.picture(instant)
                if frame in wanted:
                    mine[frame] = f"{tracker}   frame {frame}   {drawing.describe(instant)}", picture
    return [[mine[frame] for frame in wanted] for mine in cells]
