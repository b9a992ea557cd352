"""Sequences of a folder of pictures and a file with a box a line, or a line a frame and target."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.contract.text import printable
from benchmarks.data.box_files import read_boxes
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
    name = printable(name)
    keys, boxes = read_boxes(file, len(pictures))
    if keys.size:
        followed, boxes = boxes_of(target, file, keys, boxes, list(pictures))
        name = f"{name}-{followed}"
    else:
        check_one_target(target)
        if part is not None and len(boxes) != len(pictures):
            first, last = part
            pictures = {number: picture for number, picture in pictures.items() if first <= number <= last}
    return Labelled(name, file, list(pictures.values()), boxes, FIRST)


def boxes_of(
    target: Target, file: Path, keys: NDArray[np.float64], boxes: NDArray[np.float64], frames: list[int]
) -> tuple[str, NDArray[np.float64]]:
    """Return the id of the target that is followed, and its boxes (F, 4) in the ``frames``; NaN where it has no line.

    Args:
        keys: (R, 2) frame and id. boxes: (R, 4).

    Raises:
        ValueError: for lines of frames of which there is no picture, an unknown target, and two lines of one frame.
    """
    numbers, ids = keys.T
    unknown = numbers[~np.isin(numbers, frames)]
    wanted = f"frames from {frames[0]} to {frames[-1]}, of which there are pictures"
    check(short(file), not unknown.size, wanted, ", ".join(f"{each:g}" for each in unknown[:1]))
    known, lines = np.unique(ids, return_counts=True)
    names = [f"{each:g}" for each in known]
    followed = names[int(np.argmax(lines))] if target is None else str(target)
    check("target", followed in names, f"an id in {short(file)}: {', '.join(names[:10])}", target)
    mine = ids == known[names.index(followed)]
    track = pd.DataFrame(boxes[mine], index=numbers[mine])
    check(short(file), track.index.is_unique, f"one line a frame of id {followed}", "two of one frame")
    return followed, track.reindex(frames).to_numpy()
