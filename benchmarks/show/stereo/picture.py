"""The report's picture of one occlusion or change of light: found in the rows, run again, drawn as a sheet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Condition
from benchmarks.judges.stereo.metrics.people_events import OCCLUSION
from benchmarks.run.jobs import Job, opened
from benchmarks.show.event_picture import Sheet, keep_event_picture
from benchmarks.show.replay import replay_all
from benchmarks.show.stereo.drawing import describe_person
from benchmarks.show.stereo.instant import draw_left_and_plan
from benchmarks.show.video.contact_sheet import picture_sheet
from benchmarks.show.video.instant import Instant
from scenarios.stereo_follow.floor_plan import RoomPlan

_LONG_FRAMES = 3
"""Least length of an occlusion to show."""
_AFTERWARDS_FRAMES = 10
_CELL_WIDTH_PX = 640
_CAPTION = (
    "{words} Left the camera's picture, right all people from above. Blue: the target. Orange: the estimate; none "
    "without an answer. Grey: the others."
)
_OCCLUSION_WORDS = "the first occlusion of 3 frames or more; before it, in its middle, seen again, ten frames later."
_LIGHT_WORDS = "the first change of light ({kind}); before it, and in the two seconds after it."


def show_event(
    directory: Path, condition: Condition, trackers: Mapping[str, Sequence[Row]], shown: Sequence[str]
) -> None:
    """Keep a picture of one event in the result folder, a line for each of the trackers ``shown``.

    A rule chooses it: the first occlusion by seed that lasts 3 frames and can be judged, without one the first change
    of light.
    """
    keep_event_picture(directory, condition, trackers, shown, _first_event(trackers[shown[0]]), _sheet)


def _sheet(jobs: Sequence[Job], event: dict[str, Any]) -> Sheet:
    title, words = "One occlusion", _OCCLUSION_WORDS
    if event["kind"] != OCCLUSION:
        title, words = "One change of light", _LIGHT_WORDS.format(kind=event["kind"])
    cells = [row for job in jobs for row in _rows(job, _wanted(event))]
    return picture_sheet(cells, _CELL_WIDTH_PX), title, _CAPTION.format(words=words)


def _first_event(rows: Sequence[Row]) -> tuple[int, dict[str, Any]] | None:
    """Return seed and attributes of the event to show."""
    events = [(row["seed"], event, row["metric"]) for row in rows if (event := row["event"]) is not None]
    hidden = [
        (seed, event)
        for seed, event, metric in events
        if metric == "recovered" and event["length_frames"] >= _LONG_FRAMES and event["back_frame"] is not None
    ]
    lights = [(seed, event) for seed, event, _ in events if event["light"]]
    return min(hidden or lights, key=lambda pair: (pair[0], pair[1]["index"]), default=None)


def _wanted(event: Mapping[str, Any]) -> list[int]:
    """Return the four frames of an event that are shown."""
    first, last = event["first_frame"], event["first_frame"] + event["length_frames"] - 1
    if event["kind"] == OCCLUSION:
        return [first - 1, (first + last) // 2, event["back_frame"], event["back_frame"] + _AFTERWARDS_FRAMES]
    return [first - 1, *np.linspace(first, last, 4).round().astype(int).tolist()[1:]]


def _rows(job: Job, wanted: Sequence[int]) -> list[list[tuple[str, NDArray[np.uint8]]]]:
    """Return the wanted frames of each tracker's run with their words; the last one for frames beyond the end."""
    with opened(job) as live:
        episode = live.loop.episode
        frames = [min(frame, episode.frame_count - 1) for frame in wanted]
        plan = episode.map_of().plan
        cells = {
            instants[0].frame.truth.frame: [_cell(*each, plan) for each in zip(job.trackers, instants, strict=True)]
            for instants in replay_all(live, scale=1.0, wanted=frames, frame_count=frames[-1] + 1)
        }
    return [[cells[frame][k] for frame in frames] for k in range(len(job.trackers))]


def _cell(tracker: str, instant: Instant, plan: RoomPlan) -> tuple[str, NDArray[np.uint8]]:
    words = f"{tracker}   frame {instant.frame.truth.frame}   {describe_person(instant)}"
    return words, draw_left_and_plan(instant, plan)
