"""COCO, and TAO-Amodal, which extends it: JSON files of boxes in pictures.

COCO has boxes and masks of what is seen of each object: https://cocodataset.org/#format-data. TAO-Amodal has tracks
with modal and amodal boxes: Hsieh et al. 2023, https://arxiv.org/abs/2312.12433. Its fields:
https://huggingface.co/datasets/chengyenhsieh/TAO-Amodal, and those of TAO that it extends.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from benchmarks.data.codec import runs_of
from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import ABSENT, Instance, StoredFrame, as_xywh
from benchmarks.data.sets.stored_episode import StoredEpisode

SPLIT = "validation"
"""The split that trackers are scored on."""


@export_format("coco")
class Coco(Exporter):
    """Boxes and masks of what is seen of all objects, in one JSON file, or in one for each split.

    Format: https://cocodataset.org/#format-data. `annotations/instances.json` names the pictures in `images/`; of a set
    with shares `instances_train.json`, `instances_val.json` and `instances_test.json` do, each with numbers of its own.

    An annotation is of one object in one picture of which at least one pixel is seen: `segmentation` is the run-length
    code of those pixels, `bbox` the box around them (left, top, width, height; the top left corner of the picture is 0,
    0), `area` their number. Parked cars and moored boats have theirs too. Categories are the classes of the scene's own
    list, with the same numbers in every export of the scene with the same `--classes`. `iscrowd` is 1 for what is to be
    ignored (`--min-visible`, without what glare covers, `--min-size`, `--ignore-standing`), else 0.

    `attributes` holds more of each object:
    """

    channels: ClassVar[tuple[str, ...]] = ("image_rgb", "instance_map")
    packages = ("pycocotools",)
    has_attributes = True
    has_classes = True
    leaves_out = True
    of_stills = True
    file_name: ClassVar[str] = "instances"

    def begin(self) -> None:
        """Begin the lists of the JSON files, by the endings of their names."""
        self._lists: dict[str, dict[str, list[str]]] = {}

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures and note their annotations. Numbers begin with 1: pycocotools takes 0 for no match."""
        request = self.data.request
        ending = f"_{request.split_of(episode.seed)}" if request.splits else ""
        images, annotations = self._lists.setdefault(ending, {"images": [], "annotations": []}).values()
        for stored in self.frames(episode):
            name = f"{self.name_of(episode)}/{stored.index:06d}"
            self.write_picture(stored, f"images/{name}")
            height, width = stored.frame.truth.instance_map.shape
            image_id = len(images) + 1
            image = {"id": image_id, "file_name": name + self.ending, "width": width, "height": height}
            images.append(as_text(image))
            for each, taken in self.labels.seen(stored):
                annotation = self.annotation(stored, each, taken)
                if annotation is not None:
                    annotations.append(as_text({"id": len(annotations) + 1, "image_id": image_id} | annotation))

    def end(self) -> None:
        """Write the JSON files."""
        for ending, lists in self._lists.items():
            write_json(self.place(f"annotations/{self.file_name}{ending}.json"), self.head(), lists)

    def head(self) -> dict[str, Any]:
        """Return what the files begin with."""
        return head_of(self)

    def annotation(self, stored: StoredFrame, instance: Instance, taken: bool) -> dict[str, Any] | None:
        """Return what is told of an object in a picture, without numbers; None for one that has no annotation.

        Args:
            taken: see ``Labels.seen``.
        """
        mask = stored.frame.truth.instance_map == instance.instance_id
        return {
            "category_id": 1 + instance.class_number,
            "bbox": as_xywh(instance.visible_xyxy),
            "area": int(mask.sum()),
            "segmentation": runs_of(mask),
            "iscrowd": int(not taken),
            "attributes": instance.attributes(),
        }


@export_format("tao-amodal")
class TaoAmodal(Exporter):
    """Tracks with boxes of what is seen and of the whole objects, hidden and outside the picture too.

    Format: TAO-Amodal, https://huggingface.co/datasets/chengyenhsieh/TAO-Amodal (Hsieh et al. 2023, arXiv 2312.12433).
    `amodal_annotations/validation.json` names the pictures in `frames/`. All episodes are in this one split.
    `amodal_annotations/validation_lvis_v1.json` is what the format's own `tools/eval_on_tao_amodal.py` takes as
    `--annotation`: the same annotations, where `bbox` and `area` are of the amodal box, for these are scored.

    Boxes are left, top, width, height; the top left corner of the picture is 0, 0. Every object that the scene asks
    about has an annotation in every picture, hidden or outside the picture too, unless it is wholly behind the camera;
    what only stands about, a parked car or a moored boat, has one where at least one pixel of it is seen.

    - `bbox`: around the pixels that are seen; 0, 0, 0, 0 where none is. `area`: of that box.
    - `amodal_bbox`: around the whole object, beyond the border of the picture too.
    - `amodal_is_uncertain`: true where the object reaches behind the camera and has no amodal box; `bbox` stands for
      it.
    - `visibility`: seen share of the object's own pixels, 0 to 1, counted and not the overlap of the two boxes.
    - `out_of_frame`: whether the amodal box reaches beyond the border of the picture.

    Truth of what is seen is complete: `neg_category_ids` of a video are all categories that it does not show, and
    `not_exhaustive_category_ids` is empty; in the second file pictures have both as well. Categories are the classes of
    the scene's own list, with the same numbers in every export of the scene with the same `--classes`, the synset
    `unknown` and, in the second file, the frequency `f`. Annotations have `attributes` besides:
    """

    channels = ("image_rgb",)
    has_attributes = True
    has_classes = True

    def begin(self) -> None:
        """Begin the lists of both JSON files, which share videos and tracks; all are counted from 1 in them."""
        self._lists: dict[str, list[str]] = {"videos": [], "images": [], "tracks": [], "annotations": []}
        self._scored: dict[str, list[str]] = self._lists | {"images": [], "annotations": []}

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write the pictures of a video, and note what it shows."""
        videos, images, all_tracks, _ = self._lists.values()
        name, video_id = f"{SPLIT}/{self.name_of(episode)}", len(videos) + 1
        size = {"width": episode.camera.width_px, "height": episode.camera.height_px}
        tracks: dict[str, dict[str, int]] = {}
        for stored in self.frames(episode):
            file, shown = f"{name}/frame{stored.index:06d}", set[int]()
            self.write_picture(stored, f"frames/{file}")
            image = {"id": len(images) + 1, "video_id": video_id, "video": name}
            image |= {"file_name": file + self.ending, "frame_index": stored.index} | size
            for each in self.labels.instances(stored):
                if each.state != ABSENT and (each.is_seen or np.isfinite(each.box_xyxy).all()):
                    if each.name not in tracks:
                        track = {"id": len(all_tracks) + 1, "category_id": 1 + each.class_number, "video_id": video_id}
                        tracks[each.name] = track
                        all_tracks.append(as_text(track))
                    shown.add(tracks[each.name]["category_id"])
                    self._annotate(stored, each, tracks[each.name])
            images.append(as_text(image))
            self._scored["images"].append(as_text(image | self._not_shown(shown)))
        metadata = {"dataset": self.data.request.scenario, "seed": episode.seed, "fps": episode.rate_hz}
        not_shown = self._not_shown({track["category_id"] for track in tracks.values()})
        videos.append(as_text({"id": video_id, "name": name, "metadata": metadata} | size | not_shown))

    def end(self) -> None:
        """Write both JSON files."""
        for ending, lists, more in (("", self._lists, {}), ("_lvis_v1", self._scored, {"frequency": "f"})):
            head = head_of(self, synset="unknown", **more)
            write_json(self.place(f"amodal_annotations/{SPLIT}{ending}.json"), head, lists)

    def _not_shown(self, shown: Collection[int]) -> dict[str, list[int]]:
        missing = [number for number in range(1, 1 + len(self.labels.names)) if number not in shown]
        return {"neg_category_ids": missing, "not_exhaustive_category_ids": []}

    def _annotate(self, stored: StoredFrame, instance: Instance, track: dict[str, int]) -> None:
        amodal_xyxy, uncertain = instance.box_xyxy, bool(np.isnan(instance.box_xyxy).any())
        modal = as_xywh(instance.visible_xyxy) if instance.is_seen else [0.0] * 4
        amodal = modal if uncertain else as_xywh(amodal_xyxy)
        corner = (stored.camera.width_px, stored.camera.height_px)
        inside = not uncertain and (amodal_xyxy[:2] >= 0).all() and (amodal_xyxy[2:] <= corner).all()
        annotation: dict[str, Any] = {
            "id": len(self._lists["annotations"]) + 1,
            "image_id": len(self._lists["images"]) + 1,
            "track_id": track["id"],
            "bbox": modal,
            "area": modal[2] * modal[3],
            "iscrowd": 0,
            "category_id": track["category_id"],
            "video_id": track["video_id"],
            "amodal_bbox": amodal,
            "amodal_is_uncertain": uncertain,
            "visibility": instance.visible_fraction,
            "out_of_frame": not inside,
            "attributes": instance.attributes(),
        }
        self._lists["annotations"].append(as_text(annotation))
        scored = {"bbox": amodal, "area": amodal[2] * amodal[3]}
        self._scored["annotations"].append(as_text(annotation | scored))


def head_of(exporter: Exporter, **fields: str) -> dict[str, Any]:
    """Return what the files begin with; categories have further ``fields``."""
    request, names = exporter.data.request, exporter.labels.names
    return {
        "info": {"description": f"{request.scenario}, preset {request.preset}"},
        "licenses": [],
        "categories": [{"id": number, "name": name} | fields for number, name in enumerate(names, start=1)],
    }


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
