"""COCO: pictures, and boxes and masks of what is seen of each object (https://cocodataset.org/#format-data)."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.export_format import ExportFormat
from benchmarks.data.exports.frames import StoredFrame, episodes, frames, picture_ending, sequence_name, write_picture
from benchmarks.data.exports.json_lists import JsonLists
from benchmarks.data.exports.objects import ATTRIBUTES_NOTE, Labels, as_xywh, check_objects
from benchmarks.data.sets.data_set import DataSet

NOTE = f"""
Format: https://cocodataset.org/#format-data. `annotations/instances.json` names the pictures in `images/`.

An annotation is of one object in one picture of which at least one pixel is seen: `segmentation` is the run-length code
of those pixels, `bbox` the box around them (left, top, width, height; the top left corner of the picture is 0, 0),
`area` their number. Parked cars and moored boats have theirs too. Categories are the classes of the scene's own list,
with the same numbers in every export of the scene with the same `--classes`. `iscrowd` is 1 for what shows less than
was asked for (`--min-visible`, without what glare covers, `--min-size`), which evaluation then ignores, else 0.

`attributes` holds more of each object:
{ATTRIBUTES_NOTE.strip()}
"""


def _write(data: DataSet, folder: Path, labels: Labels) -> None:
    check_objects(data)
    head: dict[str, Any] = {
        "info": {"description": f"{data.request.scenario}, preset {data.request.preset}"},
        "licenses": [],
        "categories": [{"id": number, "name": name} for number, name in enumerate(labels.names, start=1)],
    }
    (folder / "annotations").mkdir()
    ending = picture_ending(data)
    image = annotation = 0
    with JsonLists(folder / "annotations" / "instances.json", ("images", "annotations"), head) as lists:
        for episode in episodes(data):
            pictures = folder / "images" / sequence_name(data, episode.seed)
            pictures.mkdir(parents=True)
            for stored in frames(episode, ("instance_map",)):
                image += 1
                name = f"{stored.index:06d}"
                write_picture(stored, "image_rgb", pictures / name)
                height, width = stored.frame.truth.instance_map.shape
                file_name = f"{pictures.name}/{name}.{ending}"
                lists.add("images", {"id": image, "file_name": file_name, "width": width, "height": height})
                for item in _annotations(stored, labels):
                    # Numbers begin with 1: the evaluation of pycocotools takes 0 for "matched with nothing".
                    annotation += 1
                    lists.add("annotations", {"id": annotation, "image_id": image} | item)


def _annotations(stored: StoredFrame, labels: Labels) -> Iterator[dict[str, Any]]:
    for each in labels.instances(stored):
        if each.is_seen:
            is_small = not labels.takes(each)
            labels.left_out += is_small
            mask = stored.frame.truth.instance_map == each.instance_id
            yield {
                "category_id": 1 + each.class_number,
                "bbox": as_xywh(each.visible_xyxy),
                "area": int(mask.sum()),
                "segmentation": run_lengths(mask),
                "iscrowd": int(is_small),
                "attributes": each.attributes(),
            }


def run_lengths(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return COCO's compressed run-length code of a mask (H, W)."""
    code = importlib.import_module("pycocotools.mask").encode(np.asfortranarray(mask, dtype=np.uint8))
    return {"size": [int(length) for length in code["size"]], "counts": code["counts"].decode("ascii")}


COCO = ExportFormat(
    summary="boxes and masks of what is seen of all objects, in one JSON file",
    needs="objects, their instance_map, pictures",
    channels=("image_rgb", "instance_map"),
    packages=("pycocotools",),
    note=NOTE,
    write=_write,
    has_classes=True,
    leaves_out=True,
)
