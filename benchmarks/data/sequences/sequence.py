"""A real sequence: pictures of one target, with its box where it is seen. Pictures are read one at a time."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import UnreadableSequence
from benchmarks.contract.printable import printable
from sim.checks import check

ENDINGS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp", ".bmp")
"""Of pictures, in small or capital letters."""
USUAL_RATE_HZ = 30.0
"""Frames a second, which no layout tells. UAV123 and UAVDT were recorded at this rate (their papers)."""
_NUMBERED = re.compile(r"(\D*)(\d+)$")


@dataclass(frozen=True, eq=False)
class BoxedSequence:
    """One target in F pictures, from the first one on that shows it.

    Attributes:
        name: of the sequence.
        pictures: (F,) files, in order of time.
        box_xyxy: (F, 4) pixels, from the top left corner of the picture; NaN where the target is not seen.
        rate_hz: frames a second.
        number: place among the sequences of its collection, from 0 on.
        notes: what a user should know of how it was read, a line each.
    """

    name: str
    pictures: tuple[Path, ...]
    box_xyxy: NDArray[np.float64]
    rate_hz: float = USUAL_RATE_HZ
    number: int = 0
    notes: tuple[str, ...] = ()

    @cached_property
    def fingerprint(self) -> str:
        """Hash of the boxes, of the rate, and of the names and bytes of the pictures: rows of others are outdated.

        Raises:
            UnreadableSequence: if a picture is gone.
        """
        content = hashlib.sha256(f"{self.name}\0{self.rate_hz}".encode())
        content.update(np.ascontiguousarray(self.box_xyxy).tobytes())
        for picture in self.pictures:
            content.update(os.fsencode(picture.name) + hashlib.sha256(_bytes_of(picture)).digest())
        return content.hexdigest()[:10]


@dataclass(frozen=True)
class Unread:
    """A sequence before it is read.

    Attributes:
        name: of the sequence, or of its folder.
        read: reads it. Raises ValueError for what is missing or wrong.
    """

    name: str
    read: Callable[[], BoxedSequence]


@dataclass(frozen=True)
class Collection:
    """Sequences that are ranked together, e.g. a data set; or a single one.

    Attributes:
        name: of the data set's folder, or of the sequence.
        sequences: in order of their names.
        unusable: what is wrong with those that could not be read, a line each.
    """

    name: str
    sequences: tuple[BoxedSequence, ...]
    unusable: tuple[str, ...] = ()


def short(path: Path, parts: int = 2) -> str:
    """Return the last parts of a path, for messages."""
    return printable("/".join(path.parts[-parts:]))


def boxed_sequence(
    name: str, pictures: Sequence[Path], box_xywh: NDArray[np.float64], boxes_from: Path, first: float
) -> BoxedSequence:
    """Return a sequence from its parts; it begins with the first picture that has a box, which starts trackers.

    A box wholly outside the picture shows nothing of the target, which is then not seen.

    Args:
        box_xywh: (F, 4) left, top, width, height; NaN where the target is not seen.
        boxes_from: their file. first: coordinate of the top left corner of the picture.

    Raises:
        ValueError: if there are not as many boxes as pictures, no box at all, or boxes in other units than pixels; or
            if the first picture cannot be read.
    """
    check(short(boxes_from), len(box_xywh) == len(pictures), f"{len(pictures)} boxes, one a picture", len(box_xywh))
    given = ~np.isnan(box_xywh[:, 0])
    check(short(boxes_from), bool(given.any()), "a box in at least one picture", "none")
    corner = box_xywh[:, :2] - first
    box_xyxy = np.concatenate([corner, corner + box_xywh[:, 2:]], axis=1)
    height, width = read_picture(pictures[0]).shape[:2]
    size = f"the picture of {width} x {height}"
    small = np.nanmax(np.abs(box_xywh)) <= 1.0
    check(short(boxes_from), not small, f"boxes in pixels of {size}", "numbers of at most 1, as of shares of it")
    outside = given & ~((box_xyxy[:, :2] < (width, height)) & (box_xyxy[:, 2:] > 0)).all(axis=1)
    seen = given & ~outside
    check(short(boxes_from), bool(seen.any()), f"a box that meets {size}", "none")
    begins = int(np.argmax(seen))
    notes = []
    if outside.any():
        line, count = int(np.argmax(outside)) + 1, int(outside.sum())
        notes.append(
            f"{name}: {count} of {len(given)} boxes lie wholly outside {size}, the first in line {line}: not seen"
        )
    if _are_corners(box_xywh[seen], box_xyxy[seen], (width, height)):
        reach = "reach outside the picture as left,top,width,height, and would fit as left,top,right,bottom"
        notes.append(f"{name}: the boxes {reach}")
    if begins:
        notes.append(f"{name}: the target is first seen in picture {begins + 1} of {len(given)}, where trackers start")
    shown_xyxy = np.where(seen[:, None], box_xyxy, np.nan)[begins:]
    return BoxedSequence(name, tuple(pictures[begins:]), shown_xyxy, notes=tuple(notes))


def _are_corners(box_xywh: NDArray[np.float64], box_xyxy: NDArray[np.float64], size_px: tuple[int, int]) -> bool:
    """Return whether boxes (F, 4) look as if their last two numbers were the right and bottom ends."""
    ends = box_xywh[:, 2:]
    fit = bool((ends > box_xywh[:, :2]).all() and (ends <= np.array(size_px) + 1).all())
    return fit and bool((box_xyxy[:, 2:] > np.array(size_px) + 1).any())


def visible(folder: Path, pattern: str) -> list[Path]:
    """Return the paths in a folder that match, in order, without hidden ones such as macOS's ``._0001.jpg``."""
    return sorted(path for path in folder.glob(pattern) if not path.name.startswith("."))


def numbered_pictures(folder: Path) -> dict[int, Path]:
    """Return the pictures of a folder by the number in their names, in order; other files are left alone.

    Raises:
        ValueError: for a folder without pictures, a picture without a number, and a number that is missing or twice.
    """
    check("real", folder.is_dir(), "a folder of pictures", f"{str(folder)!r}, which is none")
    files = [file for file in visible(folder, "*") if file.suffix.lower() in ENDINGS]
    check(short(folder), bool(files), f"pictures ({', '.join(ENDINGS)})", "none")
    found: dict[int, Path] = {}
    for file in files:
        match = _NUMBERED.match(file.stem)
        if match is None:
            raise ValueError(
                f"{short(file)}: expected a picture whose name ends with its number, got {printable(file.name)!r}"
            )
        number = int(match[2])
        check(short(folder), number not in found, f"one picture of number {number}", f"{printable(file.name)} too")
        found[number] = file
    numbers = sorted(found)
    missing = sorted({*range(numbers[0], numbers[-1] + 1)} - found.keys())
    wanted = f"a picture of every number from {numbers[0]} to {numbers[-1]}"
    check(short(folder), not missing, wanted, f"none of {', '.join(map(str, missing[:5]))}")
    return {number: found[number] for number in numbers}


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3), red first, as its pixels lie in the file.

    Raises:
        UnreadableSequence: if it is gone, broken or cut off; names it.
    """
    content = _bytes_of(path)
    # From memory, where a cut off file is refused: from a file OpenCV makes a picture of its beginning, grey below.
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if picture is None:
        raise _unreadable(path, f"{len(content)} bytes that are none, or a part of one")
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def _bytes_of(path: Path) -> bytes:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise _unreadable(path, str(error.strerror)) from None
    if not content:
        raise _unreadable(path, "an empty file")
    return content


def _unreadable(path: Path, got: str) -> UnreadableSequence:
    # Pictures of OTB lie in NAME/img.
    return UnreadableSequence(f"{short(path, 3)}: expected a whole picture, got {got}")
