"""OTB and VOT: the one target of a scenario, a folder of pictures and boxes for each episode.

OTB: Wu, Lim, Yang 2015, https://doi.org/10.1109/TPAMI.2014.2388226. VOT: https://votchallenge.github.io/toolkit/.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from benchmarks.data.exports.exporter import Exporter, export_format, sequence_name
from benchmarks.data.exports.labels import ABSENT, OCCLUDED, OUT, as_text, as_xywh
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios import catalog
from sim.checks import check


class SingleTarget(Exporter):
    """A folder for each episode, and a list of them.

    Attributes:
        pictures: place of a picture in the folder of its sequence, with one for its number, from 1 on.
        boxes: file of boxes. tags: file of tags, with one for what they tell.
        first: coordinate of the picture's top left corner.
    """

    channels = ("image_rgb",)
    pictures: ClassVar[str]
    boxes: ClassVar[str]
    tags: ClassVar[str]
    first: ClassVar[float]

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write a sequence: pictures, boxes, and tags, a line a picture. Raises ValueError if the first has no box."""
        name, target = self.name_of(episode), catalog.scenario(self.data.request.scenario).target
        boxes, out_of_view, occlusion = list[str](), list[str](), list[str]()
        for stored in self.frames(episode):
            found = next((each for each in self.labels.instances(stored) if each.name == target), None)
            box_xyxy = found.box_xyxy if found is not None and found.is_seen else np.full(4, np.nan)
            state = ABSENT if found is None else found.state
            wanted = f"a target {target!r} in the first picture of seed {episode.seed}"
            check("data", stored.index > 0 or bool(np.isfinite(box_xyxy).all()), wanted, "none that is seen there")
            boxes.append(as_text(as_xywh(box_xyxy, self.first)))
            outside = state in (OUT, ABSENT)
            out_of_view.append(f"{outside:d}")
            occlusion.append(f"{state == OCCLUDED or not (outside or (found is not None and found.is_seen)):d}")
            self.write_picture(stored, f"{name}/{self.pictures.format(stored.index + 1)}")
        tags = {self.tags.format("out_of_view"): out_of_view, self.tags.format("occlusion"): occlusion}
        for file, lines in ({self.boxes: boxes} | tags | self.more(episode)).items():
            self.write_lines(f"{name}/{file}", lines)

    def more(self, episode: StoredEpisode) -> dict[str, list[str]]:
        """Return the lines of further text files of a sequence."""
        return {}

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
    of its pixels are seen, or the border cuts it and none is.
    """

    pictures, boxes, tags, first = "img/{:04d}", "groundtruth_rect.txt", "{}.txt", 1.0


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
    of its pixels are seen, or the border cuts it and none is.
    """

    pictures, boxes, tags, first = "color/{:08d}", "groundtruth.txt", "{}.tag", 0.0

    def more(self, episode: StoredEpisode) -> dict[str, list[str]]:
        """See ``SingleTarget``."""
        properties = [
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
            # For readers of ours, see ``benchmarks.data.layouts.vot``.
            "boxes=whole",
        ]
        return {"sequence": properties}
