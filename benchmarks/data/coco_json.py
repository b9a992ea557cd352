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

from benchmarks.data.box_files import corners_of
from benchmarks.data.pictures import Picture, short
from benchmarks.data.read_once import read_once
from sim.checks import check

NO_TRACK = -1
Entry = dict[str, Any]
_Fields = Mapping[str, tuple[Callable[[Any], bool], str]]
"""Field → whether a value fits, and what does."""
BOX = "left, top, width, height with a width and height >= 0"
_EXAMPLE = '{"image_id": 1, "category_id": 1, "bbox": [left, top, width, height], "score": 0.9}'


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
        images: entries with ``id``, ``file_name`` (with slashes) and maybe ``video_id``.
        videos: entries with ``id`` and ``name``.
        content: all of the file.
    """

    file: Path
    images: list[Entry]
    videos: list[Entry]
    content: Entry

    @cached_property
    def categories(self) -> dict[int, str]:
        """Number → name. Raises ValueError for a category without a number; names it."""
        entries = _entries(self.file, self.content, "categories", {"id": _WHOLE})
        return {each["id"]: str(each.get("name", each["id"])) for each in entries}

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
        for each in _entries(self.file, self.content, "annotations", _ANNOTATION):
            found.setdefault(each["image_id"], []).append(each)
        return found


@read_once
def read_results(path: Path) -> Results:
    """Return the results of a file, maybe none.

    Raises:
        ValueError: for a file that is no JSON, or of another kind, and for an entry that is no result; names it.
    """
    content = read_json(path)
    check(short(path, 3), isinstance(content, list), f"a list of results such as {_EXAMPLE}", type(content).__name__)
    entries = _entries(path, {"": content}, "", _RESULT)
    numbers = np.array([[each.get(key, NO_TRACK) for key in _NUMBERS] for each in entries], np.int64).reshape(-1, 3)
    box_xywh = np.array([each["bbox"] for each in entries], float).reshape(-1, 4)
    score = np.array([each["score"] for each in entries], float)
    return Results(numbers[:, 0], numbers[:, 1], corners_of(box_xywh, 0.0), score, numbers[:, 2])


@read_once
def read_annotations(path: Path) -> Annotations | None:
    """Return what a file of annotations says; None of one that lists no pictures.

    Raises:
        ValueError: for a file that is no JSON, and an entry that lacks what is read; names it.
    """
    content = read_json(path)
    if not isinstance(content, dict) or not isinstance(content.get("images"), list):
        return None
    images = _entries(path, content, "images", _IMAGE)
    images = [each | {"file_name": each["file_name"].replace("\\", "/")} for each in images]
    videos = _entries(path, content, "videos", _VIDEO)
    return Annotations(path, images, videos, content)


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


def _entries(file: Path, content: Entry, name: str, fields: _Fields) -> list[Entry]:
    """Return the entries of a list, none without it. Raises ValueError for one with another field; names it."""
    where, entries = f"{short(file, 3)}, {name}".rstrip(", "), content.get(name, [])
    check(where, isinstance(entries, list), "a list", repr(entries)[:80])
    for number, each in enumerate(entries, start=1):
        check(f"{where}, entry {number}", isinstance(each, dict), f"an entry with {', '.join(fields)}", repr(each)[:80])
        for field, (fits, wanted) in fields.items():
            if (field in each or field not in _OPTIONAL) and not fits(each.get(field)):
                check(f"{where}, entry {number}", False, f"{wanted} as {field}", repr(each.get(field))[:80])
    return list(entries)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 2.0**53


def _is_whole(value: Any) -> bool:
    return _is_number(value) and value == int(value)


_WHOLE, _NUMBER = (_is_whole, "a whole number"), (_is_number, "a number")
_TEXT = (lambda value: isinstance(value, str), "a text")
_TRACK = (lambda value: _is_whole(value) and value >= NO_TRACK, "a whole number >= 0")
_BOX, _MAYBE_BOX = (is_box, BOX), (lambda value: value == [] or is_box(value), BOX)
_IMAGE: _Fields = {"id": _WHOLE, "file_name": _TEXT, "video_id": _WHOLE}
_VIDEO: _Fields = {"id": _WHOLE, "name": _TEXT}
_ANNOTATION: _Fields = {"image_id": _WHOLE, "bbox": _MAYBE_BOX, "visibility": _NUMBER}
_RESULT: _Fields = {"image_id": _WHOLE, "category_id": _WHOLE, "track_id": _TRACK, "bbox": _BOX, "score": _NUMBER}
_NUMBERS = ("image_id", "category_id", "track_id")
_OPTIONAL = ("video_id", "track_id", "visibility")
