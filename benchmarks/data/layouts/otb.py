"""OTB: ``NAME/img/0001.jpg …`` and ``NAME/groundtruth_rect.txt``, a line a picture.

Wu, Lim, Yang, Object tracking benchmark, TPAMI 2015, http://cvlab.hanyang.ac.kr/tracker_benchmark/datasets.html.
Pictures may begin at another number than 1; the top left corner of the picture is at 1, 1 (MATLAB). A folder with two
targets has ``groundtruth_rect.1.txt`` and ``.2.txt``: the sequences ``NAME-1`` and ``NAME-2``, as the benchmark calls
them. Empty ones are left out (Human4 has one). Files of five sequences have boxes of a part of the pictures, which the
benchmark's page names, ``PARTS``. OTB has a box in every picture; NaN for none is UAV123's, and that of ``export
--format otb``, which adds ``out_of_view.txt`` and ``occlusion.txt``, a line with 0 or 1 a picture: why there is no box,
and where the target is hidden in part. Its boxes reach beyond the border.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.data.box_files import corners_of, read_boxes, read_flags
from benchmarks.data.layouts.followed import of_one_target
from benchmarks.data.layouts.layout import Source, Target, check_one_target, layout
from benchmarks.data.pictures import numbered_pictures, short
from benchmarks.data.sequences import OCCLUDED, OUT, Labelled
from sim.checks import check

FIRST = 1.0
"""Coordinate of the top left corner of the picture in what was made with MATLAB."""
_BOXES = "groundtruth_rect*.txt"
PARTS = {"David": (300, 770), "Diving": (1, 215), "Football1": (1, 74), "Freeman3": (1, 460), "Freeman4": (1, 283)}
"""Sequence → numbers of the first and the last picture that its boxes belong to."""


@layout("otb", "groundtruth_rect.txt, or folders that hold one")
def find_otb(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for file in (*path.glob(_BOXES), *path.glob(f"*/{_BOXES}")):
        folder, target = file.parent, file.stem.removeprefix("groundtruth_rect").strip(".")
        if not target or file.read_bytes().strip():
            name, pictures = f"{folder.name}-{target}" if target else folder.name, folder / "img"
            yield Source(name, (pictures, file), partial(_read, name, pictures, file))


def _read(name: str, pictures: Path, file: Path, target: Target) -> Labelled:
    read = read_one_a_line(name, pictures, file, PARTS.get(file.parent.name), target)
    outside, occluded = (file.parent / f"{each}.txt" for each in ("out_of_view", "occlusion"))
    if not outside.is_file():
        return read
    count = len(read.pictures)
    flags = [read_flags(each, count) == 1 for each in (outside, occluded)]
    return replace(read, tags=np.select(flags, [OUT, OCCLUDED], ""), whole=True)


def read_one_a_line(
    name: str, folder: Path, file: Path, part: tuple[int, int] | None, target: Target, *, else_where: str = ""
) -> Labelled:
    """Return what a file with a box a line, or a line a frame and target, says of a target in a folder of pictures.

    Args:
        folder: of the pictures. file: of the boxes.
        part: numbers of the first and the last picture that the boxes belong to, if they are not one for each picture.
        target: see ``Target``.
        else_where: where else the pictures may be, for a message.

    Raises:
        ValueError: see ``Source``.
    """
    check(short(file), folder.is_dir(), f"pictures in {short(folder, 3)}{else_where}", "no such folder")
    pictures = numbered_pictures(folder)
    keys, box_xywh = read_boxes(file, len(pictures))
    boxes = corners_of(box_xywh, FIRST)
    if keys.size:
        (frames, ids), lines = keys.astype(np.int64).T, np.arange(1, len(keys) + 1)
        return of_one_target(name, file, pictures, target, frames, ids, lines, boxes)
    check_one_target(target)
    if part is not None and len(boxes) != len(pictures):
        first, last = part
        pictures = {number: picture for number, picture in pictures.items() if first <= number <= last}
    return Labelled(name, file, list(pictures.values()), boxes)
