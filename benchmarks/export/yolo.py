"""YOLO: a text file of boxes for each picture (https://docs.ultralytics.com/datasets/detect/)."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np

from benchmarks.data_sets.data_set import DataSet
from benchmarks.export.export_format import ExportFormat
from benchmarks.export.frames import StoredFrame, episodes, frames, write_picture
from benchmarks.export.objects import kinds_of
from sim.checks import check

VALIDATION_SHARE = 0.2
NOTE = f"""
Format: https://docs.ultralytics.com/datasets/detect/. `data.yaml` names the classes, the kinds of the scene's objects,
and the folders of pictures; `labels/` has a text file for each picture, empty where no object is seen.

A line is class, x and y of the centre, width and height of the box around the pixels that are seen, as shares of the
picture's width and height. Whole episodes are for training or validation: of all seeds in order, the last
{VALIDATION_SHARE:.0%}, at least one, are for validation.
"""


def split_of(seeds: tuple[int, ...]) -> dict[int, str]:
    """Return ``train`` or ``val`` for each seed. Raises ValueError for fewer than two."""
    check("data", len(seeds) >= 2, "at least 2 episodes, to train on one and validate on the other", len(seeds))
    last = math.ceil(VALIDATION_SHARE * len(seeds))
    return {seed: "train" if k < len(seeds) - last else "val" for k, seed in enumerate(seeds)}


def _write(data: DataSet, folder: Path) -> None:
    split = split_of(data.seeds)
    classes = {kind: number for number, kind in enumerate(kinds_of(data))}
    for part in ("train", "val"):
        for name in ("images", "labels"):
            (folder / name / part).mkdir(parents=True)
    for episode in episodes(data):
        part = split[episode.seed]
        for stored in frames(episode):
            name = f"{episode.seed:06d}_{stored.index:06d}"
            write_picture(stored, "image_rgb", folder / "images" / part / name)
            (folder / "labels" / part / f"{name}.txt").write_text(_lines(stored, classes), encoding="utf-8")
    # A string of JSON is one of YAML, whatever it holds.
    names = "".join(f"  {number}: {json.dumps(kind)}\n" for kind, number in classes.items())
    (folder / "data.yaml").write_text(f"train: images/train\nval: images/val\nnames:\n{names}", encoding="utf-8")


def _lines(stored: StoredFrame, classes: dict[str, int]) -> str:
    size_px = np.array([stored.camera.width_px, stored.camera.height_px])
    lines = []
    for k in np.flatnonzero(stored.is_seen):
        corners = stored.visible_xyxy[k].reshape(2, 2) / size_px
        numbers = [*corners.mean(axis=0), *(corners[1] - corners[0])]
        lines.append(" ".join([str(classes[stored.frame.truth.kinds[k]]), *(f"{number:.8f}" for number in numbers)]))
    return "".join(f"{line}\n" for line in lines)


YOLO = ExportFormat(
    summary="boxes of what is seen, a text file for each picture, split by seeds",
    needs="objects, pictures, at least 2 episodes",
    channels=("image_rgb",),
    packages=(),
    note=NOTE,
    write=_write,
)
