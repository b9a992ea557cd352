"""OTB and VOT: the one target of a scenario, a folder of pictures and boxes for each episode.

OTB: Wu, Lim, Yang 2015, https://doi.org/10.1109/TPAMI.2014.2388226. VOT: https://votchallenge.github.io/toolkit/.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format, sequence_name
from benchmarks.data.exports.labels import ABSENT, OCCLUDED, OUT, StoredFrame, as_xywh
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios import catalog
from sim.checks import check


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


class SingleTarget(Exporter):
    """A folder for each episode, and a list of them.

    Attributes:
        pictures: place of a picture in the folder of its sequence, with one for its number, from 1 on.
    """

    channels = ("image_rgb",)
    pictures: ClassVar[str]

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write a sequence: pictures, boxes, and tags, a line a picture."""
        name, rows = self.name_of(episode), []
        for stored in self.frames(episode):
            rows.append(target_row(self.data, stored))
            self.write_picture(stored, f"{name}/{self.pictures.format(stored.index + 1)}")
        for file, lines in self.texts(episode, rows).items():
            self.write_lines(f"{name}/{file}", lines)

    def texts(self, episode: StoredEpisode, rows: Sequence[TargetRow]) -> dict[str, Iterable[str]]:
        """Return the lines of each text file of a sequence."""
        raise NotImplementedError

    def end(self) -> None:
        """Write the list of sequences."""
        self.write_lines("list.txt", (sequence_name(self.data, seed) for seed in self.data.seeds))


@export_format("otb")
class Otb(SingleTarget):
    """One target, in the layout of OTB.

    Format: OTB (Wu, Lim, Yang 2015, http://cvlab.hanyang.ac.kr/tracker_benchmark/). `list.txt` names the sequences;
    each holds `img/` (pictures from 1), `groundtruth_rect.txt`, and `out_of_view.txt` and `occlusion.txt`, a line a
    picture. The top left corner of the picture is 1, 1. OTB itself has a box in every picture; a line of NaN means, as
    in UAV123, that the target is not seen.

    Boxes are left, top, width, height of the whole target, beyond the border of the picture and hidden parts too,
    wherever at least one of its pixels is seen; elsewhere, and where it reaches behind the camera, there is none (NaN).
    `out_of_view` is 1 where the target is wholly outside the picture, `occlusion` where it is inside and less than half
    of its pixels are seen.
    """

    pictures = "img/{:04d}"

    def texts(self, episode: StoredEpisode, rows: Sequence[TargetRow]) -> dict[str, Iterable[str]]:
        """See ``SingleTarget``."""
        return {
            "groundtruth_rect.txt": [row.box_text(1.0) for row in rows],
            "out_of_view.txt": [f"{row.is_out:d}" for row in rows],
            "occlusion.txt": [f"{row.is_occluded:d}" for row in rows],
        }


@export_format("vot")
class Vot(SingleTarget):
    """One target, as the VOT toolkit reads it, with tags for out of view.

    Format: the VOT toolkit's own, https://votchallenge.github.io/toolkit/. `list.txt` names the sequences; each holds
    `sequence` (properties), `color/` (pictures from 1), `groundtruth.txt` and the tags `out_of_view.tag`,
    `occlusion.tag`, a line a picture. `fps` is a whole number, as the toolkit wants it, `exact_fps` the true one. The
    top left corner of the picture is 0, 0. The toolkit reads NaN as "no target here".

    Boxes are left, top, width, height of the whole target, beyond the border of the picture and hidden parts too,
    wherever at least one of its pixels is seen; elsewhere, and where it reaches behind the camera, there is none (NaN).
    `out_of_view` is 1 where the target is wholly outside the picture, `occlusion` where it is inside and less than half
    of its pixels are seen.
    """

    pictures = "color/{:08d}"

    def texts(self, episode: StoredEpisode, rows: Sequence[TargetRow]) -> dict[str, Iterable[str]]:
        """See ``SingleTarget``."""
        return {
            "groundtruth.txt": [row.box_text(0.0) for row in rows],
            "out_of_view.tag": [f"{row.is_out:d}" for row in rows],
            "occlusion.tag": [f"{row.is_occluded:d}" for row in rows],
            "sequence": [
                f"name={self.name_of(episode)}",
                # The toolkit takes whole numbers only.
                f"fps={max(1, round(episode.rate_hz))}",
                f"exact_fps={episode.rate_hz:g}",
                "format=default",
                "channel.default=color",
                f"channels.color=color/%08d{self.ending}",
                f"width={episode.camera.width_px}",
                f"height={episode.camera.height_px}",
                f"length={len(episode)}",
            ],
        }
