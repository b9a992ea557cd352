"""LaSOT: ``CLASS/NAME/img/00000001.jpg …`` and ``CLASS/NAME/groundtruth.txt``, a line ``x,y,w,h`` a picture.

Fan et al., LaSOT: a high-quality benchmark for large-scale single object tracking, CVPR 2019, and its toolkit,
https://github.com/HengLan/LaSOT_Evaluation_Toolkit. ``full_occlusion.txt`` and ``out_of_view.txt`` beside the boxes
hold one line each with 0 or 1 for every picture. Where one of them is 1 the box is arbitrary, and the toolkit leaves
the picture out: here the target is hidden or outside then, without a box. A box without area that neither file explains
(issue 19 of the toolkit) is none. Of ``monkey-17`` the first 2,260 pictures count. The top left corner of the picture
is at 1, 1: files do not tell, and the toolkit is that of OTB (MATLAB).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.data.box_files import corners_of, lines_to_the_last, numbers_of, read_flags
from benchmarks.data.layouts.layout import Source, Target, check_one_target, folders_with, layout
from benchmarks.data.pictures import numbered_pictures, short
from benchmarks.data.sequences import OCCLUDED, OUT, Labelled
from sim.checks import check

FIRST = 1.0
_COUNTS = {"monkey-17": 2260}
"""Sequence → number of pictures that count."""


@layout("lasot", "NAME/groundtruth.txt beside NAME/img/, in the folder or in CLASS/")
def find_lasot(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for folder in folders_with(path, "groundtruth.txt"):
        pictures = folder / "img"
        if pictures.is_dir():
            yield Source(folder.name, (pictures, folder / "groundtruth.txt"), partial(_read, folder))


def _read(folder: Path, target: Target) -> Labelled:
    check_one_target(target)
    file = folder / "groundtruth.txt"
    pictures = list(numbered_pictures(folder / "img").values())[: _COUNTS.get(folder.name)]
    rows = []
    for number, line in enumerate(lines_to_the_last(file)[: _COUNTS.get(folder.name)], start=1):
        numbers = numbers_of(line)
        check(f"{short(file)}, line {number}", len(numbers) == 4, "x,y,w,h", repr(line[:80]))
        rows.append(numbers)
    box_xywh = np.array(rows).reshape(-1, 4)
    check(short(file), len(box_xywh) == len(pictures), f"{len(pictures)} boxes, one a picture", len(box_xywh))
    hidden, outside = (read_flags(folder / f"{name}.txt", len(pictures)) for name in ("full_occlusion", "out_of_view"))
    tags = np.select([outside == 1, hidden == 1], [OUT, OCCLUDED], "")
    unknown = ~np.isfinite(box_xywh).all(axis=1) | (box_xywh[:, 2:] <= 0).any(axis=1)
    box_xywh = np.where((unknown | (tags != ""))[:, None], np.nan, box_xywh)
    strange = int((unknown & (tags == "")).sum())
    notes = (f"{short(file)}: {strange} boxes without area, which no file explains: not seen",) if strange else ()
    return Labelled(folder.name, file, pictures, corners_of(box_xywh, FIRST), tags, notes=notes)
