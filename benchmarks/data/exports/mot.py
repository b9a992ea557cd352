"""MOT Challenge: boxes with identities (https://motchallenge.net; Milan et al. 2016, https://arxiv.org/abs/1603.00831).

TrackEval reads it: https://github.com/JonathonLuiten/TrackEval/tree/master/docs/MOTChallenge-Official.
"""

from __future__ import annotations

import numpy as np

from benchmarks.data.exports.exporter import Exporter, export_format, sequence_name
from benchmarks.data.exports.labels import ABSENT, OUT, as_text, as_xywh
from benchmarks.data.sets.stored_episode import StoredEpisode

ROOT, SPLIT = "gt/mot_challenge", "frameout-train"
"""Folder, and the name of the benchmark and the split, as TrackEval joins them."""
DISTRACTOR = 8
"""Class of MOT Challenge for what is neither an object nor a mistake."""


@export_format("mot")
class Mot(Exporter):
    """Boxes with identities and visibilities, a text file for each episode.

    Format: MOT Challenge, https://motchallenge.net (Milan et al. 2016, arXiv 1603.00831), as TrackEval reads it.
    `gt/mot_challenge/frameout-train/` holds a folder for each episode, `gt/mot_challenge/seqmaps/frameout-train.txt`
    their names: `run_mot_challenge.py --GT_FOLDER gt/mot_challenge --BENCHMARK frameout --DO_PREPROC False`.

    A row of `gt/gt.txt` is frame, identity, left, top, width, height, 1 (counts), class, visibility. Frames, identities
    and pixels are counted from 1: the top left corner of the picture is 1, 1. Boxes are around whole objects, beyond
    the border of the picture and hidden parts too; an object that is outside the picture or reaches behind the camera
    has no row, and one that only stands about, a parked car or a moored boat, has rows where at least one pixel of it
    is seen. Visibility is the seen share of the object's own pixels. The class is 1, the one that MOT Challenge
    scores; `frameRate` is a whole number, as readers want it, `exactFrameRate` the true one (0.5 for a picture every
    two seconds). `gt/objects.txt` gives identity, name, kind, class and role (`traffic`, `parked`, …) of each object.

    What is to be ignored (`--min-visible`, without what glare covers, `--min-size`, `--ignore-standing`) is a
    distractor: 0 (does not count), class 8. With `--DO_PREPROC True` TrackEval removes answers that match one.
    """

    channels = ("image_rgb",)
    has_classes = True
    leaves_out = True

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures, rows, objects and ``seqinfo.ini``."""
        name = self.name_of(episode)
        folder = f"{ROOT}/{SPLIT}/{name}"
        rows, identities, objects = list[str](), dict[str, int](), list[str]()
        for stored in self.frames(episode):
            self.write_picture(stored, f"{folder}/img1/{stored.index + 1:06d}")
            for each in self.labels.instances(stored):
                if each.state not in (OUT, ABSENT) and np.isfinite(each.box_xyxy).all():
                    if each.name not in identities:
                        identities[each.name] = len(identities) + 1
                        words = (each.name, each.kind, self.labels.class_of(each.kind), each.role)
                        objects.append(f"{identities[each.name]},{','.join(words)}")
                    box, seen = as_text(as_xywh(each.box_xyxy, first=1.0)), as_text([each.visible_fraction])
                    taken = self.labels.takes(each)
                    self.labels.left_out += not taken
                    counts = "1,1" if taken else f"0,{DISTRACTOR}"
                    rows.append(f"{stored.index + 1},{identities[each.name]},{box},{counts},{seen}")
        self.write_lines(f"{folder}/gt/gt.txt", rows)
        self.write_lines(f"{folder}/gt/objects.txt", objects)
        entries = {
            "name": name,
            "imDir": "img1",
            # Readers take whole numbers only.
            "frameRate": max(1, round(episode.rate_hz)),
            "exactFrameRate": f"{episode.rate_hz:g}",
            "seqLength": len(episode),
            "imWidth": episode.camera.width_px,
            "imHeight": episode.camera.height_px,
            "imExt": self.ending,
        }
        lines = (f"{name}={value}" for name, value in entries.items())
        self.write_lines(f"{folder}/seqinfo.ini", ["[Sequence]", *lines])

    def end(self) -> None:
        """Write the names of all sequences."""
        names = (sequence_name(self.data, seed) for seed in self.data.seeds)
        self.write_lines(f"{ROOT}/seqmaps/{SPLIT}.txt", ["name", *names])
