"""TAO-Amodal: tracks with modal and amodal boxes (Hsieh et al. 2023, https://arxiv.org/abs/2312.12433).

Fields: https://huggingface.co/datasets/chengyenhsieh/TAO-Amodal, and those of TAO that it extends.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.data_sets.data_set import DataSet
from benchmarks.data_sets.stored_episode import StoredEpisode
from benchmarks.export.export_format import ExportFormat
from benchmarks.export.frames import ABSENT, StoredFrame, episodes, frames, picture_ending, sequence_name, write_picture
from benchmarks.export.json_lists import JsonLists
from benchmarks.export.objects import as_xywh, kinds_of

SPLIT = "validation"
"""The split that trackers are scored on."""
_LISTS = ("videos", "images", "tracks", "annotations")
NOTE = """
Format: TAO-Amodal, https://huggingface.co/datasets/chengyenhsieh/TAO-Amodal (Hsieh et al. 2023, arXiv 2312.12433).
`amodal_annotations/validation.json` names the pictures in `frames/`. All episodes are in this one split.
`amodal_annotations/validation_lvis_v1.json` is what the format's own `tools/eval_on_tao_amodal.py` takes as
`--annotation`: the same annotations, where `bbox` and `area` are of the amodal box, for these are scored.

Boxes are left, top, width, height; the top left corner of the picture is 0, 0. Every object of the world has an
annotation in every picture, hidden or outside the picture too, unless it is wholly behind the camera.

- `bbox`: around the pixels that are seen; 0, 0, 0, 0 where none is. `area`: of that box.
- `amodal_bbox`: around the whole object, beyond the border of the picture too.
- `amodal_is_uncertain`: true where the object reaches behind the camera and has no amodal box; `bbox` stands for it.
- `visibility`: seen share of the object's own pixels, 0 to 1, counted and not the overlap of the two boxes.
- `out_of_frame`: whether the amodal box reaches beyond the border of the picture.

Truth is complete: `neg_category_ids` of a video are all categories that it does not show, and
`not_exhaustive_category_ids` is empty; in the second file pictures have both as well. Categories are the kinds of the
scene's objects, with the synset `unknown` and, in the second file, the frequency `f`.
"""


@dataclass
class _Video:
    """Numbers of one video's tracks and categories, as they come up. Numbers of tracks are unique in the file."""

    number: int
    tracks: dict[str, dict[str, int]] = field(default_factory=dict)


def _write(data: DataSet, folder: Path) -> None:
    categories = {kind: number for number, kind in enumerate(kinds_of(data), start=1)}
    named = [{"id": number, "name": kind, "synset": "unknown"} for kind, number in categories.items()]
    head: dict[str, Any] = {
        "info": {"description": f"{data.request.scenario}, preset {data.request.preset}"},
        "licenses": [],
        "categories": named,
    }
    scored_head = head | {"categories": [each | {"frequency": "f"} for each in named]}
    (folder / "amodal_annotations").mkdir()
    path, scored_path = (folder / "amodal_annotations" / f"{SPLIT}{ending}.json" for ending in ("", "_lvis_v1"))
    with JsonLists(path, _LISTS, head) as lists, JsonLists(scored_path, _LISTS, scored_head) as scored:
        writer = _Writer(data, folder, categories, lists, scored)
        for number, episode in enumerate(episodes(data), start=1):
            writer.add(_Video(number), episode)


class _Writer:
    """Writes videos, counting pictures, tracks and annotations from 1."""

    def __init__(
        self, data: DataSet, folder: Path, categories: dict[str, int], lists: JsonLists, scored: JsonLists
    ) -> None:
        self._data, self._folder, self._categories = data, folder, categories
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
            present = np.flatnonzero(stored.frame.truth.state != ABSENT)
            shown = {self._annotate(video, stored, int(k)) for k in present}
            self._lists.add("images", image)
            self._scored.add("images", image | self._not_shown(shown))
        metadata = {"dataset": self._data.request.scenario, "seed": episode.seed, "fps": episode.rate_hz}
        shown = {track["category_id"] for track in video.tracks.values()}
        about = {"id": video.number, "name": name, "metadata": metadata} | size | self._not_shown(shown)
        for lists in (self._lists, self._scored):
            lists.add("videos", about)

    def _not_shown(self, shown: Collection[int | None]) -> dict[str, list[int]]:
        missing = [each for each in self._categories.values() if each not in shown]
        return {"neg_category_ids": missing, "not_exhaustive_category_ids": []}

    def _annotate(self, video: _Video, stored: StoredFrame, k: int) -> int | None:
        """Annotate an object; return its category, None if it has no annotation here."""
        truth, seen = stored.frame.truth, bool(stored.is_seen[k])
        amodal_xyxy, uncertain = truth.box_xyxy[k], bool(np.isnan(truth.box_xyxy[k]).any())
        if uncertain and not seen:
            return None
        modal = as_xywh(stored.visible_xyxy[k]) if seen else [0.0] * 4
        corner = (stored.camera.width_px, stored.camera.height_px)
        inside = not uncertain and (amodal_xyxy[:2] >= 0).all() and (amodal_xyxy[2:] <= corner).all()
        track = self._track(video, truth.names[k], truth.kinds[k])
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
            "visibility": float(truth.visible_fraction[k]),
            "out_of_frame": not inside,
        }
        self._lists.add("annotations", annotation)
        self._scored.add("annotations", annotation | {"bbox": amodal, "area": amodal[2] * amodal[3]})
        return track["category_id"]

    def _track(self, video: _Video, name: str, kind: str) -> dict[str, int]:
        if name not in video.tracks:
            self._tracks += 1
            track = {"id": self._tracks, "category_id": self._categories[kind], "video_id": video.number}
            video.tracks[name] = track
            for lists in (self._lists, self._scored):
                lists.add("tracks", track)
        return video.tracks[name]


TAO_AMODAL = ExportFormat(
    summary="tracks with boxes of what is seen and of the whole objects, hidden and outside the picture too",
    needs="objects, pictures",
    channels=("image_rgb",),
    packages=(),
    note=NOTE,
    write=_write,
)
