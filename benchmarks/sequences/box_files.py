"""Text files of boxes: one line a frame, ``left top width height``, separated by comma, tab or spaces."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.sequences.sequence import short
from sim.checks import check

_BETWEEN = re.compile(r"\s*[,;]\s*|\s+")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?nan", re.IGNORECASE)
_BOX = "left,top,width,height with a width and height above 0, or NaN,NaN,NaN,NaN"


def read_rows(path: Path, columns: tuple[int, ...], what: str) -> NDArray[np.float64]:
    """Return the numbers of a text file (R, C), a row for each line; empty lines at its end are left out.

    A file may mix separators (OTB's BlurCar1 does), begin with a byte-order mark and have lines of Windows.

    Args:
        columns: the numbers of columns that are expected. what: a line, in words.

    Raises:
        ValueError: for a file that is no text or empty, and a line that has other columns or is empty.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        got = error.strerror if isinstance(error, OSError) else "bytes that are none"
        raise ValueError(f"{short(path)}: expected text with numbers, got {got}") from None
    while lines and not lines[-1].strip():
        lines.pop()
    check(short(path), bool(lines), f"lines of {what}", "an empty file")
    rows = [_numbers(path, number, line, columns, what) for number, line in enumerate(lines, start=1)]
    for number, row in enumerate(rows, start=1):
        wanted = f"{len(rows[0])} numbers as in line 1"
        check(f"{short(path)}, line {number}", len(row) == len(rows[0]), wanted, len(row))
    return np.array(rows)


def read_boxes(path: Path) -> NDArray[np.float64]:
    """Return the boxes of a file (F, 4): left, top, width, height; NaN for NaN and for 0,0,0,0: no box.

    Raises:
        ValueError: as ``read_rows``, and for a box without a width or height above 0.
    """
    return checked_boxes(path, read_rows(path, (4,), "left,top,width,height"))


def checked_boxes(path: Path, box_xywh: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return boxes (F, 4), of which each line has one, with NaN for none. Raises ValueError for an impossible one."""
    boxes = np.where((box_xywh == 0.0).all(axis=1, keepdims=True), np.nan, box_xywh)
    none = np.isnan(boxes).all(axis=1)
    good = none | (np.isfinite(boxes).all(axis=1) & (boxes[:, 2] > 0) & (boxes[:, 3] > 0))
    if not good.all():
        line = int(np.argmin(good))
        got = ",".join(f"{number:g}" for number in box_xywh[line])
        raise ValueError(f"{short(path)}, line {line + 1}: expected {_BOX}, got {got}")
    return boxes


def _numbers(path: Path, number: int, line: str, columns: tuple[int, ...], what: str) -> list[float]:
    cells = _BETWEEN.split(line.strip())
    good = len(cells) in columns and all(map(_NUMBER.fullmatch, cells))
    check(f"{short(path)}, line {number}", good, what, repr(line[:80]))
    return [float(cell) for cell in cells]
