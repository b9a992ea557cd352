"""COCO, TAO and TAO-Amodal: JSON files of annotations, which name pictures and the boxes of targets in them.

One target of each sequence is followed, see ``layouts.followed``: by its ``track_id``, or by the ``name`` in its
``attributes``. A picture of the sequence's folder that the file does not name is shown to trackers and not scored.
Boxes are left, top, width, height; the top left corner of the picture is at 0, 0.

* COCO, https://cocodataset.org/#format-data: ``annotations/instances.json`` (or ``instances_train.json`` …) and
  ``images/NAME/000000.png …``, those of our export. It has no sequences and tracks: a folder of pictures is a sequence
  here, also ``images`` itself, in the order of their names. The box is that of the pixels that are seen; without one
  the target is not seen, and no file says why.
* TAO: ``annotations/validation.json`` and ``frames/``. Dave et al., TAO: a large-scale benchmark for tracking any
  object, ECCV 2020; its fields are in ``tao/toolkit/tao/tao.py`` of https://github.com/TAO-Dataset/tao. ``images``
  names the labelled pictures of each of ``videos``, one a second.
* TAO-Amodal: ``amodal_annotations/validation.json``. Hsieh et al., https://arxiv.org/abs/2312.12433; ``export --format
  tao-amodal`` writes it. The box around the whole target counts, ``amodal_bbox``, unless it is uncertain; with a
  ``visibility`` of 0 the target is hidden, or outside where that box is, and with less than a half hidden in part.
  Files for its evaluation (``…_lvis_v1.json``) repeat others and are not read. ``metadata`` of an export's videos tells
  ``fps``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.data.box_files import corners_of, rate_of
from benchmarks.data.coco_json import BOX, Annotations, Entry, is_box, read_annotations
from benchmarks.data.layouts.followed import followed
from benchmarks.data.layouts.layout import Source, Target, layout
from benchmarks.data.pictures import pictures_in, read_picture, short, visible
from benchmarks.data.sequences import OCCLUDED, OUT, UNLABELLED, UNSEEN, Labelled
from scenarios.visibility import MOSTLY_SEEN
from sim.checks import check

_FOLDERS = ("annotations", "amodal_annotations")
_REPEATS = "_lvis_v1.json"


@layout("coco", "annotations/*.json without videos, whose boxes have names or track_id, beside images/")
def find_coco(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    root = path / "images"
    for file in visible(path / "annotations", "*.json") if root.is_dir() else ():
        said = read_annotations(file)
        if said is not None and not said.videos:
            yield from _folders(root, file, said)


def _folders(root: Path, file: Path, said: Annotations) -> Iterator[Source]:
    sequences: dict[Path, list[Entry]] = {}
    for each in said.images:
        sequences.setdefault(Path(each["file_name"]).parent, []).append(each)
    for folder, images in sequences.items():
        name = "-".join(folder.parts) or root.parent.name
        yield Source(name, (root / folder, file), partial(_read, name, root, file, said.boxes, images, 0.0))


@layout("tao", "annotations/*.json or amodal_annotations/*.json, with videos, beside frames/")
def find_tao(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    root = path / "frames"
    files = [file for place in _FOLDERS for file in visible(path / place, "*.json") if root.is_dir()]
    for file in files:
        said = None if file.name.endswith(_REPEATS) else read_annotations(file)
        if said is not None:
            yield from _videos(root, file, said)


def _videos(root: Path, file: Path, said: Annotations) -> Iterator[Source]:
    images: dict[int, list[Entry]] = {}
    for each in said.images:
        images.setdefault(each.get("video_id", -1), []).append(each)
    for video in said.videos:
        if mine := images.get(video["id"]):
            name, metadata = Path(video["name"]).name, video.get("metadata")
            rate_hz = rate_of(str(metadata.get("fps", ""))) if isinstance(metadata, dict) else 0.0
            places = ((root / mine[0]["file_name"]).parent, file)
            yield Source(name, places, partial(_read, name, root, file, said.boxes, mine, rate_hz))


def _read(
    name: str,
    root: Path,
    file: Path,
    boxes_in: Mapping[int, Sequence[Entry]],
    images: Sequence[Entry],
    rate_hz: float,
    target: Target,
) -> Labelled:
    """Return what a file says of a target in a sequence.

    Args:
        root: folder that ``file_name`` begins at. boxes_in: see ``Annotations.boxes``. images: of the sequence.

    Raises:
        ValueError: see ``Source``.
    """
    places = {root / each["file_name"]: each["id"] for each in images}
    folder = root / Path(images[0]["file_name"]).parent
    pictures = pictures_in(folder)
    missing = next((short(each) for each in sorted(places.keys() - set(pictures))), "")
    check(short(file), not missing, f"pictures that are in {short(folder)}", f"{missing}, which is not")
    own = [each for picture in pictures for each in boxes_in.get(places.get(picture, -1), [])]
    mine = _of_target(target, file, own)
    height, width = read_picture(pictures[0]).shape[:2]
    boxes, tags = np.full((len(pictures), 4), np.nan), np.full(len(pictures), UNLABELLED)
    for k, picture in enumerate(pictures):
        if picture in places:
            found = [
                each for each in boxes_in.get(places[picture], []) if mine in (str(each.get("track_id")), _name(each))
            ]
            where = f"{short(file)}, picture {places[picture]}"
            check(where, len(found) <= 1, f"one box of {mine}", len(found))
            boxes[k], tags[k] = _label(where, found[0], width, height) if found else (np.nan, UNSEEN)
    return Labelled(f"{name}-{mine}", file, pictures, boxes, tags, whole=True, rate_hz=rate_hz)


def _of_target(target: Target, file: Path, boxes: Sequence[Entry]) -> str:
    """Return the id of the target that is followed, or its name. Raises ValueError for an unknown one."""
    seen = [each for each in boxes if target is not None or _is_seen(each)]
    by_name = [name for each in seen if (name := _name(each))]
    if target is not None and str(target) in by_name:
        return str(target)
    ids = [str(each.get("track_id", _name(each))) for each in seen]
    return followed(target, file, [each for each in ids if each])[0]


def _name(entry: Entry) -> str:
    attributes = entry.get("attributes")
    return str(attributes.get("name", "")) if isinstance(attributes, dict) else ""


def _is_seen(entry: Entry) -> bool:
    return bool(entry.get("visibility", 1.0) > 0 and min(entry["bbox"][2:], default=0) > 0)


def _label(where: str, entry: Entry, width: int, height: int) -> tuple[Any, str]:
    """Return the box (4,) and the tag of a target in a picture."""
    whole = "amodal_bbox" in entry and not entry.get("amodal_is_uncertain", False)
    box = entry["amodal_bbox" if whole else "bbox"]
    check(where, is_box(box), BOX, repr(box)[:80])
    box_xyxy = corners_of(np.array([box], float), 0.0)[0]
    meets = (box_xyxy[:2] < (width, height)).all() and (box_xyxy[2:] > 0).all()
    if not _is_seen(entry):
        return np.nan, UNSEEN if not whole else OCCLUDED if meets else OUT
    return box_xyxy, OCCLUDED if entry.get("visibility", 1.0) < MOSTLY_SEEN else ""
