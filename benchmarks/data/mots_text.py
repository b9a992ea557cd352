"""Text of MOTS: a row for each object and frame, of truth and of results.

``frame identity class height width counts``, with spaces between them; ``counts`` are the run lengths of a mask of the
picture as COCO writes them, column by column. Frames are counted from 0 in KITTI MOTS and from 1 in MOTS Challenge.
Class 10 stands for what is not annotated. Masks of a frame do not overlap.

Source: https://www.vision.rwth-aachen.de/page/mots (Voigtlaender et al., MOTS, CVPR 2019).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.box_files import corners_of, numbers_of, text_lines
from benchmarks.data.pictures import short
from benchmarks.run.packages import check_packages
from sim.checks import check
from trackers.regions import MOST_PIXELS

IGNORED = 10
"""Class of what is not annotated."""
_CELLS = 6
_ROW = "frame identity class height width counts, where the counts are a mask of that height and width"


@dataclass(frozen=True, eq=False)
class MotsRows:
    """R rows of a file.

    Attributes:
        frame: (R,) numbers of frames, as they stand. identity: (R,) >= 0. kind: (R,) numbers of classes.
        runs: (R,) of each the size (height, width) and the counts, see ``codec.mask_of``.
        line: (R,) number in the file, from 1 on.
    """

    frame: NDArray[np.int64]
    identity: NDArray[np.int64]
    kind: NDArray[np.int64]
    runs: list[dict[str, Any]]
    line: NDArray[np.int64]

    @property
    def box_xyxy(self) -> NDArray[np.float64]:
        """(R, 4) pixels, around the masks; without area of an empty one."""
        from pycocotools.mask import toBbox

        return corners_of(np.array(toBbox(self.runs), float).reshape(-1, 4), 0.0)

    def mask(self, row: int) -> NDArray[np.bool_]:
        """Return the mask (H, W) of a row."""
        from benchmarks.data.codec import mask_of

        return mask_of(self.runs[row])


def has_masks(path: Path) -> bool:
    """Return whether a file has rows of MOTS: six values, of which the last one is no number in some row.

    Counts may look like a number, but not all. A file that is no text has none.
    """
    try:
        rows = [line.split() for line in text_lines(path)[:100] if line.strip()]
    except ValueError:
        return False
    whole = [row for row in rows if len(row) == _CELLS]
    return whole[:1] == rows[:1] and not all(numbers_of(row[-1]) for row in whole)


def read_mots(path: Path) -> MotsRows:
    """Return the rows of a file, maybe none.

    Raises:
        ValueError: if a package of the extra is missing; for a file that is no text, a row of other columns or with
            counts that are no mask of its size, and an identity twice in a frame; names file and line.
    """
    check_packages(("pyarrow", "pycocotools"), "data")
    where = short(path, 3)
    numbers, line = [], []
    runs = list[dict[str, Any]]()
    known = set[tuple[int, int]]()
    for k, text in enumerate(text_lines(path), start=1):
        cells = text.split()
        if not cells:
            continue
        good = len(cells) == _CELLS and all(cell.isascii() and cell.isdigit() and len(cell) < 16 for cell in cells[:5])
        frame, identity, kind, height, width = map(int, cells[:5]) if good else (0, 0, 0, 0, 0)
        good = good and 0 < height * width <= MOST_PIXELS and runs_fill(cells[5], height * width)
        check(f"{where}, line {k}", good, _ROW, repr(text[:80]))
        once = (frame, identity) not in known
        check(f"{where}, line {k}", once, "each identity once in a frame", f"{identity} in frame {frame} again")
        known.add((frame, identity))
        numbers.append((frame, identity, kind))
        runs.append({"size": [height, width], "counts": cells[5]})
        line.append(k)
    columns = np.array(numbers, np.int64).reshape(-1, 3)
    return MotsRows(columns[:, 0], columns[:, 1], columns[:, 2], runs, np.array(line, np.int64))


def runs_fill(counts: str, pixels: int) -> bool:
    """Return whether COCO's counts are run lengths of so many pixels; pycocotools does not look.

    Source: ``rleFrString`` in https://github.com/cocodataset/cocoapi/blob/master/common/maskApi.c: five bits a
    character from the lowest on, of which 32 says that more follow and 16 of the last one is the sign; from the fourth
    run on a count is the difference to that two before.
    """
    runs, value, shift = list[int](), 0, 0
    for character in counts:
        code = ord(character) - 48
        if not 0 <= code < 64:
            return False
        value |= (code & 31) << shift
        shift += 5
        if code & 32:
            continue
        if code & 16:
            value -= 1 << shift
        runs.append(value + (runs[-2] if len(runs) > 2 else 0))
        value, shift = 0, 0
    return shift == 0 and min(runs, default=-1) >= 0 and sum(runs) == pixels
