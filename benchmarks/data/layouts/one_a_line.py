"""Sequences of a folder of pictures and a file with a box a line, or a line a frame and target."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.data.box_files import corners_of, read_boxes
from benchmarks.data.layouts.followed import of_one_target
from benchmarks.data.layouts.layout import Target, check_one_target
from benchmarks.data.pictures import numbered_pictures, short
from benchmarks.data.sequences import Labelled
from sim.checks import check

FIRST = 1.0
"""Coordinate of the top left corner of the picture in what was made with MATLAB."""


def read_one_a_line(
    name: str, folder: Path, file: Path, part: tuple[int, int] | None, target: Target, *, else_where: str = ""
) -> Labelled:
    """Return what is said of a target.

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
