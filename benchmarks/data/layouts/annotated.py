"""JSON files of annotations: pictures, and boxes of targets in them, as COCO and what extends it write them.

One target of each sequence is followed, see ``layouts.followed``: by its ``track_id``, or by the ``name`` in its
``attributes``. A picture of the sequence's folder that the file does not name is shown to trackers and not scored.
Boxes are left, top, width, height; the top left corner of the picture is at 0, 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.contract.text import printable
from benchmarks.data.coco_json import read_json
from benchmarks.data.layouts.followed import followed
from benchmarks.data.layouts.layout import Target
from benchmarks.data.pictures import pictures_in, read_picture, short
from benchmarks.data.sequences import OCCLUDED, OUT, UNLABELLED, UNSEEN, Labelled, corners_of
from scenarios.visibility import MOSTLY_SEEN
from sim.checks import check

Entry = Mapping[str, Any]
_BOX = "left, top, width, height with a width and height >= 0"


@dataclass(frozen=True)
class Annotations:
    """What a file says.

    Attributes:
        file: it. videos: entries. images: entries with ``id`` and ``file_name``.
        boxes: number of a picture → entries of its boxes, with ``bbox`` and a target.
    """

    file: Path
    videos: list[Entry]
    images: list[Entry]
    boxes: dict[int, list[Entry]]


def read_annotations(file: Path) -> Annotations | None:
    """Return what a file says; None if it lists no pictures.

    Raises:
        ValueError: for a file that is no JSON, and an entry that lacks what is read; names it.
    """
    return _read(file, file.stat().st_mtime_ns)


@lru_cache(maxsize=4)
def _read(file: Path, changed_ns: int) -> Annotations | None:
    """Return the same: a file is read once for all of its sequences."""
    content = read_json(file)
    if not isinstance(content, dict) or not isinstance(content.get("images"), list):
        return None
    images = _entries(file, content, "images", {"id": int, "file_name": str})
    boxes: dict[int, list[Entry]] = {}
    for number, each in enumerate(_entries(file, content, "annotations", {"image_id": int, "bbox": list}), start=1):
        where, seen = f"{short(file)}, annotations, entry {number}", each.get("visibility", 1.0)
        check(where, not each["bbox"] or _is_box(each["bbox"]), _BOX, repr(each["bbox"])[:80])
        check(where, isinstance(seen, int | float), "a number as visibility", repr(seen)[:80])
        boxes.setdefault(each["image_id"], []).append(each)
    return Annotations(file, _entries(file, content, "videos", {"id": int, "name": str}), images, boxes)


def labelled(
    name: str, root: Path, said: Annotations, images: Sequence[Entry], rate_hz: float, target: Target
) -> Labelled:
    """Return what a file says of a target in a sequence.

    Args:
        root: folder that ``file_name`` begins at. images: of the sequence.

    Raises:
        ValueError: see ``Source``.
    """
    places = {root / each["file_name"]: each["id"] for each in images}
    folder = root / Path(images[0]["file_name"]).parent
    pictures = pictures_in(folder)
    missing = next((short(each) for each in sorted(places.keys() - set(pictures))), "")
    check(short(said.file), not missing, f"pictures that are in {short(folder)}", f"{missing}, which is not")
    own = [each for picture in pictures for each in said.boxes.get(places.get(picture, -1), [])]
    mine = _of_target(target, said.file, own)
    height, width = read_picture(pictures[0]).shape[:2]
    boxes, tags = np.full((len(pictures), 4), np.nan), np.full(len(pictures), UNLABELLED)
    for k, picture in enumerate(pictures):
        if picture in places:
            found = [each for each in said.boxes.get(places[picture], []) if _is(each, mine)]
            where = f"{short(said.file)}, picture {places[picture]}"
            check(where, len(found) <= 1, f"one box of {mine}", len(found))
            boxes[k], tags[k] = _label(where, found[0], width, height) if found else (np.nan, UNSEEN)
    return Labelled(f"{printable(name)}-{mine}", said.file, pictures, boxes, tags, whole=True, rate_hz=rate_hz)


def _of_target(target: Target, file: Path, boxes: Sequence[Entry]) -> str:
    """Return the id of the target that is followed, or its name. Raises ValueError for an unknown one."""
    seen = [each for each in boxes if target is not None or _is_seen(each)]
    by_name = [name for each in seen if (name := _name(each))]
    if target is not None and str(target) in by_name:
        return str(target)
    ids = [str(each.get("track_id", _name(each))) for each in seen]
    return followed(target, file, [each for each in ids if each])[0]


def _is(entry: Entry, target: str) -> bool:
    return target in (str(entry.get("track_id")), _name(entry))


def _name(entry: Entry) -> str:
    attributes = entry.get("attributes")
    return str(attributes.get("name", "")) if isinstance(attributes, dict) else ""


def _is_seen(entry: Entry) -> bool:
    return bool(entry.get("visibility", 1.0) > 0 and min(entry["bbox"][2:], default=0) > 0)


def _is_box(box: Any) -> bool:
    """Return whether a value is four numbers with a size of at least 0."""
    numbers = isinstance(box, list) and len(box) == 4 and all(isinstance(each, int | float) for each in box)
    return numbers and bool(np.isfinite(box).all()) and min(box[2:]) >= 0


def _label(where: str, entry: Entry, width: int, height: int) -> tuple[Any, str]:
    """Return the box (4,) and the tag of a target in a picture."""
    whole = "amodal_bbox" in entry and not entry.get("amodal_is_uncertain", False)
    box = entry["amodal_bbox" if whole else "bbox"]
    check(where, _is_box(box), _BOX, repr(box)[:80])
    box_xyxy = corners_of(np.array([box], float), 0.0)[0]
    meets = (box_xyxy[:2] < (width, height)).all() and (box_xyxy[2:] > 0).all()
    if not _is_seen(entry):
        return np.nan, UNSEEN if not whole else OCCLUDED if meets else OUT
    return box_xyxy, OCCLUDED if entry.get("visibility", 1.0) < MOSTLY_SEEN else ""


def _entries(file: Path, content: Entry, name: str, needed: Mapping[str, type]) -> list[Entry]:
    """Return the entries of a list, none without it. Raises ValueError for one that lacks what is ``needed``."""
    entries = content.get(name, [])
    for number, each in enumerate(entries if isinstance(entries, list) else [entries], start=1):
        good = isinstance(each, dict) and all(isinstance(each.get(key), kind) for key, kind in needed.items())
        wanted = " and ".join(f"{key} ({kind.__name__})" for key, kind in needed.items())
        check(f"{short(file)}, {name}, entry {number}", good, wanted, repr(each)[:80])
    return list(entries)
