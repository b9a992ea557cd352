"""YOLO and DOTA: a text file of boxes or outlines for each picture.

YOLO: https://docs.ultralytics.com/datasets/. DOTA: Xia et al. 2018, https://arxiv.org/abs/1711.10398.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import Instance, StoredFrame
from benchmarks.data.exports.outlines import oriented_box, polygon_of
from benchmarks.data.exports.sidecar import Sidecar
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.request import SPLITS
from benchmarks.data.sets.stored_episode import StoredEpisode
from sim.checks import check
from sim.optics import project

VALIDATION_SHARE = 0.2
_MOST = 1.01
"""Least and greatest shares that Ultralytics' check of labels lets pass are ``1 - _MOST`` and ``_MOST``."""


def parts_of(data: DataSet) -> dict[int, str]:
    """Return the split of each seed: that of the set; one without shares has ``train`` and ``val`` beside ``test``.

    Raises:
        ValueError: if there is nothing to train on or nothing to validate on, unless all are for test.
    """
    parts = {seed: split for split, seeds in data.splits.items() for seed in seeds}
    if not data.request.splits:
        seeds = data.splits.get("train", ())
        last = math.ceil(VALIDATION_SHARE * len(seeds)) if len(seeds) > 1 else 0
        parts |= dict.fromkeys(seeds[len(seeds) - last :], "val")
    check_trainable(parts.values(), "episodes")
    return parts


def check_trainable(splits: Iterable[str], what: str) -> None:
    """Raise ValueError if of ``what`` some are for training or validation, but not for both."""
    counts = Counter(splits)
    got = ", ".join(f"{counts[split]} for {split}" for split in SPLITS)
    good = bool(counts["train"]) == bool(counts["val"]) and counts.total() > 0
    check("data", good, f"{what} to train on and to validate on (more seeds, other splits), or for test alone", got)


class LabelFiles(Exporter):
    """A text file of lines for each picture, in folders for training and validation, and a table of all lines.

    Attributes:
        pictures, texts: places of a picture and its text file, with ``{part}`` and ``{name}``.
        heading: first lines of each text file.
    """

    channels: ClassVar[tuple[str, ...]] = ("image_rgb",)
    has_attributes = True
    has_classes = True
    leaves_out = True
    of_stills = True
    pictures: ClassVar[str] = "images/{part}/{name}"
    texts: ClassVar[str] = "labels/{part}/{name}.txt"
    heading: ClassVar[tuple[str, ...]] = ()

    def line(self, stored: StoredFrame, instance: Instance, taken: bool) -> str | None:
        """Return the line of an object; None without one. ``taken``: see ``Labels.seen``."""
        raise NotImplementedError

    def begin(self) -> None:
        """Split the seeds."""
        self._parts, self._counts = parts_of(self.data), Counter[str]()
        self._sidecar = Sidecar(self.labels)

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures and their labels, and note the rows of the sidecar."""
        for stored in self.frames(episode):
            names = {"part": self._parts[episode.seed], "name": f"{self.name_of(episode)}_{stored.index:06d}"}
            file, lines = self.texts.format(**names), list(self.heading)
            self._counts[names["part"]] += 1
            self.write_picture(stored, self.pictures.format(**names))
            for each, taken in self.labels.seen(stored):
                line = self.line(stored, each, taken)
                if line is not None:
                    lines.append(line)
                    self._sidecar.add(file, len(lines), each)
            self.write_lines(file, lines)

    def end(self) -> None:
        """Write the sidecar. Raises ValueError if too few pictures are left of a split, see ``Request.negatives``."""
        check_trainable(self._counts.elements(), "pictures")
        self._sidecar.write(self.folder)


class YoloFormat(LabelFiles):
    """Lines of a class and numbers, shares of the picture's width and height in turn."""

    def numbers_px(self, stored: StoredFrame, instance: Instance) -> NDArray[np.float64]:
        """Return the numbers of an object's line in pixels, (P, 2)."""
        raise NotImplementedError

    def begin(self) -> None:
        """Split the seeds, and write the names of classes."""
        super().begin()
        # A string of JSON is one of YAML, whatever it holds.
        names = (f"  {number}: {json.dumps(name)}" for number, name in enumerate(self.labels.names))
        splits = {split: split for split in ("train", "val", *self._parts.values())}
        if "val" not in self._parts.values():
            # Ultralytics reads no file without both, nor one whose pictures of ``val`` are not there.
            splits["val"] = "test"
        folders = (f"{split}: images/{folder}" for split, folder in splits.items())
        self.write_lines("data.yaml", [*folders, "names:", *names])

    def line(self, stored: StoredFrame, instance: Instance, taken: bool) -> str | None:
        """See ``LabelFiles``: none of what is to be ignored, for which YOLO has no mark."""
        if not taken:
            return None
        shares = self.numbers_px(stored, instance) / (stored.camera.width_px, stored.camera.height_px)
        return " ".join([str(instance.class_number), *(repr(float(share)) for share in shares.ravel())])


@export_format("yolo")
class Yolo(YoloFormat):
    """Boxes of what is seen, a text file for each picture, split by seeds.

    Format: https://docs.ultralytics.com/datasets/detect/. `data.yaml` names the classes, those of the scene's own list
    with the same numbers in every export of the scene with the same `--classes`, and the folders of pictures; `labels/`
    has a text file for each picture, empty where no object is seen. Parked cars and moored boats have lines too; what
    is to be ignored (`--min-visible`, without what glare covers, `--min-size`, `--ignore-standing`) has none.

    A line is class, x and y of the centre, width and height of the box around the pixels that are seen, as shares of
    the picture's width and height. Whole episodes are for training, validation or test, as the set's shares say; in a
    set without shares the last 20 % of all seeds in order, at least one, are for validation, and those of the
    benchmark's test split for test. A set with too few episodes for both training and validation is refused. One for
    test alone has no pictures to train on, and its `val` is the folder `images/test`.

    `objects.csv` says what the format has no place for, a row for each line of the text files: file, line (from 1),
    class, and more of each object.
    """

    def numbers_px(self, stored: StoredFrame, instance: Instance) -> NDArray[np.float64]:
        """See ``YoloFormat``: centre and size."""
        low, high = instance.visible_xyxy.reshape(2, 2)
        return np.array([0.5 * (low + high), high - low])


@export_format("yolo-seg")
class YoloSegmentation(YoloFormat):
    """Outlines of what is seen, a text file for each picture, split by seeds.

    Format: https://docs.ultralytics.com/datasets/segment/. Folders, classes, splits and `objects.csv` are those of the
    format `yolo`; what is to be ignored (`--min-visible`, without what glare covers, `--min-size`,
    `--ignore-standing`) has no line.

    A line is class and a polygon of at least three points, x and y in turn as shares of the picture's width and height,
    through the centres of the outermost pixels that are seen. As Ultralytics reads it (scaled to pixels, cut to whole
    numbers, filled by `cv2.fillPoly`) it gives the mask back, pixel by pixel. The format has one polygon an object:
    parts and holes are joined to one line by the shortest ways between them, walked there and back, as Ultralytics
    joins those of COCO. Holes stay holes; a way between two parts is one pixel wide in the mask. Boxes that are made of
    polygons end in the middle of the outermost pixels, half a pixel inside of those of the format `yolo`.
    """

    channels = ("image_rgb", "instance_map")

    def numbers_px(self, stored: StoredFrame, instance: Instance) -> NDArray[np.float64]:
        """See ``YoloFormat``: the polygon."""
        corner, mask = _mask_of(stored, instance)
        return corner + polygon_of(mask)


@export_format("yolo-obb")
class YoloOriented(YoloFormat):
    """Oriented boxes of what is seen, a text file for each picture, split by seeds.

    Format: https://docs.ultralytics.com/datasets/obb/. Folders, classes, splits and `objects.csv` are those of the
    format `yolo`; what is to be ignored (`--min-visible`, without what glare covers, `--min-size`,
    `--ignore-standing`) has no line.

    A line is class and four corners, x and y in turn as shares of the picture's width and height: the rectangle of
    least area around the pixels that are seen, as annotators of aerial pictures (DOTA) draw it, not the outline of the
    object's foot on the ground, which roofs overhang in slanted views. Corners go round clockwise from the object's
    front left. At the border a corner may lie outside of the picture; where Ultralytics would refuse the line for that,
    the corners are those of the upright box.
    """

    channels = ("image_rgb", "instance_map")

    def numbers_px(self, stored: StoredFrame, instance: Instance) -> NDArray[np.float64]:
        """See ``YoloFormat``: the corners."""
        corners = oriented_corners_px(stored, instance)
        low, high = (
            end(corners, axis=0) / (stored.camera.width_px, stored.camera.height_px) for end in (np.min, np.max)
        )
        checked = np.array([0.5 * (low + high), high - low])
        if checked.min() >= 1.0 - _MOST and checked.max() <= _MOST:
            return corners
        left, top, right, bottom = instance.visible_xyxy
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


@export_format("dota")
class Dota(LabelFiles):
    """Oriented boxes of what is seen, in the text of DOTA, split by seeds.

    Format: DOTA, https://captain-whu.github.io/DOTA/dataset.html (Xia et al. 2018, arXiv 1711.10398). `train/` and
    `val/` hold `images/` and `labelTxt/`, where a file begins with `imagesource:` and `gsd:` and has a line an object:
    x and y of four corners in pixels, from the top left corner of the picture, the name of the class (spaces are `-`),
    and `difficult`, 1 for what is to be ignored (`--min-visible`, without what glare covers, `--min-size`,
    `--ignore-standing`).

    The box is the rectangle of least area around the pixels that are seen. Corners go round clockwise from the object's
    front left; near the border one may lie outside of the picture. Whole episodes are for training, validation or test
    (`test/`), as those of the format `yolo`. `objects.csv` says what the format has no place for, a row for each of
    those lines: file, line (from 1), class, and more of each object.
    """

    channels = ("image_rgb", "instance_map")
    pictures = "{part}/images/{name}"
    texts = "{part}/labelTxt/{name}.txt"
    heading = ("imagesource:Frameout", "gsd:null")

    def line(self, stored: StoredFrame, instance: Instance, taken: bool) -> str:
        """See ``LabelFiles``."""
        corners = " ".join(f"{number:.3f}" for number in oriented_corners_px(stored, instance).ravel())
        return f"{corners} {self.labels.names[instance.class_number].replace(' ', '-')} {1 - taken}"


def oriented_corners_px(stored: StoredFrame, instance: Instance) -> NDArray[np.float64]:
    """Return the corners (4, 2) of an object's oriented box, see ``oriented_box``."""
    corner, mask = _mask_of(stored, instance)
    middle_m = np.append(instance.bounds_m.mean(axis=0), 1.0)
    ahead_m = middle_m + 0.5 * (instance.bounds_m[1, 0] - instance.bounds_m[0, 0]) * np.array([1.0, 0.0, 0.0, 0.0])
    places_m = (instance.T_world_object @ np.stack([middle_m, ahead_m], axis=1)).T[:, :3]
    pixels, _ = project(stored.camera, stored.frame.truth.T_world_camera, places_m)
    return corner + oriented_box(mask, pixels[1] - pixels[0])


def _mask_of(stored: StoredFrame, instance: Instance) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the top left corner (2,) of an object's visible box, and its pixels in that (h, w)."""
    left, top, right, bottom = instance.visible_xyxy.astype(int)
    mask = stored.frame.truth.instance_map[top:bottom, left:right] == instance.instance_id
    return np.array([left, top], float), mask
