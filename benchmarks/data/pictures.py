"""Pictures on disk: which files of a folder are pictures, their numbers, and their pixels."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import UnreadableSequence
from benchmarks.contract.text import printable
from sim.checks import check

ENDINGS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp", ".bmp")
"""Of pictures, in small or capital letters."""
_NUMBER = re.compile(r"\d+$")


@dataclass(frozen=True)
class Member:
    """A file in a tar file, with what readers of pictures use of a path.

    Attributes:
        tar: the file. name: of the member. offset, size: of its content, bytes.
    """

    tar: Path
    name: str
    offset: int
    size: int

    @property
    def parts(self) -> tuple[str, ...]:
        """Parts of the path, with the tar file as a folder."""
        return (*self.tar.parts, self.name)

    def read_bytes(self) -> bytes:
        """Return its content. Raises OSError if the tar file is gone."""
        with self.tar.open("rb") as file:
            file.seek(self.offset)
            return file.read(self.size)


Picture = Path | Member
"""Where the content of a picture is."""


def short(path: Picture, parts: int = 2) -> str:
    """Return the last parts of a path, for messages."""
    return printable("/".join(path.parts[-parts:]))


def visible(folder: Path, pattern: str) -> list[Path]:
    """Return the paths in a folder that match, in order, without hidden ones such as macOS's ``._0001.jpg``."""
    return sorted(path for path in folder.glob(pattern) if not path.name.startswith("."))


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of a folder in the order of their names; other files are left alone."""
    return [file for file in visible(folder, "*") if file.suffix.lower() in ENDINGS]


def numbered_pictures(folder: Path, *, gaps: bool = False) -> dict[int, Path]:
    """Return the pictures of a folder by the number in their names, in order.

    Args:
        gaps: whether numbers may be missing, in layouts whose labels name the picture that they belong to.

    Raises:
        ValueError: for a folder without pictures, a picture without a number, and a number that is missing or twice.
    """
    files = pictures_in(folder)
    check(short(folder), bool(files), f"pictures ({', '.join(ENDINGS)})", "none")
    found: dict[int, Path] = {}
    for file in files:
        match = _NUMBER.search(file.stem)
        number = int(match[0]) if match else -1
        check(short(file), number >= 0, "a picture whose name ends with its number", repr(printable(file.name)))
        check(short(folder), number not in found, f"one picture of number {number}", f"{printable(file.name)} too")
        found[number] = file
    numbers = range(min(found), max(found) + 1)
    if not gaps:
        # A few alone: numbers that are times have endless gaps.
        missing = list(islice((str(number) for number in numbers if number not in found), 5))
        wanted = f"a picture of every number from {numbers[0]} to {numbers[-1]}"
        check(short(folder), not missing, wanted, f"none of {', '.join(missing)}")
    return {number: found[number] for number in sorted(found)}


def read_picture(path: Picture) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3), red first, as its pixels lie in the file.

    Raises:
        UnreadableSequence: if it is gone, broken or cut off; names it.
    """
    content = bytes_of(path)
    # From memory, where a cut off file is refused: from a file OpenCV makes a picture of its beginning, grey below.
    how = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), how) if content else None
    if picture is None:
        raise _unreadable(path, f"{len(content)} bytes that are none, or a part of one")
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def bytes_of(path: Picture) -> bytes:
    """Return the bytes of a picture's file. Raises UnreadableSequence if it is gone."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise _unreadable(path, str(error.strerror)) from None


def _unreadable(path: Picture, got: str) -> UnreadableSequence:
    # Pictures of OTB lie in NAME/img.
    return UnreadableSequence(f"{short(path, 3)}: expected a whole picture, got {got}")
