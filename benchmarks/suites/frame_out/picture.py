"""The report's look at one frame-out: found in the rows, lived through again, drawn as a contact sheet."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from benchmarks.report.pictures import made_from, remove_picture, write_picture
from benchmarks.run.records import Row
from benchmarks.run.replay import Run, made_by_this_code
from benchmarks.scores.recovery import RECOVERY_WINDOW_FRAMES
from benchmarks.suites.registry import Condition
from benchmarks.video.contact_sheet import contact_sheet
from benchmarks.video.instant import Instant
from scenarios.scenario import RendererName

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
        sheet = contact_sheet(_instants(condition, seed, frame_out, shown))
        write_picture(directory, name, sheet, condition, "One frame-out", _CAPTION.format(seed=seed), key)


def _instants(
    condition: Condition, seed: int, frame_out: dict[str, Any], shown: Sequence[str]
) -> dict[str, list[Instant]]:
    exit_frame, length, back = frame_out["exit_frame"], frame_out["length_frames"], frame_out["back_frame"]
    wanted = (exit_frame - 1, exit_frame + length // 2, exit_frame + length - 1, back + RECOVERY_WINDOW_FRAMES)
    _, scenario, preset, renderer, controller = condition
    sheet = {}
    for tracker in shown:
        run = Run(scenario, preset, seed, cast(RendererName, renderer), tracker, controller or None)
        episode = run.open()
        try:
            count = min(wanted[-1] + 1, episode.frame_count)
            last = (*wanted[:-1], count - 1)
            sheet[tracker] = list(run.instants(episode, scale=_SCALE, wanted=last, frame_count=count))
        finally:
            episode.close()
    return sheet


def _first_frame_out(rows: Sequence[Row]) -> tuple[int, dict[str, Any]] | None:
    judged = [row for row in rows if row["metric"] == "recovered" and row["frame_out"]["back_frame"]]
    for row in sorted(judged, key=lambda row: (row["seed"], row["frame_out"]["index"])):
        if row["frame_out"]["length_frames"] in _LENGTHS and row["frame_out"]["exit_frame"] > 0:
            return row["seed"], row["frame_out"]
    return None
