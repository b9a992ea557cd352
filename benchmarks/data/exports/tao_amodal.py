"""TAO-Amodal: tracks with modal and amodal boxes (Hsieh et al. 2023, https://arxiv.org/abs/2312.12433).

Fields: https://huggingface.co/datasets/chengyenhsieh/TAO-Amodal, and those of TAO that it extends.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from benchmarks.data.exports.coco import categories, json_head, json_lists
from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import ABSENT, Instance, StoredFrame, as_xywh
from benchmarks.data.sets.stored_episode import StoredEpisode

SPLIT = "validation"
"""The split that trackers are scored on."""
_LISTS = ("videos", "images", "tracks", "annotations")


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
    needs_objects = True
    has_classes = True

    def begin(self) -> None:
        """Begin both JSON files; videos, pictures, tracks and annotations are counted from 1 in them."""
        fields = ({"synset": "unknown"}, {"synset": "unknown", "frequency": "f"})
        self._add, self._add_scored = (
            self.stack.enter_context(
                json_lists(
                    self.folder / "amodal_annotations" / f"{SPLIT}{ending}.json",
                    _LISTS,
                    json_head(self) | {"categories": categories(self, **each)},
                )
            )
            for ending, each in zip(("", "_lvis_v1"), fields, strict=True)
        )
        self._video = self._images = self._tracks = self._annotations = 0

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write a video."""
        self._video += 1
        self._of_video: dict[str, dict[str, int]] = {}
        name = f"{SPLIT}/{self.name_of(episode)}"
        size = {"width": episode.camera.width_px, "height": episode.camera.height_px}
        for stored in self.frames(episode):
            self._images += 1
            file = f"{name}/frame{stored.index:06d}"
            self.write_picture(stored, f"frames/{file}")
            image = {"id": self._images, "video_id": self._video, "video": name}
            image |= {"file_name": file + self.ending, "frame_index": stored.index} | size
            present = (each for each in self.labels.instances(stored) if each.state != ABSENT)
            shown = {self._annotate(stored, each) for each in present}
            self._add("images", image)
            self._add_scored("images", image | self._not_shown(shown))
        metadata = {"dataset": self.data.request.scenario, "seed": episode.seed, "fps": episode.rate_hz}
        shown = {track["category_id"] for track in self._of_video.values()}
        about = {"id": self._video, "name": name, "metadata": metadata} | size | self._not_shown(shown)
        for add in (self._add, self._add_scored):
            add("videos", about)

    def _not_shown(self, shown: Collection[int | None]) -> dict[str, list[int]]:
        missing = [number for number in range(1, 1 + len(self.labels.names)) if number not in shown]
        return {"neg_category_ids": missing, "not_exhaustive_category_ids": []}

    def _annotate(self, stored: StoredFrame, instance: Instance) -> int | None:
        """Annotate an object; return its category, None if it has no annotation here."""
        amodal_xyxy, uncertain = instance.box_xyxy, bool(np.isnan(instance.box_xyxy).any())
        if uncertain and not instance.is_seen:
            return None
        modal = as_xywh(instance.visible_xyxy) if instance.is_seen else [0.0] * 4
        corner = (stored.camera.width_px, stored.camera.height_px)
        inside = not uncertain and (amodal_xyxy[:2] >= 0).all() and (amodal_xyxy[2:] <= corner).all()
        track = self._track(instance)
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
            "video_id": self._video,
            "amodal_bbox": amodal,
            "amodal_is_uncertain": uncertain,
            "visibility": instance.visible_fraction,
            "out_of_frame": not inside,
            "attributes": instance.attributes(),
        }
        self._add("annotations", annotation)
        self._add_scored("annotations", annotation | {"bbox": amodal, "area": amodal[2] * amodal[3]})
        return track["category_id"]

    def _track(self, instance: Instance) -> dict[str, int]:
        if instance.name not in self._of_video:
            self._tracks += 1
            track = {"id": self._tracks, "category_id": 1 + instance.class_number, "video_id": self._video}
            self._of_video[instance.name] = track
            for add in (self._add, self._add_scored):
                add("tracks", track)
        return self._of_video[instance.name]
