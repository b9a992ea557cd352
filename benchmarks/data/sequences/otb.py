"""OTB: ``NAME/img/0001.jpg …`` and ``NAME/groundtruth_rect.txt``, a line a picture, the top left pixel at 1, 1.

Wu, Lim, Yang, Object tracking benchmark, TPAMI 2015, http://cvlab.hanyang.ac.kr/tracker_benchmark/datasets.html.
Numbers are separated by comma, tab or space; pictures may begin at another number than 1. A folder with two targets
has ``groundtruth_rect.1.txt`` and ``.2.txt``: the sequences ``NAME-1`` and ``NAME-2``, as the benchmark calls them.
Empty ones are left out (Human4 has one). Files of five sequences have boxes of a part of the pictures, which the
benchmark's page names, ``PARTS``. OTB has a box in every picture; NaN for none is UAV123's, and that of our export.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from benchmarks.contract.printable import printable
from benchmarks.data.sequences.box_files import read_boxes
from benchmarks.data.sequences.sequence import BoxedSequence, Unread, boxed_sequence, numbered_pictures, short
from sim.checks import check

FIRST = 1.0
"""Coordinate of the top left corner of the picture."""
PARTS = {
    "David": (300, 770),
    "Diving": (1, 215),
    "Football1": (1, 74),
    "Freeman3": (1, 460),
    "Freeman4": (1, 283),
}
"""Sequence → numbers of the first and the last picture that its boxes belong to."""
_BOXES = "groundtruth_rect*.txt"


def is_otb(folder: Path) -> bool:
    """Return whether a folder is a sequence of this layout, or holds some."""
    return any(folder.glob(_BOXES)) or any(folder.glob(f"*/{_BOXES}"))


def find_otb(folder: Path) -> list[Unread]:
    """Return the sequences of a folder. Raises ValueError if there are none."""
    if any(folder.glob(_BOXES)):
        return _of_folder(folder)
    inside = sorted({file.parent for file in folder.glob(f"*/{_BOXES}")})
    check(short(folder), bool(inside), "groundtruth_rect.txt, or folders that hold one", "none")
    return [sequence for each in inside for sequence in _of_folder(each)]


def _of_folder(folder: Path) -> list[Unread]:
    files = sorted(folder.glob(_BOXES))
    # Where all are empty, the first one says so when it is read.
    told = [file for file in files if file.read_bytes().strip()] or files[:1]
    found = []
    for file in told:
        target = file.stem.removeprefix("groundtruth_rect").strip(".")
        name = printable(f"{folder.name}-{target}" if target else folder.name)
        found.append(Unread(name, partial(_read, name, folder, file)))
    return found


def _read(name: str, folder: Path, file: Path) -> BoxedSequence:
    pictures = numbered_pictures(folder / "img")
    boxes = read_boxes(file, len(pictures))
    first, last = PARTS.get(folder.name, (0, -1))
    shown = list(pictures.values())
    if len(boxes) != len(shown) and len(boxes) == last - first + 1:
        shown = [picture for number, picture in pictures.items() if first <= number <= last]
    return boxed_sequence(name, shown, boxes, file, FIRST)
