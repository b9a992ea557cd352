"""JSON of COCO and TAO: annotations and results. Boxes are left, top, width, height; the picture begins at 0, 0.

* Results are a list of ``{"image_id", "category_id", "bbox", "score"}``, in TAO with ``"track_id"`` (and
  ``"video_id"``, which says nothing new): https://cocodataset.org/#format-results, and
  https://github.com/TAO-Dataset/tao/blob/master/docs/evaluation.md.
* Files of annotations name the pictures, ``"images": [{"id", "file_name", …}]``, the ``"categories"``, in TAO the
  ``"videos"``, and the boxes, ``"annotations"``: https://cocodataset.org/#format-data.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.pictures import Picture, short
from benchmarks.data.read_once import read_once
from sim.checks import check

NO_TRACK = -1
Entry = Mapping[str, Any]
BOX = "left, top, width, height with a width and height >= 0"
_RESULT = '{"image_id": 1, "category_id": 1, "bbox": [left, top, width, height], "score": 0.9}'


@dataclass(frozen=True, eq=False)
class Results:
    """R results of a file, in its order.

    Attributes:
        image_id: (R,). category_id: (R,).
        box_xyxy: (R, 4) pixels, from the top left corner of the picture.
        score: (R,) as given.
        track_id: (R,); ``NO_TRACK`` where there is none.
    """

    image_id: NDArray[np.int64]
    category_id: NDArray[np.int64]
    box_xyxy: NDArray[np.float64]
    score: NDArray[np.float64]
    track_id: NDArray[np.int64]


@dataclass(frozen=True)
class Annotations:
    """What a file of annotations says.

    Attributes:
        file: it.
        images: entries with ``id``, ``file_name`` and maybe ``video_id``. videos: entries with ``id`` and ``name``.
        categories: number → name.
        content: all of the file.
    """

    file: Path
    images: list[Entry]
    videos: list[Entry]
    categories: dict[int, str]
    content: Entry

    @cached_property
    def folders(self) -> dict[str, dict[str, int]]:
        """Name of a folder → name of a picture in it → its number."""
        found = defaultdict[str, dict[str, int]](dict)
        for each in self.images:
            *above, name = PurePosixPath(each["file_name"]).parts or ("",)
            found[above[-1] if above else ""][name] = each["id"]
        return found

    @cached_property
    def boxes(self) -> dict[int, list[Entry]]:
        """Number of a picture → annotations of it, with ``bbox``. Raises ValueError for one that is none; names it."""
        found: dict[int, list[Entry]] = {}
        for number, each in enumerate(_entries(self.file, self.content, "annotations", _ANNOTATION), start=1):
            where, seen = f"{short(self.file, 3)}, annotations, entry {number}", each.get("visibility", 1.0)
            check(where, not each["bbox"] or is_box(each["bbox"]), BOX, repr(each["bbox"])[:80])
            check(where, isinstance(seen, int | float), "a number as visibility", repr(seen)[:80])
            found.setdefault(each["image_id"], []).append(each)
        return found


@read_once
def read_results(path: Path) -> Results:
    """Return the results of a file, maybe none.

    Raises:
        ValueError: for a file that is no JSON, or of another kind, and for an entry that is no result; names it.
    """
    where, entries = short(path, 3), read_json(path)
    check(where, isinstance(entries, list), f"a list of results such as {_RESULT}", type(entries).__name__)
    rows = [_row(f"{where}, entry {number}", each) for number, each in enumerate(entries, start=1)]
    numbers = np.array([row[:3] for row in rows], np.int64).reshape(-1, 3)
    box_xywh = np.array([row[3] for row in rows], float).reshape(-1, 4)
    box_xyxy = np.concatenate([box_xywh[:, :2], box_xywh[:, :2] + box_xywh[:, 2:]], axis=1)
    return Results(numbers[:, 0], numbers[:, 1], box_xyxy, np.array([row[4] for row in rows], float), numbers[:, 2])


@read_once
def read_annotations(path: Path) -> Annotations | None:
    """Return what a file of annotations says; None of one that lists no pictures.

    Raises:
        ValueError: for a file that is no JSON, and an entry that lacks what is read; names it.
    """
    content = read_json(path)
    if not isinstance(content, dict) or not isinstance(content.get("images"), list):
        return None
    images, videos = (
        _entries(path, content, name, needed) for name, needed in (("images", _IMAGE), ("videos", _VIDEO))
    )
    categories = content.get("categories")
    named = [each for each in categories if isinstance(each, dict)] if isinstance(categories, list) else []
    names = {int(each["id"]): str(each.get("name", each["id"])) for each in named if _is_whole(each.get("id"))}
    return Annotations(path, images, videos, names, content)


def read_json(path: Picture) -> Any:
    """Return the content of a JSON file. Raises ValueError, which names file and line, for one that is none."""
    try:
        return json.loads(path.read_bytes())
    except json.JSONDecodeError as error:
        raise ValueError(f"{short(path, 3)}, line {error.lineno}: expected JSON, got {error.msg}") from None
    except (ValueError, RecursionError):
        raise ValueError(f"{short(path, 3)}: expected JSON, got something else") from None


def is_box(value: Any) -> bool:
    """Return whether a value is four numbers with a width and height >= 0."""
    return isinstance(value, list) and len(value) == 4 and all(map(_is_number, value)) and min(value[2:]) >= 0


def _entries(file: Path, content: Entry, name: str, needed: Mapping[str, Callable[[Any], bool]]) -> list[Entry]:
    """Return the entries of a list, none without it. Raises ValueError for one that lacks what is ``needed``."""
    entries = content.get(name, [])
    for number, each in enumerate(entries if isinstance(entries, list) else [entries], start=1):
        good = isinstance(each, dict) and all(fits(each.get(key)) for key, fits in needed.items())
        check(f"{short(file, 3)}, {name}, entry {number}", good, f"an entry with {', '.join(needed)}", repr(each)[:80])
    return list(entries)


def _row(where: str, entry: Any) -> tuple[int, int, int, list[float], float]:
    """Return image, category, track, box and score of a result. Raises ValueError if it is none."""
    check(where, isinstance(entry, dict), f"a result such as {_RESULT}", repr(entry)[:80])
    for name in ("image_id", "category_id"):
        check(where, _is_whole(entry.get(name)), f"a whole number as {name}", repr(entry.get(name))[:80])
    track_id = entry.get("track_id", NO_TRACK)
    known = track_id == NO_TRACK or (_is_whole(track_id) and track_id >= 0)
    check(where, known, "a whole number >= 0 as track_id, or none", repr(track_id)[:80])
    box, score = entry.get("bbox"), entry.get("score")
    check(where, is_box(box), f"{BOX} as bbox", repr(box)[:80])
    check(where, _is_number(score), "a number as score", repr(score)[:80])
    return int(entry["image_id"]), int(entry["category_id"]), int(track_id), box, float(score)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 2.0**53


def _is_whole(value: Any) -> bool:
    return _is_number(value) and value == int(value)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


_IMAGE = {"id": _is_whole, "file_name": _is_text, "video_id": lambda value: value is None or _is_whole(value)}
_VIDEO = {"id": _is_whole, "name": _is_text}
_ANNOTATION = {"image_id": _is_whole, "bbox": lambda value: isinstance(value, list)}
"""Field → whether a value fits."""
