"""JSON of COCO and TAO: pictures and results. Boxes are left, top, width, height; the picture begins at 0, 0.

* Results are a list of ``{"image_id", "category_id", "bbox", "score"}``, in TAO with ``"track_id"`` (and
  ``"video_id"``, which says nothing new): https://cocodataset.org/#format-results, and
  https://github.com/TAO-Dataset/tao/blob/master/docs/evaluation.md.
* Files of annotations name the pictures, ``"images": [{"id", "file_name", …}]``, and the ``"categories"``:
  https://cocodataset.org/#format-data.
"""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.pictures import short
from sim.checks import check

NO_TRACK = -1
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
class Pictures:
    """What a file of annotations says of pictures.

    Attributes:
        file_names: number of a picture → its path. categories: number → name.
    """

    file_names: dict[int, str]
    categories: dict[int, str]

    @cached_property
    def folders(self) -> dict[str, dict[str, int]]:
        """Name of a folder → name of a picture in it → its number."""
        found = defaultdict[str, dict[str, int]](dict)
        for number, file in self.file_names.items():
            *above, name = PurePosixPath(file).parts or ("",)
            found[above[-1] if above else ""][name] = number
        return found


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


def read_pictures(path: Path) -> Pictures:
    """Return the pictures of a file of annotations. Raises ValueError for a file of another kind."""
    where, content = short(path, 3), read_json(path)
    images = content.get("images") if isinstance(content, dict) else None
    wanted = 'annotations with "images": [{"id": 1, "file_name": "NAME/000000.png"}, …]'
    check(where, isinstance(images, list), wanted, f"a {type(content).__name__} without them")
    file_names: dict[int, str] = {}
    for number, each in enumerate(images or [], start=1):
        good = isinstance(each, dict) and _is_whole(each.get("id")) and isinstance(each.get("file_name"), str)
        check(f"{where}, image {number}", good, wanted, repr(each)[:80])
        file_names[int(each["id"])] = each["file_name"]
    named = (each for each in content.get("categories", []) if isinstance(each, dict) and _is_whole(each.get("id")))
    return Pictures(file_names, {int(each["id"]): str(each.get("name", each["id"])) for each in named})


def read_json(path: Path) -> Any:
    """Return the content of a JSON file. Raises ValueError, which names file and line, for one that is none."""
    where = short(path, 3)
    try:
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except json.JSONDecodeError as error:
        raise ValueError(f"{where}, line {error.lineno}: expected JSON, got {error.msg}") from None
    except (UnicodeDecodeError, RecursionError):
        raise ValueError(f"{where}: expected JSON, got something else") from None


def _row(where: str, entry: Any) -> tuple[int, int, int, list[float], float]:
    """Return image, category, track, box and score of a result. Raises ValueError if it is none."""
    check(where, isinstance(entry, dict), f"a result such as {_RESULT}", repr(entry)[:80])
    for name in ("image_id", "category_id"):
        check(where, _is_whole(entry.get(name)), f"a whole number as {name}", repr(entry.get(name))[:80])
    track_id = entry.get("track_id", NO_TRACK)
    known = track_id == NO_TRACK or (_is_whole(track_id) and track_id >= 0)
    check(where, known, "a whole number >= 0 as track_id, or none", repr(track_id)[:80])
    box, score = entry.get("bbox"), entry.get("score")
    is_box = isinstance(box, list) and len(box) == 4 and all(map(_is_number, box)) and min(box[2:]) >= 0
    check(where, is_box, "left, top, width, height as bbox, with a width and height >= 0", repr(box)[:80])
    check(where, _is_number(score), "a number as score", repr(score)[:80])
    return int(entry["image_id"]), int(entry["category_id"]), int(track_id), box, float(score)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 2.0**53


def _is_whole(value: Any) -> bool:
    return _is_number(value) and value == int(value)
