"""YOLO as our export writes it: ``images/val/NAME_000000.png …``, ``labels/val/NAME_000000.txt``, ``objects.csv``.

https://docs.ultralytics.com/datasets/: a line is class, centre, width and height, or class and the points of an outline
(``yolo-seg``, ``yolo-obb``), about which the box is then, all as shares of the picture. YOLO has no sequences and
tracks. Here pictures whose names differ in the last number are a sequence, and ``objects.csv`` (``file``, ``line``,
``name`` …), which only our export writes, says whose each line is. One target of each sequence is followed by its name,
see ``layouts.followed``. The box is that of the pixels that are seen; without one the target is not seen, and no file
says why.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.data.box_files import numbers_of, text_lines
from benchmarks.data.layouts.followed import followed
from benchmarks.data.layouts.layout import Source, Target, layout
from benchmarks.data.pictures import pictures_in, read_picture, short, visible
from benchmarks.data.sequences import Labelled
from sim.checks import check

_OBJECTS = "objects.csv"
_OF_BOX, _OF_LEAST_OUTLINE = 5, 7
_LINE = "class and x, y, width, height, or three and more points, as shares of the picture"


@layout("yolo", "objects.csv, as our export writes it, beside images/ and labels/")
def find_yolo(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    file = path / _OBJECTS
    for folder in visible(path / "images", "*") if file.is_file() else ():
        sequences: dict[str, list[Path]] = {}
        for picture in pictures_in(folder):
            sequences.setdefault(picture.stem.rpartition("_")[0], []).append(picture)
        for name, pictures in sequences.items():
            yield Source(name, (folder, file), partial(_read, name, path, pictures))


def _read(name: str, root: Path, pictures: list[Path], target: Target) -> Labelled:
    objects = _objects(root / _OBJECTS)
    files = [f"labels/{picture.parent.name}/{picture.stem}.txt" for picture in pictures]
    mine = objects[objects["file"].isin(files)]
    chosen, own = followed(target, root / _OBJECTS, mine["name"].tolist())
    lines = dict(zip(mine["file"].iloc[own], mine["line"].iloc[own], strict=True))
    check(short(root / _OBJECTS), len(lines) == len(own), f"one line a picture of {chosen}", "two")
    height, width = read_picture(pictures[0]).shape[:2]
    boxes = np.full((len(pictures), 4), np.nan)
    for k, file in enumerate(files):
        if file in lines:
            boxes[k] = _corners(root / file, int(lines[file])) * (width, height, width, height)
    return Labelled(f"{name}-{chosen}", root / _OBJECTS, pictures, boxes)


def _objects(file: Path) -> pd.DataFrame:
    try:
        table = pd.read_csv(file, dtype={"file": str, "name": str, "line": "int64"})
    except ValueError as error:  # Those of pandas are ValueErrors; a broken row is named in them.
        raise ValueError(f"{short(file)}: expected a table, got {str(error).splitlines()[0]}") from None
    lacks = [name for name in ("file", "line", "name") if name not in table]
    check(short(file), not lacks, "columns file, line and name", f"none called {', '.join(lacks)}")
    return table


def _corners(file: Path, number: int) -> NDArray[np.float64]:
    """Return the box (4,) of a line, as shares. Raises ValueError, which names file and line, if it is none."""
    lines = text_lines(file) if file.is_file() else []
    text = lines[number - 1] if 0 < number <= len(lines) else ""
    numbers = np.array(numbers_of(text))
    count, places = len(numbers), numbers[1:]
    is_box = count == _OF_BOX and places.min() >= 0 and places.max() <= 1 and places[2:].min() > 0
    is_outline = count >= _OF_LEAST_OUTLINE and count % 2 == 1
    check(f"{short(file)}, line {number}", bool(is_box or is_outline), _LINE, repr(text[:80]))
    if is_box:
        return np.concatenate([places[:2] - 0.5 * places[2:], places[:2] + 0.5 * places[2:]])
    points = places.reshape(-1, 2)
    return np.concatenate([points.min(axis=0), points.max(axis=0)])
