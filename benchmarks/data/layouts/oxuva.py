"""OxUvA: ``images/dev/VIDEO/000000.jpeg …`` and ``annotations/dev.csv``, a row a labelled picture.

Valmadre et al., Long-term tracking in the wild: a benchmark, ECCV 2018, and the README and ``oxuva/io_annot.py`` of
https://github.com/oxuva/long-term-tracking-benchmark. A row has no heading: ``video_id, object_id, class_id,
class_name, contains_cuts, always_visible, frame_num, object_presence, xmin, xmax, ymin, ymax``. Each target is a
sequence of its own, ``VIDEO-OBJECT``, from its first label to its last. One picture a second is labelled (every 30th)
``present`` or ``absent``; the others are shown to trackers and not scored. Why the target is absent is not told. Boxes
are shares of the picture's width and height, 0 to 1, which do not reach beyond its border.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.data.box_files import is_whole, lines_to_the_last
from benchmarks.data.layouts.followed import in_pictures
from benchmarks.data.layouts.layout import Source, Target, check_one_target, layout
from benchmarks.data.pictures import numbered_pictures, read_picture, short, visible
from benchmarks.data.sequences import UNLABELLED, UNSEEN, Labelled
from sim.checks import check

_COLUMNS = 12
_ROW = "12 values, VIDEO, OBJECT, … frame, present or absent, xmin, xmax, ymin, ymax as shares of the picture"


@layout("oxuva", "annotations/dev.csv beside images/dev/VIDEO/")
def find_oxuva(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for file in visible(path / "annotations", "*.csv"):
        root, rows = path / "images" / file.stem, dict[tuple[str, str], list[tuple[int, list[str]]]]()
        if root.is_dir():
            for number, line in enumerate(lines_to_the_last(file), start=1):
                cells = [cell.strip() for cell in line.split(",")]
                rows.setdefault((cells[0], cells[min(1, len(cells) - 1)]), []).append((number, cells))
        for (video, each), mine in rows.items():
            name = f"{video}-{each}"
            yield Source(name, (root / video, file), partial(_read, name, root / video, file, mine))


def _read(name: str, folder: Path, file: Path, rows: list[tuple[int, list[str]]], target: Target) -> Labelled:
    check_one_target(target)
    labels = [_label(f"{short(file)}, line {number}", cells) for number, cells in rows]
    frames, lines = (np.array(each) for each in ([label[0] for label in labels], [number for number, _ in rows]))
    every = numbered_pictures(folder, gaps=True)
    pictures = {number: file for number, file in every.items() if frames.min() <= number <= frames.max()}
    check(short(folder), bool(pictures), f"pictures from {frames.min()} to {frames.max()}", "none")
    held, places, notes = in_pictures(file, frames, list(pictures), lines)
    height, width = read_picture(next(iter(pictures.values()))).shape[:2]
    boxes, tags = np.full((len(pictures), 4), np.nan), np.full(len(pictures), UNLABELLED)
    boxes[places] = np.array([labels[k][1] for k in held]).reshape(-1, 4) * (width, height, width, height)
    tags[places] = np.where(np.isnan(boxes[places, 0]), UNSEEN, "")
    place = np.array(list(pictures))
    return Labelled(name, file, list(pictures.values()), boxes, tags, place=place, notes=notes)


def _label(where: str, cells: list[str]) -> tuple[int, list[float]]:
    """Return frame and box of a row, NaN where the target is absent. Raises ValueError for another row."""
    present = cells[7] if len(cells) == _COLUMNS else ""
    box = [np.nan] * 4
    try:
        frame = int(cells[6]) if present in ("present", "absent") else -1
        if present == "present":
            x_min, x_max, y_min, y_max = map(float, cells[8:])
            box = [x_min, y_min, x_max, y_max]
            frame = frame if 0 <= x_min < x_max <= 1 and 0 <= y_min < y_max <= 1 else -1
    except ValueError:
        frame = -1
    check(where, is_whole(frame), _ROW, repr(",".join(cells)[:120]))
    return frame, box
