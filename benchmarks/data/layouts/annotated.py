"""JSON files of annotations: pictures, and boxes of targets in them, as COCO and what extends it write them.

One target of each sequence is followed, see ``layouts.followed``: by its ``track_id``, or by the ``name`` in its
``attributes``. A picture of the sequence's folder that the file does not name is shown to trackers and not scored.
Boxes are left, top, width, height; the top left corner of the picture is at 0, 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.contract.text import printable
from benchmarks.data.box_files import corners_of
from benchmarks.data.coco_json import BOX, Entry, is_box
from benchmarks.data.layouts.followed import followed
from benchmarks.data.layouts.layout import Target
from benchmarks.data.pictures import pictures_in, read_picture, short
from benchmarks.data.sequences import OCCLUDED, OUT, UNLABELLED, UNSEEN, Labelled
from scenarios.visibility import MOSTLY_SEEN
from sim.checks import check


def labelled(
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
            found = [each for each in boxes_in.get(places[picture], []) if _is(each, mine)]
            where = f"{short(file)}, picture {places[picture]}"
            check(where, len(found) <= 1, f"one box of {mine}", len(found))
            boxes[k], tags[k] = _label(where, found[0], width, height) if found else (np.nan, UNSEEN)
    return Labelled(f"{printable(name)}-{mine}", file, pictures, boxes, tags, whole=True, rate_hz=rate_hz)


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
