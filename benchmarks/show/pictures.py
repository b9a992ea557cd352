"""Pictures in the result folder, embedded in the report: ``pictures/NAME.jpg`` with its text in ``NAME.json``.

The picture of one event is found in the rows by a rule of its suite, run again and drawn as a sheet; it is kept as long
as the rows do not change.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Condition
from benchmarks.run.episodes import EpisodeSpec
from benchmarks.run.experiment import Progress
from benchmarks.run.jobs import Job, opened
from benchmarks.run.selection import job_of
from benchmarks.show.replay import is_of_present_editions, replay_all
from benchmarks.show.video.drawing import Drawing, picture_sheet
from benchmarks.show.video.surroundings import surrounded_all
from scenarios.scenario import Episode
from trackers.atomic_file import write_atomic

FOLDER_NAME = "pictures"


Reopen = Callable[[Row, int], EpisodeSpec | None]
"""Returns the real episode with this seed, of the recordings that a row names; None if it is gone."""


class ShownEvent(NamedTuple):
    """An event that is shown: its seed, the frames (one beyond the end of the episode is its last), and text."""

    seed: int
    frames: list[int]
    title: str
    caption: str


@dataclass(frozen=True, slots=True)
class EventPicture:
    """How a suite shows one event.

    Attributes:
        find: returns the event to show, from the rows of one tracker; None without one.
        drawing: makes the drawing of one tracker's frames.
        cell_width_px: width of one picture of the sheet.
        scale: size of the larger view over that of the observed frame.
    """

    find: Callable[[Sequence[Row]], ShownEvent | None]
    drawing: Callable[[Episode], Drawing]
    cell_width_px: int
    scale: float = 1.0


def keep_event_picture(
    directory: Path,
    condition: Condition,
    trackers: Mapping[str, Sequence[Row]],
    shown: Sequence[str],
    picture: EventPicture,
    progress: Progress = lambda done, of: None,
    reopen: Reopen | None = None,
) -> None:
    """Write the picture of an event, unless it exists; remove it where it is out of date.

    No picture is written without an event, nor for rows of other editions, whose runs cannot be repeated, nor of a real
    sequence that is gone. Earlier pictures of a real sequence stand around those that are shown.

    Args:
        trackers: rows by tracker. shown: the trackers in the picture, a line for each.
        progress: called with the number of frames that have been run for the picture, and of all.
        reopen: of real sequences, each of which has editions of its own; None for simulated episodes.
    """
    name, event = name_of(condition), picture.find(trackers[shown[0]])
    seed = None if event is None else event.seed
    own = ([row for row in trackers[each] if reopen is None or row["seed"] == seed] for each in shown)
    first = [rows[0] for rows in own if rows]
    key = _key(event, shown, first)
    if _is_kept(directory, name, key):
        return
    remove_picture(directory, name)
    episode = reopen(first[0], event.seed) if reopen is not None and event is not None else None
    if event is None or (reopen is not None and episode is None):
        return
    if all(is_of_present_editions(row, episode) for row in first):
        sheet = _sheet(_jobs(first, event.seed, episode), event, picture, progress)
        which = f"Seed {event.seed}" if episode is None else f"Sequence {episode.sequence}"
        write_picture(directory, name, sheet, condition, event.title, f"{which}: {event.caption}", key)


def _sheet(jobs: Sequence[Job], event: ShownEvent, picture: EventPicture, progress: Progress) -> NDArray[np.uint8]:
    """Run jobs, which have equally many frames; return their pictures of an event (H, W, 3)."""

    def after(index: int, done: int, of: int) -> None:
        progress(index * of + done, len(jobs) * of)

    drawn = (
        drawn_cells(job, picture.drawing, event.frames, picture.scale, partial(after, index))
        for index, job in enumerate(jobs)
    )
    return picture_sheet([row for rows in drawn for row in rows], picture.cell_width_px)


def _key(event: ShownEvent | None, shown: Sequence[str], rows: Sequence[Row]) -> str:
    """Return what identifies the rows that a picture shows."""
    return json.dumps([event, [(tracker, row.get("editions")) for tracker, row in zip(shown, rows, strict=False)]])


def _is_kept(directory: Path, name: str, key: str) -> bool:
    words = directory / FOLDER_NAME / f"{name}.json"
    return words.is_file() and bool(json.loads(words.read_text())["made_from"] == key)


def drawn_cells(
    job: Job,
    drawing: Callable[[Episode], Drawing],
    frames: Sequence[int],
    scale: float,
    progress: Progress = lambda done, of: None,
) -> list[list[tuple[str, NDArray[np.uint8]]]]:
    """Run a job; return a line of pictures with their words for each of its trackers, see ``EventPicture``.

    Args:
        progress: called with the number of frames that have been run, and of all.
    """
    cells: list[dict[int, tuple[str, NDArray[np.uint8]]]] = [{} for _ in job.trackers]
    with opened(job) as live:
        episode = live.loop.episode
        frames = [min(frame, episode.frame_count - 1) for frame in frames]
        drawings, count = [drawing(episode) for _ in job.trackers], max(frames) + 1
        is_real = job.episode.scenario is None
        # What surrounds a real picture is known from all earlier ones.
        view, wanted = (1.0, range(count)) if is_real else (scale, frames)
        run = replay_all(live, scale=view, wanted=wanted, frame_count=count, progress=progress)
        shown = surrounded_all(run, episode.rate_hz, scale, frames) if is_real else run
        for instants in shown:
            for own, tracker, each, instant in zip(cells, job.trackers, drawings, instants, strict=True):
                frame = instant.frame.truth.frame
                own[frame] = f"{tracker}   frame {frame}   {each.describe(instant)}", each.picture(instant)
    return [[own[frame] for frame in frames] for own in cells]


def _jobs(rows: Sequence[Row], seed: int, episode: EpisodeSpec | None = None) -> list[Job]:
    """Return the jobs that repeat the runs of rows: on a set path one, as all trackers see the same pictures;
    ``episode``: see ``job_of``.
    """
    jobs = [job_of(row, seed, episode) for row in rows]
    if any(job.episode.steering is not None for job in jobs):
        return jobs
    modules = tuple(dict.fromkeys(name for job in jobs for name in job.modules))
    trackers = {name: spec for job in jobs for name, spec in job.trackers.items()}
    return [replace(jobs[0], trackers=trackers, modules=modules, limit_s=min(job.limit_s for job in jobs))]


def name_of(condition: Condition) -> str:
    """Return the name of a condition's picture and section; a policy's, which is a file, may hold slashes."""
    return "-".join(filter(None, condition)).replace("/", "_")


def write_picture(
    directory: Path,
    name: str,
    image_rgb: NDArray[np.uint8],
    condition: Condition,
    title: str,
    caption: str,
    made_from: str,
) -> None:
    """Write a picture (H, W, 3) and its text, both atomically.

    ``made_from`` identifies the rows that it shows, to detect changes.
    """
    folder = directory / FOLDER_NAME
    folder.mkdir(parents=True, exist_ok=True)
    _, encoded = cv2.imencode(".jpg", image_rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 86])
    write_atomic(folder / f"{name}.jpg", encoded.tobytes())
    words = {"condition": condition, "title": title, "caption": caption, "made_from": made_from}
    write_atomic(folder / f"{name}.json", json.dumps(words, indent=1) + "\n")


def remove_picture(directory: Path, name: str) -> None:
    """Remove a picture, text first; nothing if there is none."""
    for suffix in (".json", ".jpg"):
        (directory / FOLDER_NAME / f"{name}{suffix}").unlink(missing_ok=True)


def read_pictures(directory: Path) -> list[dict[str, Any]]:
    """Return the pictures of a result directory, in order of their names.

    Each has the ``condition`` of its section as a list, ``title`` and ``caption``, and a data URL as ``source``.
    """
    pictures = []
    for path in sorted((directory / FOLDER_NAME).glob("*.json")):
        data = base64.b64encode(path.with_suffix(".jpg").read_bytes()).decode()
        pictures.append(json.loads(path.read_text()) | {"source": f"data:image/jpeg;base64,{data}"})
    return pictures
