"""COCO: pictures, and boxes and masks of what is seen of each object (https://cocodataset.org/#format-data)."""

from __future__ import annotations

import importlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import Instance, StoredFrame, as_xywh
from benchmarks.data.sets.stored_episode import StoredEpisode


@export_format("coco")
class Coco(Exporter):
    """Boxes and masks of what is seen of all objects, in one JSON file.

    Format: https://cocodataset.org/#format-data. `annotations/instances.json` names the pictures in `images/`.

    An annotation is of one object in one picture of which at least one pixel is seen: `segmentation` is the run-length
    code of those pixels, `bbox` the box around them (left, top, width, height; the top left corner of the picture is 0,
    0), `area` their number. Parked cars and moored boats have theirs too. Categories are the classes of the scene's own
    list, with the same numbers in every export of the scene with the same `--classes`. `iscrowd` is 1 for what shows
    less than was asked for (`--min-visible`, without what glare covers, `--min-size`), which evaluation then ignores,
    else 0.

    `attributes` holds more of each object:
    """

    channels = ("image_rgb", "instance_map")
    packages = ("pycocotools",)
    has_attributes = True
    has_classes = True
    leaves_out = True

    def begin(self) -> None:
        """Begin the lists of the JSON file."""
        self.reads = ("instance_map",)
        self._lists: dict[str, list[str]] = {"images": [], "annotations": []}

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures and note their annotations. Numbers begin with 1: pycocotools takes 0 for no match."""
        images, annotations = self._lists.values()
        for stored in self.frames(episode):
            name = f"{self.name_of(episode)}/{stored.index:06d}"
            self.write_picture(stored, f"images/{name}")
            height, width = stored.frame.truth.instance_map.shape
            image_id = len(images) + 1
            image = {"id": image_id, "file_name": name + self.ending, "width": width, "height": height}
            images.append(as_text(image))
            for each in self.labels.instances(stored):
                if each.is_seen:
                    numbers = {"id": len(annotations) + 1, "image_id": image_id}
                    annotations.append(as_text(numbers | self._annotation(stored, each)))

    def end(self) -> None:
        """Write the JSON file."""
        head = json_head(self) | {"categories": categories(self)}
        write_json(self.place("annotations/instances.json"), head, self._lists)

    def _annotation(self, stored: StoredFrame, instance: Instance) -> dict[str, Any]:
        is_small = not self.labels.takes(instance)
        self.labels.left_out += is_small
        mask = stored.frame.truth.instance_map == instance.instance_id
        return {
            "category_id": 1 + instance.class_number,
            "bbox": as_xywh(instance.visible_xyxy),
            "area": int(mask.sum()),
            "segmentation": run_lengths(mask),
            "iscrowd": int(is_small),
            "attributes": instance.attributes(),
        }


def json_head(exporter: Exporter) -> dict[str, Any]:
    """Return what COCO's files begin with."""
    request = exporter.data.request
    return {"info": {"description": f"{request.scenario}, preset {request.preset}"}, "licenses": []}


def categories(exporter: Exporter, **fields: str) -> list[dict[str, Any]]:
    """Return a category for each class, with further ``fields``."""
    return [{"id": number, "name": name} | fields for number, name in enumerate(exporter.labels.names, start=1)]


def run_lengths(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return COCO's compressed run-length code of a mask (H, W)."""
    code = importlib.import_module("pycocotools.mask").encode(np.asfortranarray(mask, dtype=np.uint8))
    return {"size": [int(length) for length in code["size"]], "counts": code["counts"].decode("ascii")}


def write_json(path: Path, head: Mapping[str, Any], lists: Mapping[str, Sequence[str]]) -> None:
    """Write one JSON object: ``head``, then lists of items that are JSON already, a line each.

    Readers of the formats hold all of it in memory, and so does what writes it.
    """
    parts = [f"{as_text(name)}:{as_text(value)}" for name, value in head.items()]
    parts += [f"{as_text(name)}:[" + "\n" * bool(items) + ",\n".join(items) + "]" for name, items in lists.items()]
    path.write_text("{" + ",\n".join(parts) + "}\n", encoding="utf-8")


def as_text(value: Any) -> str:
    """Return a value as JSON on one line."""
    return json.dumps(value, allow_nan=False, separators=(",", ":"))
