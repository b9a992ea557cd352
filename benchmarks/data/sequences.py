"""Real sequences: pictures of one target with its box where it is seen, in the layouts of published data sets.

* OTB: ``NAME/img/0001.jpg …`` and ``NAME/groundtruth_rect.txt``, a line a picture. Wu, Lim, Yang, Object tracking
  benchmark, TPAMI 2015, http://cvlab.hanyang.ac.kr/tracker_benchmark/datasets.html. Pictures may begin at another
  number than 1. A folder with two targets has ``groundtruth_rect.1.txt`` and ``.2.txt``: the sequences ``NAME-1`` and
  ``NAME-2``, as the benchmark calls them. Empty ones are left out (Human4 has one). Files of five sequences have boxes
  of a part of the pictures, which the benchmark's page names, ``PARTS``. OTB has a box in every picture; NaN for none
  is UAV123's, and that of our export.
* UAVDT: ``NAME/img000001.jpg …`` and a file of boxes ``NAME_gt.txt`` of one target, or of all (DET and MOT). Du et al.,
  The unmanned aerial vehicle benchmark: object detection and tracking, ECCV 2018, and the README files of its toolkits.
  The pictures are in the data set's folder, in ``UAV-benchmark-S`` or in ``UAV-benchmark-M``; the boxes in ``anno``
  (single target: ``left,top,width,height``, a line a picture) or ``GT``, also those inside the toolkits' folders
  ``UAV-benchmark-SOT_v1.0`` and ``UAV-benchmark-MOTD_v1.0``. Lines of DET, ``NAME_gt_whole.txt``, are
  ``frame,id,left,top,width,height,out_of_view,occlusion,class``; those of MOT, ``NAME_gt.txt``, begin with the same six
  numbers. One target of them is followed from its first picture on, by default the one that is seen in most pictures;
  where it has no line it is not seen. Files of attributes (``att``) describe whole sequences and are not read.
* UAV123 and UAV20L: ``data_seq/UAV123/NAME/000001.jpg …`` and ``anno/UAV123/NAME.txt``, a line a picture. Mueller,
  Smith, Ghanem, A benchmark and simulator for UAV tracking, ECCV 2016; its ReadMe.txt: ``NaN,NaN,NaN,NaN`` where the
  target is fully hidden or outside the picture, and ``configSeqs.m`` names the folder and the first and last picture of
  every sequence: several share one folder (``bird1_1`` is a part of ``bird1``). Without that file a sequence is the
  folder of its name. ``--real`` takes the data set's folder, a folder of annotations (``anno/UAV20L``), one annotation,
  or one folder of pictures, whose annotation ``NAME.txt`` is in ``anno/UAV123`` of the data set, in the folder or
  beside it.

The top left corner of the picture is at 1, 1: in OTB, in UAV123, which uses the toolkit of OTB (MATLAB), and in UAVDT,
whose README files do not tell; its toolkits are written in MATLAB too.

Text files of boxes have one line a frame, ``left top width height``, separated by comma, tab or spaces. Data sets say
in several ways that the target is not seen, which all mean the same here: an empty line, a width or a height of 0,
``-1,-1,-1,-1``, and four numbers that are NaN or infinite.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import USUAL_RATE_HZ, UnreadableSequence
from benchmarks.contract.text import printable
from scenarios.scenario import Frame
from scenarios.truth import Truth
from sim.checks import check
from trackers.types import CameraCommand, CameraModel, Observation, Start

ENDINGS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp", ".bmp")
"""Of pictures, in small or capital letters."""
_NUMBERED = re.compile(r"(\D*)(\d+)$")
FIRST = 1.0
"""Coordinate of the top left corner of the picture in files of boxes."""
USUAL_FOCAL = 1.2
"""Focal length over the longer side of the picture where none is known: COLMAP's ``default_focal_length_factor``
(Schönberger, Frahm, Structure-from-motion revisited, CVPR 2016, and its documentation).
"""
TARGET = "target"
_OTB_BOXES = "groundtruth_rect*.txt"
PARTS = {
    "David": (300, 770),
    "Diving": (1, 215),
    "Football1": (1, 74),
    "Freeman3": (1, 460),
    "Freeman4": (1, 283),
}
"""Sequence → numbers of the first and the last picture that its boxes belong to."""
SET = "UAV123"
_PART = re.compile(
    r"'name'\s*,\s*'(?P<name>[^']+)'\s*,\s*'path'\s*,\s*'(?P<path>[^']+)'\s*,"
    r"\s*'startFrame'\s*,\s*(?P<first>\d+)\s*,\s*'endFrame'\s*,\s*(?P<last>\d+)"
)
_TOOLKITS = (".", "UAV-benchmark-SOT_v1.0", "UAV-benchmark-MOTD_v1.0")
_PICTURES = (".", "UAV-benchmark-S", "UAV-benchmark-M")
_ENDINGS = ("_gt_whole.txt", "_gt.txt")
"""Of files of boxes; the first has the targets that MOT leaves out too."""
_LINE = "left,top,width,height, or frame,id,left,top,width,height and three or four more numbers"
_BETWEEN = re.compile(r"\s*[,;]\s*|\s+")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf(inity)?)", re.IGNORECASE)
_BOX = "left,top,width,height with a width and height above 0, or NaN,NaN,NaN,NaN"
_BOX_NUMBERS = 4


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


Find = Callable[[Path, int | None], list[Unread]]
"""Returns the sequences of a path in one layout, none if it has another; the second argument chooses a target."""


def find_otb(path: Path, target: int | None) -> list[Unread]:
    """See ``Find``."""
    folders = [path] if any(path.glob(_OTB_BOXES)) else sorted({file.parent for file in path.glob(f"*/{_OTB_BOXES}")})
    return [sequence for folder in folders for sequence in _in_otb_folder(folder)]


def find_uavdt(path: Path, target: int | None) -> list[Unread]:
    """See ``Find``; ``target``: id of the target in files of several, None = the one that is seen most."""
    own = _boxes_of(path)
    if own is not None:
        return [Unread(printable(path.name), partial(_read_uavdt, own, path, target))]
    return [
        Unread(printable(name), partial(_read_in_uavdt, file, path, name, target))
        for name, file in _boxes(path).items()
    ]


def find_uav123(path: Path, target: int | None) -> list[Unread]:
    """See ``Find``."""
    annotations = _annotations(path)
    if annotations:
        return [Unread(printable(each.stem), partial(_read_annotated, each)) for each in annotations]
    annotation = _annotation_of(path) if path.is_dir() else None
    if annotation is None:
        return []
    return [Unread(printable(annotation.stem), partial(_read_uav123, annotation, path))]


LAYOUTS: dict[str, tuple[Find, str]] = {
    "otb": (find_otb, "groundtruth_rect.txt, or folders that hold one"),
    "uavdt": (find_uavdt, "boxes in anno/NAME_gt.txt or GT/NAME_gt_whole.txt"),
    "uav123": (find_uav123, f"anno/{SET}/NAME.txt, or {{name}}.txt for its pictures"),
}
"""Name → what finds its sequences, and what it looks for; the first layout with sequences is taken."""


def read_collections(
    paths: Sequence[Path], layout: str = "", target: int | None = None, rate_hz: float = USUAL_RATE_HZ
) -> list[Collection]:
    """Return the collections of paths, one each; sequences that cannot be read are named in them.

    Args:
        layout: of ``LAYOUTS``; "" = it is recognised.
        target: id of the target in files of several, see ``find_uavdt``.
        rate_hz: frames a second of all pictures.

    Raises:
        ValueError: for a path that is missing, empty or of another layout; two collections of one name; and if no
            sequence can be read.
    """
    check("layout", layout in ("", *LAYOUTS), f"one of {', '.join(LAYOUTS)}", repr(layout))
    check("rate_hz", 0 < rate_hz < float("inf"), "a number of frames a second > 0", f"{rate_hz:g}")
    found = [_collection(path.resolve(), layout, target, rate_hz) for path in paths]
    names = [each.name for each in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    check("real", not twice, "recordings of different names", f"two called {', '.join(twice)}")
    if not any(each.sequences for each in found):
        raise ValueError(next(line for each in found for line in each.unusable))
    return found


def _collection(path: Path, layout: str, target: int | None, rate_hz: float) -> Collection:
    check("real", path.exists(), "folders that exist", repr(str(path)))
    empty = path.is_dir() and not any(path.iterdir())
    check("real", not empty, "a folder of sequences", f"{str(path)!r}, which is empty")
    unread: list[Unread] = []
    for chosen in [layout] if layout else LAYOUTS:
        find, searched = LAYOUTS[chosen]
        unread = sorted(find(path, target), key=lambda sequence: sequence.name)
        if unread:
            break
    if layout:
        check(short(path), bool(unread), searched.format(name=printable(path.name)), "none")
    wanted = f"the layout of one of {', '.join(LAYOUTS)} (see frameout bench --help)"
    check("real", bool(unread), wanted, f"{str(path)!r}, which has none of them")
    check("target", target is None or chosen == "uavdt", "none but for files of several targets (uavdt)", target)
    names = [each.name for each in unread]
    twice = sorted({name for name in names if names.count(name) > 1})
    check(printable(path.name), not twice, "sequences of different names", f"two called {', '.join(twice)}")
    sequences: list[BoxedSequence] = []
    unusable = []
    for number, each in enumerate(unread):
        try:
            sequences.append(replace(each.read(), rate_hz=rate_hz, number=number))
        except ValueError as error:
            unusable.append(str(error))
    name = sequences[0].name if len(unread) == len(sequences) == 1 else printable(path.name)
    return Collection(name, tuple(sequences), tuple(unusable))


def _in_otb_folder(folder: Path) -> list[Unread]:
    files = sorted(folder.glob(_OTB_BOXES))
    # Where all are empty, the first one says so when it is read.
    told = [file for file in files if file.read_bytes().strip()] or files[:1]
    found = []
    for file in told:
        target = file.stem.removeprefix("groundtruth_rect").strip(".")
        name = printable(f"{folder.name}-{target}" if target else folder.name)
        found.append(Unread(name, partial(_read_otb, name, folder, file)))
    return found


def _read_otb(name: str, folder: Path, file: Path) -> BoxedSequence:
    pictures = numbered_pictures(folder / "img")
    boxes = read_boxes(file, len(pictures))
    first, last = PARTS.get(folder.name, (0, -1))
    shown = list(pictures.values())
    if len(boxes) != len(shown) and len(boxes) == last - first + 1:
        shown = [picture for number, picture in pictures.items() if first <= number <= last]
    return boxed_sequence(name, shown, boxes, file)


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


def _read_annotated(annotation: Path) -> BoxedSequence:
    root = annotation.parents[2]
    for file in sorted(root.glob("configSeqs*.m")):
        for part in _PART.finditer(file.read_text(encoding="utf-8", errors="replace")):
            if part["name"] == annotation.stem:
                folder = root / "data_seq" / SET / re.split(r"[\\/]", part["path"].rstrip("\\/"))[-1]
                return _read_uav123(annotation, folder, (int(part["first"]), int(part["last"])))
    folder = root / "data_seq" / SET / annotation.stem
    wanted = f"pictures in data_seq/{SET}/{printable(annotation.stem)}, or configSeqs.m that names their folder"
    check(short(annotation), folder.is_dir(), wanted, "neither")
    return _read_uav123(annotation, folder)


def _read_uav123(annotation: Path, folder: Path, part: tuple[int, int] | None = None) -> BoxedSequence:
    pictures = numbered_pictures(folder)
    first, last = part or (min(pictures), max(pictures))
    missing = [number for number in (first, last) if number not in pictures]
    check(short(folder), not missing, f"pictures {first} to {last}, as configSeqs.m says", f"none of {missing}")
    shown = [picture for number, picture in pictures.items() if first <= number <= last]
    return boxed_sequence(printable(annotation.stem), shown, read_boxes(annotation, len(shown)), annotation)


def _boxes(folder: Path) -> dict[str, Path]:
    """Return the files of boxes of a data set, by sequence."""
    found: dict[str, Path] = {}
    for toolkit in _TOOLKITS:
        for place in ("anno", "GT"):
            for ending in _ENDINGS:
                for file in visible(folder / toolkit / place, f"*{ending}"):
                    found.setdefault(file.name.removesuffix(ending), file)
    return found


def _boxes_of(pictures: Path) -> Path | None:
    """Return the file of boxes of a folder of pictures, from the data set that holds it."""
    name = pictures.resolve().name
    places = (pictures.parent, pictures.parent.parent) if any(pictures.glob("img*")) else ()
    return next((file for place in places if (file := _boxes(place).get(name)) is not None), None)


def _pictures(folder: Path, name: str) -> Path:
    places = [folder / place / name for place in _PICTURES]
    found = next((place for place in places if place.is_dir()), None)
    if found is None:
        raise ValueError(f"{short(folder)}: expected a folder {printable(name)} of pictures, got none")
    return found


def _read_in_uavdt(file: Path, folder: Path, name: str, target: int | None) -> BoxedSequence:
    return _read_uavdt(file, _pictures(folder, name), target)


def _read_uavdt(file: Path, folder: Path, target: int | None) -> BoxedSequence:
    name, pictures = printable(folder.name), numbered_pictures(folder)
    rows = read_rows(file, (4, 9, 10), _LINE, len(pictures))
    if rows.shape[1] == 4:
        return boxed_sequence(name, list(pictures.values()), checked_boxes(file, rows), file)
    frames, identities = _whole(file, rows[:, 0], "frame"), _whole(file, rows[:, 1], "id")
    boxes = checked_boxes(file, rows[:, 2:6])
    followed = _followed(file, identities, target)
    mine = identities == followed
    unmatched = np.flatnonzero(~np.isin(frames, list(pictures)))
    for line in unmatched[:1]:
        wanted = f"a frame from {min(pictures)} to {max(pictures)}, of which there are pictures"
        check(f"{short(file)}, line {line + 1}", False, wanted, frames[line])
    twice = len(np.unique(frames[mine])) < int(mine.sum())
    check(short(file), not twice, f"one line a frame of id {followed}", "two of one frame")
    first = int(frames[mine].min())
    box_of = dict(zip(frames[mine].tolist(), boxes[mine], strict=True))
    shown = {number: picture for number, picture in pictures.items() if number >= first}
    lost = np.full(4, np.nan)
    track = np.array([box_of.get(number, lost) for number in shown])
    return boxed_sequence(f"{name}-{followed}", list(shown.values()), track, file)


def _whole(file: Path, numbers: NDArray[np.float64], what: str) -> NDArray[np.int64]:
    good = np.isfinite(numbers) & (np.nan_to_num(numbers) % 1 == 0)
    line = int(np.argmin(good))
    check(f"{short(file)}, line {line + 1}", bool(good.all()), f"a whole number as {what}", numbers[line])
    return numbers.astype(np.int64)


def _followed(file: Path, identities: NDArray[np.int64], target: int | None) -> int:
    known, lines = np.unique(identities, return_counts=True)
    if target is None:
        return int(known[np.argmax(lines)])
    some = ", ".join(map(str, known[:10])) + (" …" if len(known) > 10 else "")
    check("target", target in known, f"an id in {short(file)}: {some}", target)
    return target


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


def short(path: Path, parts: int = 2) -> str:
    """Return the last parts of a path, for messages."""
    return printable("/".join(path.parts[-parts:]))


def boxed_sequence(
    name: str, pictures: Sequence[Path], box_xywh: NDArray[np.float64], boxes_from: Path
) -> BoxedSequence:
    """Return a sequence from its parts; it begins with the first picture that has a box, which starts trackers.

    A box wholly outside the picture shows nothing of the target, which is then not seen.

    Args:
        box_xywh: (F, 4) left, top, width, height; NaN where the target is not seen.
        boxes_from: their file, where the top left corner of the picture is at ``FIRST``.

    Raises:
        ValueError: if there are not as many boxes as pictures, no box at all, or boxes in other units than pixels; or
            if the first picture cannot be read.
    """
    check(short(boxes_from), len(box_xywh) == len(pictures), f"{len(pictures)} boxes, one a picture", len(box_xywh))
    given = ~np.isnan(box_xywh[:, 0])
    check(short(boxes_from), bool(given.any()), "a box in at least one picture", "none")
    corner = box_xywh[:, :2] - FIRST
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


class SequenceEpisode:
    """See ``scenarios.scenario.Episode``. Pictures are read when they are needed; none is kept but the latest.

    The target's state is ``in`` where it has a box, else ``out``: layouts do not tell whether it is hidden or outside
    the picture. What is in metres is NaN.
    """

    closed_loop = False

    def __init__(self, sequence: BoxedSequence) -> None:
        """Read the first picture. Raises UnreadableSequence if it is broken."""
        self._sequence = sequence
        self.frame_count = len(sequence.pictures)
        self.rate_hz = sequence.rate_hz
        self._next = 0
        self._last_seen = 0
        height, width = read_picture(sequence.pictures[0]).shape[:2]
        self._camera = CameraModel(width, height, USUAL_FOCAL * max(width, height))

    @property
    def start(self) -> Start:
        """See ``Episode``."""
        return Start(self._camera, self._sequence.box_xyxy[0].copy())

    def step(self, command: CameraCommand | None = None) -> Frame:
        """See ``Episode``. Raises UnreadableSequence for a picture that is broken or of another size."""
        k, path = self._next, self._sequence.pictures[self._next]
        picture = read_picture(path)
        height, width = self._camera.height_px, self._camera.width_px
        if picture.shape[:2] != (height, width):
            got = f"{picture.shape[1]} x {picture.shape[0]}"
            raise UnreadableSequence(
                f"{short(path, 3)}: expected {width} x {height} pixels as the first one, got {got}"
            )
        self._next += 1
        return Frame(Observation(picture, k / self.rate_hz, self._camera), self._truth(k))

    def map_of(self) -> Any:
        """See ``Episode``. None is known."""
        return None

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """See ``Episode``. Raises ValueError: the surroundings of a real picture are not known."""
        raise ValueError(f"scale: expected none for a real sequence, which has no larger view, got {scale:g}")

    def normals(self) -> NDArray[np.float32]:
        """See ``Episode``. None are known, so all are 0."""
        return np.zeros((self._camera.height_px, self._camera.width_px, 3), np.float32)

    def close(self) -> None:
        """See ``Episode``. Nothing is open."""

    def _truth(self, k: int) -> Truth:
        box_xyxy = self._sequence.box_xyxy[k]
        seen = not np.isnan(box_xyxy).any()
        self._last_seen = k if seen else self._last_seen
        return Truth(
            frame=k,
            time_s=k / self.rate_hz,
            T_world_camera=np.full((4, 4), np.nan),
            names=(TARGET,),
            kinds=("unknown",),
            T_world_object=np.full((1, 4, 4), np.nan),
            size_m=np.full((1, 3), np.nan),
            speed_mps=np.full(1, np.nan),
            position_px=0.5 * (box_xyxy[:2] + box_xyxy[2:])[None],
            box_xyxy=box_xyxy[None].copy(),
            instance_id=np.zeros(1, np.int64),
            visible_fraction=np.array([np.nan if seen else 0.0]),
            state=np.array(["in" if seen else "out"]),
            side=np.array([""]),
            frames_since_exit=np.array([-1 if seen else k - self._last_seen - 1]),
            instance_map=np.empty((0, 0), np.int32),
            depth_m=np.empty((0, 0), np.float32),
            exposure_s=float("nan"),
            gain=float("nan"),
        )
