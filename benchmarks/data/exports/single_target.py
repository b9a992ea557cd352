"""The one target of a scenario, frame by frame, as sequences for single-target trackers give it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.export_format import ExportFormat
from benchmarks.data.exports.frames import ABSENT, OCCLUDED, OUT, StoredFrame, episodes, frames, write_picture
from benchmarks.data.exports.objects import Labels, as_xywh
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios import catalog
from sim.checks import check

TARGET_NOTE = """
Boxes are left, top, width, height of the whole target, beyond the border of the picture and hidden parts too, wherever
at least one of its pixels is seen; elsewhere, and where it reaches behind the camera, there is none (NaN).
`out_of_view` is 1 where the target is wholly outside the picture, `occlusion` where it is inside and less than half of
its pixels are seen.
"""


@dataclass(frozen=True)
class TargetRow:
    """The target in one frame.

    Attributes:
        box_xyxy: (4,) amodal box in pixels; None where no pixel of the target is seen, or it has no amodal box.
        is_out: whether it is wholly outside the picture. is_occluded: whether it is inside and mostly hidden.
    """

    box_xyxy: NDArray[np.float64] | None
    is_out: bool
    is_occluded: bool

    def box_text(self, first: float) -> str:
        """Return left, top, width and height, where the picture's top left corner is at (first, first)."""
        numbers = [float("nan")] * 4 if self.box_xyxy is None else as_xywh(self.box_xyxy, first)
        return ",".join(f"{number:.3f}" for number in numbers)


def target_row(data: DataSet, stored: StoredFrame) -> TargetRow:
    """Return the target of the scenario. Raises ValueError if a sequence would begin without it."""
    name, truth = catalog.scenario(data.request.scenario).target, stored.frame.truth
    row = TargetRow(None, True, False)
    if name in truth.names:
        k = truth.index_of(name)
        has_box = bool(stored.is_seen[k]) and not np.isnan(truth.box_xyxy[k]).any()
        state = str(truth.state[k])
        row = TargetRow(truth.box_xyxy[k] if has_box else None, state in (OUT, ABSENT), state == OCCLUDED)
    where = f"in the first picture of seed {stored.episode.seed}"
    check("data", stored.index > 0 or row.box_xyxy is not None, f"a target {name!r} {where}", "none that is seen there")
    return row


def write_sequence(
    data: DataSet, episode: StoredEpisode, pictures: Path, file_name: str, take: Callable[[TargetRow], None]
) -> StoredFrame:
    """Write the pictures of an episode, counted from 1, and give each frame's target to ``take``; return a frame.

    Args:
        file_name: of a picture, with a place for its number.
    """
    pictures.mkdir(parents=True)
    for stored in frames(episode):
        take(target_row(data, stored))
        write_picture(stored, "image_rgb", pictures / file_name.format(stored.index + 1))
    return stored


def single_target_format(
    summary: str, note: str, write_episode: Callable[[DataSet, StoredEpisode, Path], str]
) -> ExportFormat:
    """Return a format with a folder for each episode.

    Args:
        write_episode: writes the folder of an episode into another; returns its name.
    """

    def write(data: DataSet, folder: Path, _: Labels) -> None:
        names = [write_episode(data, episode, folder) for episode in episodes(data)]
        (folder / "list.txt").write_text("".join(f"{name}\n" for name in names), encoding="utf-8")

    return ExportFormat(
        summary=summary,
        needs="the scenario's target, seen in the first picture of each episode; pictures",
        channels=("image_rgb",),
        packages=(),
        note=f"{note.strip()}\n{TARGET_NOTE}",
        write=write,
    )
