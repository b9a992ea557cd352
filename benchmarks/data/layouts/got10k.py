"""GOT-10k: ``NAME/00000001.jpg …`` and, beside them, ``groundtruth.txt``, a line ``left,top,width,height`` a picture.

Huang, Zhao, Huang, GOT-10k: a large high-diversity benchmark for generic object tracking in the wild, TPAMI 2019, and
its toolkit, https://github.com/got-10k/toolkit. Sequences lie in ``train``, ``val`` or ``test``; only the first picture
of those of ``test`` has a box, and nothing can be scored on them. Beside the boxes stand, a line a picture:

* ``absence.label``: 1 where the target is absent, hidden wholly or outside the picture.
* ``cover.label``: how much of it is seen, 0 (nothing) to 8 (all but a tenth at most); up to 3 at most 45 %. The toolkit
  scores pictures with more than 0 alone, and so a box with 0 does not count here; the target is hidden then.
* ``cut_by_image.label``: 1 where the border cuts it.

``meta_info.ini`` tells ``anno_fps``, the rate of the pictures. The top left corner of the picture is at 1, 1: "all
coordinate values are 1-based", the toolkit's author says in its issue 6.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.data.box_files import corners_of, rate_of, read_boxes, read_flags, read_properties
from benchmarks.data.layouts.layout import Source, Target, check_one_target, folders_with, layout
from benchmarks.data.pictures import numbered_pictures
from benchmarks.data.sequences import OCCLUDED, PARTIAL, UNSEEN, Labelled

FIRST = 1.0
_HALF, _ALL = 3, 8
"""Levels of ``cover.label``: up to this one less than half is seen; all."""


@layout("got10k", "NAME/groundtruth.txt beside NAME/absence.label, in the folder or in train/ and val/")
def find_got10k(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for folder in folders_with(path, "absence.label"):
        file = folder / "groundtruth.txt"
        if file.is_file():
            yield Source(folder.name, (folder, file), partial(_read, folder))


def _read(folder: Path, target: Target) -> Labelled:
    check_one_target(target)
    file = folder / "groundtruth.txt"
    pictures = list(numbered_pictures(folder).values())
    _, box_xywh = read_boxes(file, len(pictures), keyed=False)
    absent, cut = (read_flags(folder / f"{name}.label", len(box_xywh)) for name in ("absence", "cut_by_image"))
    cover = read_flags(folder / "cover.label", len(box_xywh), most=_ALL, usual=_ALL)
    gone = (absent == 1) | (cover == 0)
    tags = np.select([absent == 1, cover == 0, cut == 1, cover <= _HALF], [UNSEEN, OCCLUDED, PARTIAL, OCCLUDED], "")
    boxes = corners_of(np.where(gone[:, None], np.nan, box_xywh), FIRST)
    rate_hz = rate_of(read_properties(folder / "meta_info.ini").get("anno_fps", ""))
    return Labelled(folder.name, file, pictures, boxes, tags, rate_hz=rate_hz)
