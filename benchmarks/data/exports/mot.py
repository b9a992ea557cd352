"""MOT Challenge: boxes with identities (https://motchallenge.net; Milan et al. 2016, https://arxiv.org/abs/1603.00831).

TrackEval reads it: https://github.com/JonathonLuiten/TrackEval/tree/master/docs/MOTChallenge-Official.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.data.exports.export_format import ExportFormat
from benchmarks.data.exports.frames import (
    ABSENT,
    OUT,
    StoredFrame,
    episodes,
    frames,
    picture_ending,
    sequence_name,
    write_picture,
)
from benchmarks.data.exports.objects import Identities, Instance, Labels, as_xywh, check_objects
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode

SPLIT = "frameout-train"
"""Name of the benchmark and the split, as TrackEval joins them."""
NOTE = """
Format: MOT Challenge, https://motchallenge.net (Milan et al. 2016, arXiv 1603.00831), as TrackEval reads it.
`gt/mot_challenge/frameout-train/` holds a folder for each episode, `gt/mot_challenge/seqmaps/frameout-train.txt` their
names: `run_mot_challenge.py --GT_FOLDER gt/mot_challenge --BENCHMARK frameout --DO_PREPROC False`.

A row of `gt/gt.txt` is frame, identity, left, top, width, height, 1 (counts), class, visibility. Frames, identities and
pixels are counted from 1: the top left corner of the picture is 1, 1. Boxes are around whole objects, beyond the border
of the picture and hidden parts too; an object that is outside the picture or reaches behind the camera has no row, and
one that only stands about, a parked car or a moored boat, has rows where at least one pixel of it is seen.
Visibility is the seen share of the object's own pixels. The class is always 1, the one that MOT Challenge scores;
`frameRate` is a whole number, as readers want it, `exactFrameRate` the true one (0.5 for a picture every two seconds).
`gt/objects.txt` gives identity, name, kind, class and role (`traffic`, `parked`, …) of each object.
"""


def _write(data: DataSet, folder: Path, labels: Labels) -> None:
    check_objects(data)
    root = folder / "gt" / "mot_challenge"
    names = []
    for episode in episodes(data):
        names.append(sequence_name(data, episode.seed))
        _write_sequence(data, episode, root / SPLIT / names[-1], labels)
    (root / "seqmaps").mkdir()
    (root / "seqmaps" / f"{SPLIT}.txt").write_text("\n".join(["name", *names]) + "\n", encoding="utf-8")


def _write_sequence(data: DataSet, episode: StoredEpisode, folder: Path, labels: Labels) -> None:
    (folder / "img1").mkdir(parents=True)
    (folder / "gt").mkdir()
    identities, told = Identities(), dict[int, str]()
    with (folder / "gt" / "gt.txt").open("w", encoding="utf-8") as file:
        for stored in frames(episode):
            write_picture(stored, "image_rgb", folder / "img1" / f"{stored.index + 1:06d}")
            for each in labels.instances(stored):
                if each.state not in (OUT, ABSENT) and np.isfinite(each.box_xyxy).all():
                    identity = identities.of(each.name)
                    file.write(_row(stored, each, identity))
                    told[identity] = f"{each.name},{each.kind},{labels.class_of(each.kind)},{each.role}"
            camera = stored.camera
    objects = "".join(f"{identity},{words}\n" for identity, words in told.items())
    (folder / "gt" / "objects.txt").write_text(objects, encoding="utf-8")
    entries = {
        "name": folder.name,
        "imDir": "img1",
        # Readers take whole numbers only.
        "frameRate": max(1, round(episode.rate_hz)),
        "exactFrameRate": f"{episode.rate_hz:g}",
        "seqLength": len(episode),
        "imWidth": camera.width_px,
        "imHeight": camera.height_px,
        "imExt": f".{picture_ending(data)}",
    }
    lines = ["[Sequence]", *(f"{name}={value}" for name, value in entries.items())]
    (folder / "seqinfo.ini").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _row(stored: StoredFrame, instance: Instance, identity: int) -> str:
    box = ",".join(f"{number:.3f}" for number in as_xywh(instance.box_xyxy, first=1.0))
    return f"{stored.index + 1},{identity},{box},1,1,{instance.visible_fraction:.5f}\n"


MOT = ExportFormat(
    summary="boxes with identities and visibilities, a text file for each episode",
    needs="objects, pictures",
    channels=("image_rgb",),
    packages=(),
    note=NOTE,
    write=_write,
    has_classes=True,
)
