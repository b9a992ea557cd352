"""Text files of boxes: one line a frame, ``left top width height``, separated by comma, tab or spaces.

Data sets say in several ways that the target is not seen, which all mean the same here: an empty line, a width or a
height of 0, ``-1,-1,-1,-1``, and four numbers that are NaN or infinite.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sequences.sequence import short
from sim.checks import check

_BETWEEN = re.compile(r"\s*[,;]\s*|\s+")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf(inity)?)", re.IGNORECASE)
_BOX = "left,top,width,height with a width and height above 0, or NaN,NaN,NaN,NaN"
_BOX_NUMBERS = 4


def read_rows(path: Path, columns: tuple[int, ...], what: str, frames: int = 0) -> NDArray[np.float64]:
    """Return the numbers of a text file (R, C), a row for each line; an empty line among boxes is four NaN.

    Empty lines at its end are left out, but for those that make up ``frames`` lines. A file may mix separators (OTB's
    BlurCar1 does), begin with a byte-order mark and have lines of Windows.

    Args:
        columns: the numbers of columns that are expected. what: a line, in words. frames: of the sequence.

    Raises:
        ValueError: for a file that is no text or empty, and a line that has other columns or is empty.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        got = error.strerror if isinstance(error, OSError) else "bytes that are none"
        raise ValueError(f"{short(path)}: expected text with numbers, got {got}") from None
    told = max((number for number, line in enumerate(lines, start=1) if line.strip()), default=0)
    check(short(path), told > 0, f"lines of {what}", "an empty file")
    lines = lines[: frames if told < frames <= len(lines) else told]
    rows = [_numbers(path, number, line, columns, what) for number, line in enumerate(lines, start=1)]
    for number, row in enumerate(rows, start=1):
        wanted = f"{len(rows[0])} numbers as in line 1"
        check(f"{short(path)}, line {number}", len(row) == len(rows[0]), wanted, len(row))
    return np.array(rows)


def read_boxes(path: Path, frames: int = 0) -> NDArray[np.float64]:
    """Return the boxes of a file (F, 4): left, top, width, height; NaN where the target is not seen.

    Args:
        frames: of the sequence, see ``read_rows``.

    Raises:
        ValueError: as ``read_rows``, and for a box with a negative size or with numbers that are half unknown.
    """
    return checked_boxes(path, read_rows(path, (_BOX_NUMBERS,), "left,top,width,height", frames))


def checked_boxes(path: Path, box_xywh: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return boxes (F, 4), of which each line has one, with NaN for none. Raises ValueError for an impossible one."""
    none = ~np.isfinite(box_xywh).any(axis=1) | (box_xywh[:, 2:] == 0).any(axis=1) | (box_xywh == -1).all(axis=1)
    good = none | (np.isfinite(box_xywh).all(axis=1) & (box_xywh[:, 2:] > 0).all(axis=1))
    if not good.all():
        line = int(np.argmin(good))
        got = ",".join(f"{number:g}" for number in box_xywh[line])
        raise ValueError(f"{short(path)}, line {line + 1}: expected {_BOX}, got {got}")
    return np.where(none[:, None], np.nan, box_xywh)


def _numbers(path: Path, number: int, line: str, columns: tuple[int, ...], what: str) -> list[float]:
    if not line.strip() and _BOX_NUMBERS in columns:
        return [float("nan")] * _BOX_NUMBERS
    cells = _BETWEEN.split(line.strip())
    good = len(cells) in columns and all(map(_NUMBER.fullmatch, cells))
    check(f"{short(path)}, line {number}", good, what, repr(line[:80]))
    return [float(cell) for cell in cells]
