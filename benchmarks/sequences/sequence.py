"""A real sequence: pictures of one target, with its box where it is seen. Pictures are read one at a time."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.checks import check

ENDINGS = (".jpg", ".jpeg", ".png", ".bmp")
"""Of pictures, in small or capital letters."""
USUAL_RATE_HZ = 30.0
"""Frames a second, which no layout tells. UAV123 and UAVDT were recorded at this rate (their papers)."""
_NUMBERED = re.compile(r"(\D*)(\d+)$")


@dataclass(frozen=True, eq=False)
class BoxedSequence:
    """One target in F pictures.

    Attributes:
        name: of the sequence.
        pictures: (F,) files, in order of time.
        box_xyxy: (F, 4) pixels, from the top left corner of the picture; NaN where the target is not seen.
        rate_hz: frames a second.
    """

    name: str
    pictures: tuple[Path, ...]
    box_xyxy: NDArray[np.float64]
    rate_hz: float = USUAL_RATE_HZ

    @property
    def fingerprint(self) -> str:
        """Hash of the names of pictures, of the boxes and the rate: rows of another annotation are outdated."""
        names = "\0".join(picture.name for picture in self.pictures)
        content = f"{self.name}\0{names}\0{self.rate_hz}".encode() + np.ascontiguousarray(self.box_xyxy).tobytes()
        return hashlib.sha256(content).hexdigest()[:10]


@dataclass(frozen=True)
class Collection:
    """Sequences that are ranked together, e.g. a data set; or a single one.

    Attributes:
        name: of the data set's folder, or of the sequence.
        sequences: in order of their names.
    """

    name: str
    sequences: tuple[BoxedSequence, ...]


def short(path: Path, parts: int = 2) -> str:
    """Return the last parts of a path, for messages."""
    return "/".join(path.parts[-parts:])


def boxed_sequence(
    name: str, pictures: Sequence[Path], box_xywh: NDArray[np.float64], boxes_from: Path, first: float
) -> BoxedSequence:
    """Return a sequence from its parts.

    Args:
        box_xywh: (F, 4) left, top, width, height; NaN where the target is not seen.
        boxes_from: their file. first: coordinate of the top left corner of the picture.

    Raises:
        ValueError: if there are not as many boxes as pictures, or the first picture has no box.
    """
    check(short(boxes_from), len(box_xywh) == len(pictures), f"{len(pictures)} boxes, one a picture", len(box_xywh))
    started = not np.isnan(box_xywh[0]).any()
    check(short(boxes_from), started, "a box in the first picture, which starts trackers", "none")
    corner = box_xywh[:, :2] - first
    return BoxedSequence(name, tuple(pictures), np.concatenate([corner, corner + box_xywh[:, 2:]], axis=1))


def numbered_pictures(folder: Path) -> dict[int, Path]:
    """Return the pictures of a folder by the number in their names, in order; other files are left alone.

    Raises:
        ValueError: for a folder without pictures, a picture without a number, and a number that is missing or twice.
    """
    check("real", folder.is_dir(), "a folder of pictures", f"{str(folder)!r}, which is none")
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in ENDINGS)
    check(short(folder), bool(files), f"pictures ({', '.join(ENDINGS)})", "none")
    found: dict[int, Path] = {}
    for file in files:
        match = _NUMBERED.match(file.stem)
        if match is None:
            raise ValueError(f"{short(file)}: expected a picture whose name ends with its number, got {file.name!r}")
        number = int(match[2])
        check(short(folder), number not in found, f"one picture of number {number}", f"{file.name} too")
        found[number] = file
    numbers = sorted(found)
    missing = sorted({*range(numbers[0], numbers[-1] + 1)} - found.keys())
    wanted = f"a picture of every number from {numbers[0]} to {numbers[-1]}"
    check(short(folder), not missing, wanted, f"none of {', '.join(map(str, missing[:5]))}")
    return {number: found[number] for number in numbers}


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3), red first, as its pixels lie in the file. Raises ValueError if it is broken."""
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if picture is None:
        # Pictures of OTB lie in NAME/img.
        got = f"{path.stat().st_size} other bytes"
        raise ValueError(f"{short(path, 3)}: expected a picture that can be read, got {got}")
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)
