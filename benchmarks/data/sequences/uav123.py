"""UAV123 and UAV20L: ``data_seq/UAV123/NAME/000001.jpg …`` and ``anno/UAV123/NAME.txt``, a line a picture.

Mueller, Smith, Ghanem, A benchmark and simulator for UAV tracking, ECCV 2016; its ReadMe.txt: ``NaN,NaN,NaN,NaN`` where
the target is fully hidden or outside the picture, and ``configSeqs.m`` names the folder and the first and last picture
of every sequence: several share one folder (``bird1_1`` is a part of ``bird1``). Without that file a sequence is the
folder of its name. The top left pixel is at 1, 1, as in OTB, whose toolkit (MATLAB) it uses.

``--real`` takes the data set's folder, a folder of annotations (``anno/UAV20L``), one annotation, or one folder of
pictures, whose annotation ``NAME.txt`` is in ``anno/UAV123`` of the data set, in the folder or beside it.
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

from benchmarks.contract.printable import printable
from benchmarks.data.sequences.box_files import read_boxes
from benchmarks.data.sequences.sequence import (
    BoxedSequence,
    Unread,
    boxed_sequence,
    numbered_pictures,
    short,
    visible,
)
from sim.checks import check

FIRST = 1.0
"""Coordinate of the top left corner of the picture."""
SET = "UAV123"
_PART = re.compile(
    r"'name'\s*,\s*'(?P<name>[^']+)'\s*,\s*'path'\s*,\s*'(?P<path>[^']+)'\s*,"
    r"\s*'startFrame'\s*,\s*(?P<first>\d+)\s*,\s*'endFrame'\s*,\s*(?P<last>\d+)"
)


def is_uav123(path: Path) -> bool:
    """Return whether a path is of this layout."""
    return bool(_annotations(path)) or (path.is_dir() and _annotation_of(path) is not None)


def find_uav123(path: Path) -> list[Unread]:
    """Return the sequences of a path. Raises ValueError if there are none."""
    annotations = _annotations(path)
    if annotations:
        return [Unread(printable(each.stem), partial(_sequence, each)) for each in annotations]
    annotation = _annotation_of(path)
    if annotation is None:
        raise ValueError(
            f"{short(path)}: expected anno/{SET}/NAME.txt, or {printable(path.name)}.txt for its pictures, got none"
        )
    return [Unread(printable(annotation.stem), partial(_read, annotation, path))]


def _annotations(path: Path) -> list[Path]:
    """Return the annotations that a path means: of the data set, of a folder of annotations, or itself."""
    if path.is_file():
        return [path] if path.suffix == ".txt" and path.parent.parent.name == "anno" else []
    folder = path if path.parent.name == "anno" else path / "anno" / SET
    return [file for file in visible(folder, "*.txt") if not file.name.lower().startswith("readme")]


def _annotation_of(pictures: Path) -> Path | None:
    """Return the annotation of a folder of pictures."""
    name = f"{pictures.name}.txt"
    places = [pictures / name, pictures.with_name(name)]
    if pictures.parent.parent.name == "data_seq":
        places.insert(0, pictures.parents[2] / "anno" / pictures.parent.name / name)
    return next((place for place in places if place.is_file()), None)


def _sequence(annotation: Path) -> BoxedSequence:
    root = annotation.parents[2]
    for file in sorted(root.glob("configSeqs*.m")):
        for part in _PART.finditer(file.read_text(encoding="utf-8", errors="replace")):
            if part["name"] == annotation.stem:
                folder = root / "data_seq" / SET / re.split(r"[\\/]", part["path"].rstrip("\\/"))[-1]
                return _read(annotation, folder, (int(part["first"]), int(part["last"])))
    folder = root / "data_seq" / SET / annotation.stem
    wanted = f"pictures in data_seq/{SET}/{printable(annotation.stem)}, or configSeqs.m that names their folder"
    check(short(annotation), folder.is_dir(), wanted, "neither")
    return _read(annotation, folder)


def _read(annotation: Path, folder: Path, part: tuple[int, int] | None = None) -> BoxedSequence:
    pictures = numbered_pictures(folder)
    first, last = part or (min(pictures), max(pictures))
    missing = [number for number in (first, last) if number not in pictures]
    check(short(folder), not missing, f"pictures {first} to {last}, as configSeqs.m says", f"none of {missing}")
    shown = [picture for number, picture in pictures.items() if first <= number <= last]
    return boxed_sequence(printable(annotation.stem), shown, read_boxes(annotation, len(shown)), annotation, FIRST)
