"""KITTI tracking: ``training/image_02/0000/000000.png …`` and ``training/label_02/0000.txt``.

Geiger, Lenz, Urtasun, Are we ready for autonomous driving?, CVPR 2012; the readme of the tracking devkit,
https://www.cvlibs.net/datasets/kitti/eval_tracking.php, which TrackEval keeps as ``docs/KITTI-format.txt``. A row is
``frame id type truncated occluded alpha left top right bottom`` and seven numbers in metres and radians. Frames are
counted from 0; pictures may be missing (four of sequence 0001 are). Rows ``DontCare`` are regions, no targets. One
target of the others is followed, see ``layouts.followed``. ``truncated`` > 0: the border cuts it, where the box ends;
``occluded`` 2: largely hidden. Pixel centres have whole coordinates, so the top left corner of the picture is at -0.5,
-0.5. The camera takes 10 pictures a second.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.data.box_files import is_whole, text_lines
from benchmarks.data.layouts.followed import of_one_target
from benchmarks.data.layouts.layout import Source, Target, layout
from benchmarks.data.mots_text import has_masks
from benchmarks.data.pictures import numbered_pictures, short, visible
from benchmarks.data.sequences import OCCLUDED, PARTIAL, Labelled
from sim.checks import check

FIRST, RATE_HZ = -0.5, 10.0
_COLUMNS = 17
_ROW = "frame, id, type and 14 numbers, as KITTI's readme says"


@layout("kitti", "label_02/0000.txt beside image_02/0000/, in the folder or in training/")
def find_kitti(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for root in (path, path / "training"):
        for file in visible(root / "label_02", "*.txt"):
            pictures = root / "image_02" / file.stem
            if pictures.is_dir() and not has_masks(file):
                yield Source(file.stem, (pictures, file), partial(_read, pictures, file))


def _read(folder: Path, file: Path, target: Target) -> Labelled:
    pictures, rows, lines = numbered_pictures(folder, gaps=True), list[list[float]](), list[int]()
    for number, line in enumerate(text_lines(file), start=1):
        cells = line.split()
        if cells and (len(cells) < 3 or cells[2] != "DontCare"):
            row = _numbers(cells)
            check(f"{short(file)}, line {number}", len(row) > 0, _ROW, repr(line[:80]))
            rows.append(row)
            lines.append(number)
    table = np.array(rows).reshape(-1, _COLUMNS)
    frames, ids = table[:, :2].astype(np.int64).T
    tags = np.select([table[:, 3] > 0, table[:, 4] == 2], [PARTIAL, OCCLUDED], "")
    boxes = table[:, 6:10] - FIRST
    return of_one_target(file.stem, file, pictures, target, frames, ids, np.array(lines), boxes, tags, rate_hz=RATE_HZ)


def _numbers(cells: list[str]) -> list[float]:
    """Return the numbers of a row without its score, 0 for its type; none of a row that is no target's."""
    try:
        row = [float(cell) for cell in (*cells[:2], "0", *cells[3:])]
    except ValueError:
        return []
    good = len(row) in (_COLUMNS, _COLUMNS + 1) and np.isfinite(row).all() and is_whole(row[0]) and is_whole(row[1], -1)
    return row[:_COLUMNS] if good and row[8] > row[6] and row[9] > row[7] else []
