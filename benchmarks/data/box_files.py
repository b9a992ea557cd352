"""Text files of boxes, one line a frame, or one line a frame and target; and of flags and properties.

A line is ``left top width height``, separated by comma, tab or spaces. Data sets say in several ways that the target is
not seen, which all mean the same here: an empty line, a width or a height of 0, ``-1,-1,-1,-1``, and four numbers that
are NaN or infinite.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.pictures import short
from sim.checks import check

_LINE = "left,top,width,height"
_KEYED = "(in UAVDT also with frame,id before and 3 or 4 numbers after them)"
_COLUMNS = (4, 9, 10)
BETWEEN = re.compile(r"\s*[,;]\s*|\s+")
"""What stands between the numbers of a line."""
_BOX = "left,top,width,height with a width and height above 0, or NaN,NaN,NaN,NaN"


def text_lines(path: Path) -> list[str]:
    """Return the lines of a text file, without a byte-order mark. Raises ValueError for a file that is no text."""
    try:
        return path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"{short(path, 3)}: expected text with numbers, got bytes that are none") from None


def lines_to_the_last(path: Path) -> list[str]:
    """Return the lines of ``text_lines`` up to the last one that is not blank."""
    lines = text_lines(path)
    while lines and not lines[-1].strip():
        lines.pop()
    return lines


def numbers_of(line: str) -> list[float]:
    """Return the numbers of a line, none if a cell is no number."""
    try:
        return [float(cell) for cell in BETWEEN.split(line.strip())]
    except ValueError:
        return []


def is_whole(number: float, least: float = 0) -> bool:
    """Return whether a number is a whole one that can count something, from ``least`` on."""
    return bool(least <= number < 2**53 and number == int(number))


def read_boxes(path: Path, frames: int = 0, *, keyed: bool = True) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return frames and ids (R, 2) of a text file, or (R, 0) if it has none, and its boxes (R, 4).

    A box is left, top, width, height; NaN where the target is not seen. An empty line is no box; those at the end are
    left out, but for those that make up ``frames`` lines, the pictures of the sequence. A file may mix separators
    (OTB's BlurCar1 does), begin with a byte-order mark and have lines of Windows.

    Args:
        keyed: whether lines with frame and id, as of UAVDT, are taken too.

    Raises:
        ValueError: for a file that is no text or empty, a line that has other columns, a frame or id that is no whole
            number, and a box with a negative size or with numbers that are half unknown.
    """
    lines = text_lines(path)
    last = max((number for number, line in enumerate(lines, start=1) if line.strip()), default=0)
    expected, columns = (f"{_LINE} {_KEYED}", _COLUMNS) if keyed else (_LINE, _COLUMNS[:1])
    check(short(path), last > 0, f"lines of {expected}", "an empty file")
    read: list[list[float]] = []
    for number, line in enumerate(lines[: frames if last < frames <= len(lines) else last], start=1):
        numbers = numbers_of(line) if line.strip() else [np.nan] * 4
        good = len(numbers) in ({len(read[0])} if read else columns)
        good = good and (len(numbers) == len(_LINE.split(",")) or all(map(is_whole, numbers[:2])))
        check(f"{short(path)}, line {number}", good, expected, repr(line[:80]))
        read.append(numbers)
    rows = np.array(read)
    keys, box_xywh = (rows[:, :0], rows) if rows.shape[1] == 4 else (rows[:, :2], rows[:, 2:6])
    return keys, _known_boxes(box_xywh, path)


def read_flags(path: Path, count: int, *, most: int = 1, usual: int = 0) -> NDArray[np.int64]:
    """Return the whole numbers (``count``,) from 0 to ``most`` of a file, one a picture; the usual one without a file.

    They stand in lines, or in one line (LaSOT), with commas or spaces between them.

    Raises:
        ValueError: for another number of them, and for what is no such number; names file and line.
    """
    if not path.is_file():
        return np.full(count, usual)
    wanted = "0 or 1, one a picture" if most == 1 else f"whole numbers from 0 to {most}, one a picture"
    found: list[float] = []
    for number, line in enumerate(text_lines(path), start=1):
        numbers = numbers_of(line) if line.strip() else []
        good = all(each in range(most + 1) for each in numbers) and bool(numbers or not line.strip())
        check(f"{short(path)}, line {number}", good, wanted, repr(line[:80]))
        found += numbers
    check(short(path), len(found) == count, f"{count} numbers, one a picture", len(found))
    return np.array(found, np.int64)


def read_properties(path: Path) -> dict[str, str]:
    """Return the lines ``name=value`` or ``name: value`` of a file, without headings and comments; none without a file.

    Raises:
        ValueError: for a line that is none; names file and line.
    """
    found: dict[str, str] = {}
    for number, line in enumerate(text_lines(path) if path.is_file() else [], start=1):
        if line.strip() and not line.startswith(("[", "#", ";")):
            parts = re.split(r"\s*[=:]\s*", line.strip(), maxsplit=1)
            check(f"{short(path)}, line {number}", len(parts) == 2, "name=value", repr(line[:80]))
            found[parts[0]] = parts[1]
    return found


def rate_of(text: str) -> float:
    """Return the frames a second that a file tells, e.g. ``30`` or ``10Hz``; 0 for none."""
    match = re.match(r"\d+(\.\d+)?", text)
    return float(match[0]) if match else 0.0


def corners_of(box_xywh: NDArray[np.float64], first: float) -> NDArray[np.float64]:
    """Return boxes (F, 4) as x_min, y_min, x_max, y_max from left, top, width, height.

    Args:
        first: coordinate of the top left corner of the picture.
    """
    corner = box_xywh[:, :2] - first
    return np.concatenate([corner, corner + box_xywh[:, 2:]], axis=1)


def _known_boxes(box_xywh: NDArray[np.float64], path: Path) -> NDArray[np.float64]:
    """Return the boxes (R, 4) of lines with NaN for each of the ways to say that there is none.

    Raises:
        ValueError: for a box with a negative size or with numbers that are half unknown; names file and line.
    """
    none = ~np.isfinite(box_xywh).any(axis=1) | (box_xywh[:, 2:] == 0).any(axis=1) | (box_xywh == -1).all(axis=1)
    good = none | (np.isfinite(box_xywh).all(axis=1) & (box_xywh[:, 2:] > 0).all(axis=1))
    if not good.all():
        first = int(np.argmin(good))
        got = ",".join(f"{number:g}" for number in box_xywh[first])
        raise ValueError(f"{short(path)}, line {first + 1}: expected {_BOX}, got {got}")
    return np.where(none[:, None], np.nan, box_xywh)
