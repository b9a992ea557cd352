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
  folder of its name. ``--real`` takes a folder of annotations (``anno/UAV20L``) too.

``--real`` takes a data set's folder, or a sequence: its folder of pictures, with all sequences that share it, or its
file of boxes, in the data set.

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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, product
from pathlib import Path, PureWindowsPath
from typing import Any

import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.contract.judging import USUAL_RATE_HZ, UnreadableSequence
from benchmarks.contract.text import printable
from scenarios.scenario import Frame
from scenarios.truth import Truth
from sim.checks import check
from trackers.types import CameraCommand, CameraModel, Observation, Start

ENDINGS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp", ".bmp")
"""Of pictures, in small or capital letters."""
_NUMBER = re.compile(r"\d+$")
FIRST = 1.0
"""Coordinate of the top left corner of the picture in files of boxes."""
USUAL_FOCAL = 1.2
"""Focal length over the longer side of the picture where none is known: COLMAP's ``default_focal_length_factor``
(Schönberger, Frahm, Structure-from-motion revisited, CVPR 2016, and its documentation).
"""
TARGET = "target"
_OTB_BOXES = "groundtruth_rect*.txt"
PARTS = {"David": (300, 770), "Diving": (1, 215), "Football1": (1, 74), "Freeman3": (1, 460), "Freeman4": (1, 283)}
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
_LINE = "left,top,width,height (in UAVDT also with frame,id before and 3 or 4 numbers after them)"
_COLUMNS = (4, 9, 10)
_BETWEEN = re.compile(r"\s*[,;]\s*|\s+")
_BOX = "left,top,width,height with a width and height above 0, or NaN,NaN,NaN,NaN"


@dataclass(frozen=True)
class Source:
    """Where a sequence is.

    Attributes:
        name: of the sequence, or of its folder. pictures: the folder. boxes: the file.
        part: numbers of the first and the last picture that the boxes belong to, if they are not one for each picture.
    """

    name: str
    pictures: Path
    boxes: Path
    part: tuple[int, int] | None = None


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


Find = Callable[[Path], Iterator[Source]]
"""Yields the sequences of a data set in one layout; none if it has another."""


def find_otb(path: Path) -> Iterator[Source]:
    """See ``Find``; the folder of one sequence is taken too."""
    for file in (*path.glob(_OTB_BOXES), *path.glob(f"*/{_OTB_BOXES}")):
        folder, target = file.parent, file.stem.removeprefix("groundtruth_rect").strip(".")
        if not target or file.read_bytes().strip():
            name = f"{folder.name}-{target}" if target else folder.name
            yield Source(name, folder / "img", file, PARTS.get(folder.name))


def find_uavdt(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    boxes: dict[str, Path] = {}
    for toolkit, place, ending in product(_TOOLKITS, ("anno", "GT"), _ENDINGS):
        for file in visible(path / toolkit / place, f"*{ending}"):
            boxes.setdefault(file.name.removesuffix(ending), file)
    for name, file in boxes.items():
        folders = [path / place / name for place in _PICTURES]
        yield Source(name, next(filter(Path.is_dir, folders), folders[0]), file)


def find_uav123(path: Path) -> Iterator[Source]:
    """See ``Find``; a folder of annotations is taken too."""
    annotations = path if path.parent.name == "anno" else path / "anno" / SET
    root = annotations.parents[1]
    texts = [file.read_text(encoding="utf-8", errors="replace") for file in root.glob("configSeqs*.m")]
    parts = {part["name"]: part for text in texts for part in _PART.finditer(text)}
    for file in visible(annotations, "*.txt"):
        part = parts.get(file.stem)
        if part is not None:
            folder, numbers = PureWindowsPath(part["path"]).name, (int(part["first"]), int(part["last"]))
            yield Source(file.stem, root / "data_seq" / SET / folder, file, numbers)
        elif not file.name.lower().startswith("readme"):
            yield Source(file.stem, root / "data_seq" / SET / file.stem, file)


LAYOUTS: dict[str, tuple[Find, str]] = {
    "otb": (find_otb, "groundtruth_rect.txt, or folders that hold one"),
    "uavdt": (find_uavdt, "boxes in anno/NAME_gt.txt or GT/NAME_gt_whole.txt"),
    "uav123": (find_uav123, f"anno/{SET}/NAME.txt"),
}
"""Name → what finds its sequences, and what it looks for; the first layout with sequences is taken."""


def read_collections(
    paths: Sequence[Path], layout: str = "", target: int | None = None, rate_hz: float = USUAL_RATE_HZ
) -> list[Collection]:
    """Return the collections of paths, one each; sequences that cannot be read are named in them.

    Args:
        layout: of ``LAYOUTS``; "" = it is recognised.
        target: id of the target in files of several, None = the one that is seen most.
        rate_hz: frames a second of all pictures.

    Raises:
        ValueError: for a path that is missing or of another layout; two collections of one name; and if no sequence
            can be read.
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
    searched = {layout: LAYOUTS[layout]} if layout else LAYOUTS
    sources = next(filter(None, (_sources(path, find) for find, _ in searched.values())), [])
    wanted = LAYOUTS[layout][1] if layout else f"the layout of one of {', '.join(LAYOUTS)} (see frameout bench --help)"
    check("real", bool(sources), wanted, f"{str(path)!r}, which has none")
    sequences: list[BoxedSequence] = []
    unusable = []
    for number, source in enumerate(sources):
        try:
            sequences.append(replace(_read(source, target), rate_hz=rate_hz, number=number))
        except ValueError as error:
            unusable.append(str(error))
    name = sequences[0].name if len(sources) == len(sequences) == 1 else printable(path.name)
    return Collection(name, tuple(sequences), tuple(unusable))


def _sources(path: Path, find: Find) -> list[Source]:
    """Return the sequences of a data set, or those whose pictures or boxes are at the path."""
    held = ([each for each in find(root) if path in (each.pictures, each.boxes)] for root in path.parents[:3])
    return sorted(list(find(path)) or next(filter(None, held), []), key=lambda each: printable(each.name))


def _read(source: Source, target: int | None) -> BoxedSequence:
    name, file = printable(source.name), source.boxes
    place = f"pictures in {short(source.pictures, 3)}, or where configSeqs.m of {SET} says"
    check(short(file), source.pictures.is_dir(), place, "no such folder")
    pictures = numbered_pictures(source.pictures)
    keys, boxes = read_boxes(file, len(pictures))
    if keys.size:
        frames, ids = keys.T
        unknown = frames[~np.isin(frames, list(pictures))]
        wanted = f"frames from {min(pictures)} to {max(pictures)}, of which there are pictures"
        check(short(file), not unknown.size, wanted, ", ".join(f"{each:g}" for each in unknown[:1]))
        known, lines = np.unique(ids, return_counts=True)
        followed = known[np.argmax(lines)] if target is None else target
        some = ", ".join(f"{each:g}" for each in known[:10])
        check("target", followed in known, f"an id in {short(file)}: {some}", target)
        track = pd.DataFrame(boxes[ids == followed], index=frames[ids == followed])
        check(short(file), track.index.is_unique, f"one line a frame of id {followed:g}", "two of one frame")
        boxes, name = track.reindex(list(pictures)).to_numpy(), f"{name}-{followed:g}"
    else:
        check("target", target is None, "none but for files of several targets (uavdt)", target)
        if source.part is not None and len(boxes) != len(pictures):
            first, last = source.part
            pictures = {number: picture for number, picture in pictures.items() if first <= number <= last}
    return boxed_sequence(name, list(pictures.values()), boxes, file)


def read_boxes(path: Path, frames: int = 0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return frames and ids (R, 2) of a text file, or (R, 0) if it has none, and its boxes (R, 4).

    A box is left, top, width, height; NaN where the target is not seen. An empty line is no box; those at the end are
    left out, but for those that make up ``frames`` lines, the pictures of the sequence. A file may mix separators
    (OTB's BlurCar1 does), begin with a byte-order mark and have lines of Windows.

    Raises:
        ValueError: for a file that is no text or empty, a line that has other columns, and a box with a negative size
            or with numbers that are half unknown.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise ValueError(f"{short(path)}: expected text with numbers, got bytes that are none") from None
    last = max((number for number, line in enumerate(lines, start=1) if line.strip()), default=0)
    check(short(path), last > 0, f"lines of {_LINE}", "an empty file")
    read: list[list[float]] = []
    for number, line in enumerate(lines[: frames if last < frames <= len(lines) else last], start=1):
        try:
            numbers = [float(cell) for cell in _BETWEEN.split(line.strip())] if line.strip() else [np.nan] * 4
        except ValueError:
            numbers = []
        good = len(numbers) in ({len(read[0])} if read else _COLUMNS)
        check(f"{short(path)}, line {number}", good, _LINE, repr(line[:80]))
        read.append(numbers)
    rows = np.array(read)
    keys, box_xywh = (rows[:, :0], rows) if rows.shape[1] == 4 else (rows[:, :2], rows[:, 2:6])
    none = ~np.isfinite(box_xywh).any(axis=1) | (box_xywh[:, 2:] == 0).any(axis=1) | (box_xywh == -1).all(axis=1)
    good = none | (np.isfinite(box_xywh).all(axis=1) & (box_xywh[:, 2:] > 0).all(axis=1))
    first = int(np.argmin(good))
    got = ",".join(f"{number:g}" for number in box_xywh[first])
    check(f"{short(path)}, line {first + 1}", bool(good.all()), _BOX, got)
    return keys, np.where(none[:, None], np.nan, box_xywh)


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
    seen = np.all((box_xyxy[:, :2] < (width, height)) & (box_xyxy[:, 2:] > 0), axis=1)
    check(short(boxes_from), bool(seen.any()), f"a box that meets {size}", "none")
    outside, begins, notes = given & ~seen, int(np.argmax(seen)), []
    if outside.any():
        line, count = int(np.argmax(outside)) + 1, int(outside.sum())
        notes.append(
            f"{name}: {count} of {len(given)} boxes lie wholly outside {size}, the first in line {line}: not seen"
        )
    begin, end, limit = box_xywh[seen, :2], box_xywh[seen, 2:], (width + 1, height + 1)
    if (end > begin).all() and (end <= limit).all() and (begin - FIRST + end > limit).any():
        reach = "reach outside the picture as left,top,width,height, and would fit as left,top,right,bottom"
        notes.append(f"{name}: the boxes {reach}")
    if begins:
        notes.append(f"{name}: the target is first seen in picture {begins + 1} of {len(given)}, where trackers start")
    shown_xyxy = np.where(seen[:, None], box_xyxy, np.nan)[begins:]
    return BoxedSequence(name, tuple(pictures[begins:]), shown_xyxy, notes=tuple(notes))


def visible(folder: Path, pattern: str) -> list[Path]:
    """Return the paths in a folder that match, in order, without hidden ones such as macOS's ``._0001.jpg``."""
    return sorted(path for path in folder.glob(pattern) if not path.name.startswith("."))


def numbered_pictures(folder: Path) -> dict[int, Path]:
    """Return the pictures of a folder by the number in their names, in order; other files are left alone.

    Raises:
        ValueError: for a folder without pictures, a picture without a number, and a number that is missing or twice.
    """
    files = [file for file in visible(folder, "*") if file.suffix.lower() in ENDINGS]
    check(short(folder), bool(files), f"pictures ({', '.join(ENDINGS)})", "none")
    found: dict[int, Path] = {}
    for file in files:
        match = _NUMBER.search(file.stem)
        number = int(match[0]) if match else -1
        check(short(file), number >= 0, "a picture whose name ends with its number", repr(printable(file.name)))
        check(short(folder), number not in found, f"one picture of number {number}", f"{printable(file.name)} too")
        found[number] = file
    numbers = range(min(found), max(found) + 1)
    # A few alone: numbers that are times have endless gaps.
    missing = list(islice((str(number) for number in numbers if number not in found), 5))
    wanted = f"a picture of every number from {numbers[0]} to {numbers[-1]}"
    check(short(folder), not missing, wanted, f"none of {', '.join(missing)}")
    return {number: found[number] for number in numbers}


def read_picture(path: Path) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3), red first, as its pixels lie in the file.

    Raises:
        UnreadableSequence: if it is gone, broken or cut off; names it.
    """
    content = _bytes_of(path)
    # From memory, where a cut off file is refused: from a file OpenCV makes a picture of its beginning, grey below.
    how = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), how) if content else None
    if picture is None:
        raise _unreadable(path, f"{len(content)} bytes that are none, or a part of one")
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def _bytes_of(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise _unreadable(path, str(error.strerror)) from None


def _unreadable(path: Path, got: str) -> UnreadableSequence:
    # Pictures of OTB lie in NAME/img.
    return UnreadableSequence(f"{short(path, 3)}: expected a whole picture, got {got}")


class SequenceEpisode:
    """See ``scenarios.scenario.Episode``. Pictures are read when they are needed; none is kept but the latest.

    A recording of tracks is one without pictures.

    The target's state is ``in`` where it has a box, else ``out``: layouts do not tell whether it is hidden or outside
    the picture. What is in metres is NaN.
    """

    closed_loop = False

    def __init__(self, sequence: BoxedSequence) -> None:
        """Read the first picture, if there is one. Raises UnreadableSequence if it is broken."""
        self._sequence = sequence
        self.frame_count = len(sequence.pictures)
        self.rate_hz = sequence.rate_hz
        self._next = 0
        self._last_seen = 0
        height, width = read_picture(sequence.pictures[0]).shape[:2] if sequence.pictures else (1, 1)
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
