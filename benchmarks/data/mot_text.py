"""MOT Challenge's text: a row for each target and frame, of truth (``gt.txt``) and of results.

``frame,id,left,top,width,height`` and up to four more columns: of results confidence, x, y, z, where -1 stands for what
is not said; of truth whether the row counts (1 or 0), class and visibility. Frames and pixels are counted from 1: the
top left corner of the picture is 1, 1. Rows stand in any order, with comma, tab or spaces between their numbers.

Source: Milan et al., MOT16, https://arxiv.org/abs/1603.00831, section 4, and https://motchallenge.net/instructions. As
TrackEval does, an identity that stands twice in a frame is refused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.box_files import corners_of, numbers_of, rate_of, text_lines
from benchmarks.data.pictures import short
from sim.checks import check
from trackers.types import Answer, Estimate, Track

FIRST = 1
"""Number of the first frame, and coordinate of the top left corner of the picture."""
_FEWEST, _MOST = 6, 10
_ROW = "frame,id,left,top,width,height and up to four more numbers"


@dataclass(frozen=True, eq=False)
class MotRows:
    """R rows of a file.

    Attributes:
        frame: (R,) numbers of frames, >= 1. identity: (R,) >= 0.
        box_xyxy: (R, 4) pixels, from the top left corner of the picture.
        confidence: (R,) seventh column; of truth 1 where the row counts, 0 where it does not; NaN where there is none.
        further: (R, 3) the columns after it; of truth class and visibility; NaN where there is none.
        line: (R,) number in the file, from 1 on.
    """

    frame: NDArray[np.int64]
    identity: NDArray[np.int64]
    box_xyxy: NDArray[np.float64]
    confidence: NDArray[np.float64]
    further: NDArray[np.float64]
    line: NDArray[np.int64]


def read_mot(path: Path) -> MotRows:
    """Return the rows of a file, maybe none.

    Raises:
        ValueError: for a file that is no text, a row of other columns, a frame or an identity that is no whole number,
            a box that is none, and an identity twice in a frame; names file and line.
    """
    where, lines = short(path, 3), text_lines(path)
    numbers = np.full((len(lines), _MOST), np.nan)
    filled = np.zeros(len(lines), bool)
    for k, text in enumerate(lines):
        if text.strip():
            row = numbers_of(text)
            check(f"{where}, line {k + 1}", _FEWEST <= len(row) <= _MOST, _ROW, repr(text[:80]))
            numbers[k, : len(row)], filled[k] = row, True
    kept, line = numbers[filled], np.flatnonzero(filled) + 1
    frame, identity, box_xywh = kept[:, 0], kept[:, 1], kept[:, 2:6]
    for column, least, values in (("frame", FIRST, frame), ("id", 0, identity)):
        whole = (values >= least) & (values < 2.0**53) & (values == np.floor(values))
        _check_rows(where, whole, line, f"a whole number >= {least} as {column}", values)
    good = np.isfinite(box_xywh).all(axis=1) & (box_xywh[:, 2:] >= 0).all(axis=1)
    _check_rows(where, good, line, "finite left,top,width,height with a width and height >= 0", box_xywh)
    _, firsts = np.unique(kept[:, :2], axis=0, return_index=True)
    once = np.isin(np.arange(len(kept)), firsts)
    _check_rows(where, once, line, "each id once in a frame", kept[:, :2].astype(int), "frame,id {} again")
    frame, identity = kept[:, :2].astype(np.int64).T
    return MotRows(frame, identity, corners_of(box_xywh, FIRST), kept[:, 6], kept[:, 7:], line)


def mot_rows(answers: Sequence[Answer], number: int = FIRST) -> Iterator[str]:
    """Yield the rows of a tracker's answers on pictures that begin with ``number``, see ``rows_at``."""
    usual = first_box(answers)
    for frame, answer in enumerate(answers, start=number):
        yield from rows_at(frame, answer, usual)


def rows_at(frame: int, answer: Answer, usual: NDArray[np.float64]) -> Iterator[str]:
    """Yield the rows of the answer on a picture.

    The target of a tracker of one has the identity 1. A confidence is that of the track, or the probability of being in
    view, -1 without; a box that was not answered is of the size of the ``usual`` one, see ``first_box``.
    """
    for each in [Track(1, answer, confidence=answer.in_view_probability)] if isinstance(answer, Estimate) else answer:
        box = box_of(each.estimate, usual)
        if box is not None:
            left, top, right, bottom = map(float, box)
            numbers = ",".join(map(repr, (left + FIRST, top + FIRST, right - left, bottom - top)))
            confidence = -1 if each.confidence is None else repr(float(each.confidence))
            yield f"{frame},{each.identity},{numbers},{confidence},-1,-1,-1"


def first_box(answers: Sequence[Answer]) -> NDArray[np.float64]:
    """Return the box (4,) of the first answer of a tracker of one target; zeros without one."""
    box = answers[0].box_xyxy if answers and isinstance(answers[0], Estimate) else None
    return np.zeros(4) if box is None else box


def box_of(estimate: Estimate, usual: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the box (4,) of an estimate, by default of the size of the ``usual`` one; None without an estimate."""
    if np.isnan(estimate.position_px).any():
        return None
    half = 0.5 * (usual[2:] - usual[:2])
    about = np.concatenate([estimate.position_px - half, estimate.position_px + half])
    return about if estimate.box_xyxy is None else np.asarray(estimate.box_xyxy, float)


def rate_told(properties: Mapping[str, str]) -> float:
    """Return the frames a second of ``seqinfo.ini``, 0 for none; ``exactFrameRate`` is that of our export."""
    return rate_of(properties.get("exactFrameRate", properties.get("frameRate", "")))


def _check_rows(
    where: str, good: NDArray[np.bool_], line: NDArray[np.int64], wanted: str, values: NDArray[Any], got: str = "{}"
) -> None:
    """Raise ValueError for the first row that is not ``good``, with its ``values``."""
    if not good.all():
        row = int(np.argmin(good))
        numbers = ",".join(f"{number:g}" for number in np.atleast_1d(values[row]))
        raise ValueError(f"{where}, line {line[row]}: expected {wanted}, got {got.format(numbers)}")
