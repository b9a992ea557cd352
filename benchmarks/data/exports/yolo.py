"""YOLO: a text file of boxes for each picture (https://docs.ultralytics.com/datasets/detect/)."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

from benchmarks.data.exports.export_format import ExportFormat
from benchmarks.data.exports.frames import StoredFrame, episodes, frames, sequence_name, write_picture
from benchmarks.data.exports.objects import ATTRIBUTES, ATTRIBUTES_NOTE, Instance, Labels, check_objects
from benchmarks.data.sets.data_set import DataSet
from sim.checks import check

VALIDATION_SHARE = 0.2
SIDECAR = "objects.csv"
NOTE = f"""
Format: https://docs.ultralytics.com/datasets/detect/. `data.yaml` names the classes, those of the scene's own list with
the same numbers in every export of the scene with the same `--classes`, and the folders of pictures; `labels/` has a
text file for each picture, empty where no object is seen. Parked cars and moored boats have lines too; what shows less
than was asked for (`--min-visible`, without what glare covers, `--min-size`) has none.

A line is class, x and y of the centre, width and height of the box around the pixels that are seen, as shares of the
picture's width and height. Whole episodes are for training or validation: of all seeds in order, the last
{VALIDATION_SHARE:.0%}, at least one, are for validation.

`{SIDECAR}` says what the format has no place for, a row for each line of the text files: file, line (from 1), class,
and more of each object.
{ATTRIBUTES_NOTE.strip()}
"""


def parts_of(seeds: tuple[int, ...]) -> dict[int, str]:
    """Return ``train`` or ``val`` for each seed. Raises ValueError for fewer than two."""
    check("data", len(seeds) >= 2, "at least 2 episodes, to train on one and validate on the other", len(seeds))
    last = math.ceil(VALIDATION_SHARE * len(seeds))
    return {seed: "train" if k < len(seeds) - last else "val" for k, seed in enumerate(seeds)}


def _write(data: DataSet, folder: Path, labels: Labels) -> None:
    check_objects(data)
    parts = parts_of(data.seeds)
    for part in ("train", "val"):
        for name in ("images", "labels"):
            (folder / name / part).mkdir(parents=True)
    with (folder / SIDECAR).open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["file", "line", "class", *ATTRIBUTES])
        for episode in episodes(data):
            part = parts[episode.seed]
            for stored in frames(episode):
                name = f"{sequence_name(data, episode.seed)}_{stored.index:06d}"
                write_picture(stored, "image_rgb", folder / "images" / part / name)
                seen = [each for each in labels.instances(stored) if each.is_seen]
                shown = [each for each in seen if labels.takes(each)]
                labels.left_out += len(seen) - len(shown)
                text = "".join(_line(stored, each) for each in shown)
                (folder / "labels" / part / f"{name}.txt").write_text(text, encoding="utf-8")
                for line, each in enumerate(shown, start=1):
                    told = [labels.names[each.class_number], *each.attributes().values()]
                    table.writerow([f"labels/{part}/{name}.txt", line, *told])
    # A string of JSON is one of YAML, whatever it holds.
    names = "".join(f"  {number}: {json.dumps(name)}\n" for number, name in enumerate(labels.names))
    (folder / "data.yaml").write_text(f"train: images/train\nval: images/val\nnames:\n{names}", encoding="utf-8")


def _line(stored: StoredFrame, instance: Instance) -> str:
    corners = instance.visible_xyxy.reshape(2, 2) / (stored.camera.width_px, stored.camera.height_px)
    numbers = [*corners.mean(axis=0), *(corners[1] - corners[0])]
    return " ".join([str(instance.class_number), *(f"{number:.8f}" for number in numbers)]) + "\n"


YOLO = ExportFormat(
    summary="boxes of what is seen, a text file for each picture, split by seeds",
    needs="objects, pictures, at least 2 episodes",
    channels=("image_rgb",),
    packages=(),
    note=NOTE,
    write=_write,
    has_classes=True,
    leaves_out=True,
)
