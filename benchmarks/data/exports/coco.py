"""COCO: pictures, and boxes and masks of what is seen of each object (https://cocodataset.org/#format-data)."""

from __future__ import annotations

import importlib
import json
import math
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import Instance, StoredFrame, as_xywh
from benchmarks.data.sets.stored_episode import StoredEpisode

AddItem = Callable[[str, dict[str, Any]], None]
"""Appends an item to a list of a name."""


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
    needs_objects = True
    has_classes = True
    leaves_out = True

    def begin(self) -> None:
        """Begin the JSON file."""
        path = self.folder / "annotations" / "instances.json"
        head = json_head(self) | {"categories": categories(self)}
        self._add = self.stack.enter_context(json_lists(path, ("images", "annotations"), head))
        self._images = self._annotations = 0
        self.reads = ("instance_map",)

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures and their annotations. Numbers begin with 1: pycocotools takes 0 for no match."""
        for stored in self.frames(episode):
            self._images += 1
            name = f"{self.name_of(episode)}/{stored.index:06d}"
            self.write_picture(stored, f"images/{name}")
            height, width = stored.frame.truth.instance_map.shape
            image = {"id": self._images, "file_name": name + self.ending, "width": width, "height": height}
            self._add("images", image)
            for each in self.labels.instances(stored):
                if each.is_seen:
                    self._annotations += 1
                    numbers = {"id": self._annotations, "image_id": self._images}
                    self._add("annotations", numbers | self._annotation(stored, each))

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


@contextmanager
def json_lists(path: Path, names: Sequence[str], head: dict[str, Any]) -> Iterator[AddItem]:
    """Write one JSON object of lists that may not fit into memory; yield what appends an item to any of them.

    After a failure there is no file.

    Args:
        names: of the lists. head: what comes before them.
    """
    path.parent.mkdir(exist_ok=True)
    with ExitStack() as stack:
        parts = {name: stack.enter_context(TemporaryFile("w+", encoding="utf-8", dir=path.parent)) for name in names}
        empty = set(names)

        def add(name: str, item: dict[str, Any]) -> None:
            parts[name].write(("\n" if name in empty else ",\n") + as_text(item))
            empty.discard(name)

        yield add
        with path.open("w", encoding="utf-8") as file:
            file.write("{" + ",\n".join(f"{as_text(name)}:{as_text(value)}" for name, value in head.items()))
            for name, part in parts.items():
                file.write(f",\n{as_text(name)}:[")
                part.seek(0)
                shutil.copyfileobj(part, file)
                file.write("]")
            file.write("}\n")


def as_text(value: Any) -> str:
    """Return a value as JSON on one line; NaN and infinity, which JSON lacks, become null."""
    return json.dumps(_finite(value), allow_nan=False, separators=(",", ":"))


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    return [_finite(each) for each in value] if isinstance(value, list | tuple) else value
