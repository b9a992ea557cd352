"""YOLO: a text file of boxes for each picture (https://docs.ultralytics.com/datasets/detect/)."""

from __future__ import annotations

import json
import math
from typing import Any

import pandas as pd

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import ATTRIBUTES, Instance, StoredFrame
from benchmarks.data.sets.stored_episode import StoredEpisode
from sim.checks import check

VALIDATION_SHARE = 0.2
SIDECAR = "objects.csv"


def parts_of(seeds: tuple[int, ...]) -> dict[int, str]:
    """Return ``train`` or ``val`` for each seed. Raises ValueError for fewer than two."""
    check("data", len(seeds) >= 2, "at least 2 episodes, to train on one and validate on the other", len(seeds))
    last = math.ceil(VALIDATION_SHARE * len(seeds))
    return {seed: "train" if k < len(seeds) - last else "val" for k, seed in enumerate(seeds)}


@export_format("yolo")
class Yolo(Exporter):
    """Boxes of what is seen, a text file for each picture, split by seeds.

    Format: https://docs.ultralytics.com/datasets/detect/. `data.yaml` names the classes, those of the scene's own list
    with the same numbers in every export of the scene with the same `--classes`, and the folders of pictures; `labels/`
    has a text file for each picture, empty where no object is seen. Parked cars and moored boats have lines too; what
    shows less than was asked for (`--min-visible`, without what glare covers, `--min-size`) has none.

    A line is class, x and y of the centre, width and height of the box around the pixels that are seen, as shares of
    the picture's width and height. Whole episodes are for training or validation: of all seeds in order, the last 20 %,
    at least one, are for validation.

    `objects.csv` says what the format has no place for, a row for each line of the text files: file, line (from 1),
    class, and more of each object.
    """

    channels = ("image_rgb",)
    has_attributes = True
    has_classes = True
    leaves_out = True

    def begin(self) -> None:
        """Split the seeds, and write the names of classes."""
        self._parts = parts_of(self.data.seeds)
        self._rows: list[dict[str, Any]] = []
        # A string of JSON is one of YAML, whatever it holds.
        names = (f"  {number}: {json.dumps(name)}" for number, name in enumerate(self.labels.names))
        self.write_lines("data.yaml", ["train: images/train", "val: images/val", "names:", *names])

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures and their labels, and note the rows of the sidecar."""
        part = self._parts[episode.seed]
        for stored in self.frames(episode):
            name = f"{part}/{self.name_of(episode)}_{stored.index:06d}"
            self.write_picture(stored, f"images/{name}")
            seen = [each for each in self.labels.instances(stored) if each.is_seen]
            shown = [each for each in seen if self.labels.takes(each)]
            self.labels.left_out += len(seen) - len(shown)
            self.write_lines(f"labels/{name}.txt", (_line(stored, each) for each in shown))
            for line, each in enumerate(shown, start=1):
                row = {"file": f"labels/{name}.txt", "line": line, "class": self.labels.names[each.class_number]}
                self._rows.append(row | each.attributes())

    def end(self) -> None:
        """Write the sidecar."""
        table = pd.DataFrame(self._rows, columns=["file", "line", "class", *ATTRIBUTES])
        table.to_csv(self.folder / SIDECAR, index=False, lineterminator="\n")


def _line(stored: StoredFrame, instance: Instance) -> str:
    corners = instance.visible_xyxy.reshape(2, 2) / (stored.camera.width_px, stored.camera.height_px)
    numbers = [*corners.mean(axis=0), *(corners[1] - corners[0])]
    return " ".join([str(instance.class_number), *(repr(float(number)) for number in numbers)])
