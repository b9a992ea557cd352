"""TAO-Amodal: tracks with modal and amodal boxes (Hsieh et al. 2023, https://arxiv.org/abs/2312.12433).

Fields: https://huggingface.co/datasets/chengyenhsieh/TAO-Amodal, and those of TAO that it extends.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.data.exports.export_format import ExportFormat
from benchmarks.data.exports.frames import (
    ABSENT,
    StoredFrame,
    episodes,
    frames,
    picture_ending,
    sequence_name,
    write_picture,
)
from benchmarks.data.exports.json_lists import JsonLists
from benchmarks.data.exports.objects import ATTRIBUTES_NOTE, Instance, Labels, as_xywh, check_objects
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode

SPLIT = "validation"
"""The split that trackers are scored on."""
_LISTS = ("videos", "images", "tracks", "annotations")
NOTE = f"""
Format: TAO-Amodal, https://huggingface.co/datasets/chengyenhsieh/TAO-Amodal (Hsieh et al. 2023, arXiv 2312.12433).
`amodal_annotations/validation.json` names the pictures in `frames/`. All episodes are in this one split.
`amodal_annotations/validation_lvis_v1.json` is what the format's own `tools/eval_on_tao_amodal.py` takes as
`--annotation`: the same annotations, where `bbox` and `area` are of the amodal box, for these are scored.

Boxes are left, top, width, height; the top left corner of the picture is 0, 0. Every object that the scene asks about
has an annotation in every picture, hidden or outside the picture too, unless it is wholly behind the camera; what only
stands about, a parked car or a moored boat, has one where at least one pixel of it is seen.

- `bbox`: around the pixels that are seen; 0, 0, 0, 0 where none is. `area`: of that box.
- `amodal_bbox`: around the whole object, beyond the border of the picture too.
- `amodal_is_uncertain`: true where the object reaches behind the camera and has no amodal box; `bbox` stands for it.
- `visibility`: seen share of the object's own pixels, 0 to 1, counted and not the overlap of the two boxes.
- `out_of_frame`: whether the amodal box reaches beyond the border of the picture.

Truth of what is seen is complete: `neg_category_ids` of a video are all categories that it does not show, and
`not_exhaustive_category_ids` is empty; in the second file pictures have both as well. Categories are the classes of the
scene's own list, with the same numbers in every export of the scene with the same `--classes`, the synset `unknown`
and, in the second file, the frequency `f`. Annotations have `attributes` besides:
{ATTRIBUTES_NOTE.strip()}
"""


@dataclass
class _Video:
    """Numbers of one video's tracks and categories, as they come up. Numbers of tracks are unique in the file."""

    number: int
    tracks: dict[str, dict[str, int]] = field(default_factory=dict)


def _write(data: DataSet, folder: Path, labels: Labels) -> None:
    check_objects(data)
    named = [{"id": number, "name": name, "synset": "unknown"} for number, name in enumerate(labels.names, start=1)]
    head: dict[str, Any] = {
        "info": {"description": f"{data.request.scenario}, preset {data.request.preset}"},
        "licenses": [],
        "categories": named,
    }
    scored_head = head | {"categories": [each | {"frequency": "f"} for each in named]}
    (folder / "amodal_annotations").mkdir()
    path, scored_path = (folder / "amodal_annotations" / f"{SPLIT}{ending}.json" for ending in ("", "_lvis_v1"))
    with JsonLists(path, _LISTS, head) as lists, JsonLists(scored_path, _LISTS, scored_head) as scored:
        writer = _Writer(data, folder, labels, lists, scored)
        for number, episode in enumerate(episodes(data), start=1):
            writer.add(_Video(number), episode)


class _Writer:
    """Writes videos, counting pictures, tracks and annotations from 1."""

    def __init__(self, data: DataSet, folder: Path, labels: Labels, lists: JsonLists, scored: JsonLists) -> None:
        self._data, self._folder, self._labels = data, folder, labels
        self._lists, self._scored = lists, scored
        self._images = self._tracks = self._annotations = 0

    def add(self, video: _Video, episode: StoredEpisode) -> None:
        """Write a video."""
        name = f"{SPLIT}/{sequence_name(self._data, episode.seed)}"
        pictures = self._folder / "frames" / name
        pictures.mkdir(parents=True)
        ending = picture_ending(self._data)
        for stored in frames(episode):
            self._images += 1
            file = f"frame{stored.index:06d}"
            write_picture(stored, "image_rgb", pictures / file)
            size = {"width": stored.camera.width_px, "height": stored.camera.height_px}
            image = {"id": self._images, "video_id": video.number, "video": name}
            image |= {"file_name": f"{name}/{file}.{ending}", "frame_index": stored.index} | size
            present = (each for each in self._labels.instances(stored) if each.state != ABSENT)
            shown = {self._annotate(video, stored, each) for each in present}
            self._lists.add("images", image)
            self._scored.add("images", image | self._not_shown(shown))
        metadata = {"dataset": self._data.request.scenario, "seed": episode.seed, "fps": episode.rate_hz}
        shown = {track["category_id"] for track in video.tracks.values()}
        about = {"id": video.number, "name": name, "metadata": metadata} | size | self._not_shown(shown)
        for lists in (self._lists, self._scored):
            lists.add("videos", about)

    def _not_shown(self, shown: Collection[int | None]) -> dict[str, list[int]]:
        missing = [number for number in range(1, 1 + len(self._labels.names)) if number not in shown]
        return {"neg_category_ids": missing, "not_exhaustive_category_ids": []}

    def _annotate(self, video: _Video, stored: StoredFrame, instance: Instance) -> int | None:
        """Annotate an object; return its category, None if it has no annotation here."""
        amodal_xyxy, uncertain = instance.box_xyxy, bool(np.isnan(instance.box_xyxy).any())
        if uncertain and not instance.is_seen:
            return None
        modal = as_xywh(instance.visible_xyxy) if instance.is_seen else [0.0] * 4
        corner = (stored.camera.width_px, stored.camera.height_px)
        inside = not uncertain and (amodal_xyxy[:2] >= 0).all() and (amodal_xyxy[2:] <= corner).all()
        track = self._track(video, instance)
        self._annotations += 1
        amodal = modal if uncertain else as_xywh(amodal_xyxy)
        annotation = {
            "id": self._annotations,
            "image_id": self._images,
            "track_id": track["id"],
            "bbox": modal,
            "area": modal[2] * modal[3],
            "iscrowd": 0,
            "category_id": track["category_id"],
            "video_id": video.number,
            "amodal_bbox": amodal,
            "amodal_is_uncertain": uncertain,
            "visibility": instance.visible_fraction,
            "out_of_frame": not inside,
            "attributes": instance.attributes(),
        }
        self._lists.add("annotations", annotation)
        self._scored.add("annotations", annotation | {"bbox": amodal, "area": amodal[2] * amodal[3]})
        return track["category_id"]

    def _track(self, video: _Video, instance: Instance) -> dict[str, int]:
        if instance.name not in video.tracks:
            self._tracks += 1
            track = {"id": self._tracks, "category_id": 1 + instance.class_number, "video_id": video.number}
            video.tracks[instance.name] = track
            for lists in (self._lists, self._scored):
                lists.add("tracks", track)
        return video.tracks[instance.name]


TAO_AMODAL = ExportFormat(
    summary="tracks with boxes of what is seen and of the whole objects, hidden and outside the picture too",
    needs="objects, pictures",
    channels=("image_rgb",),
    packages=(),
    note=NOTE,
    write=_write,
    has_classes=True,
)
