"""Formats of predictions: the answers on one sequence from a file.

========= ===================================================================================== ====================
format    a sequence's file                                                                     pixels begin at
========= ===================================================================================== ====================
``vot``   a line a frame: a region, see ``trackers.regions``; separated by comma, tab or spaces 0, 0
``otb``   the same, as OTB counts                                                               1, 1
``mot``   a row a track and frame, see ``benchmarks.data.mot_text``                             1, 1
``mots``  likewise with masks; frames count from 0, or as the first picture of a real sequence  0, 0
``coco``  JSON results of COCO or TAO for all sequences, see ``benchmarks.data.coco_json``      0, 0
========= ===================================================================================== ====================

A line says that there is no answer by a number alone (1: the tracker was started here, 0 or 2: none), by NaN, by
``-1,-1,-1,-1``, by no width or height, or by nothing. Confidences stand beside ``NAME.txt`` in
``NAME_confidence.value``, a line a frame, as the VOT toolkit writes them; in MOT -1 is none.

Frames are the pictures that there are, in their order: where the numbers of a real sequence's pictures have a gap, the
rows of ``mot`` and ``mots`` count on without it.
"""

from __future__ import annotations

import hashlib
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from benchmarks.contract.text import counted
from benchmarks.data.box_files import BETWEEN, numbers_of, text_lines
from benchmarks.data.coco_json import NO_TRACK, Annotations, read_annotations, read_results
from benchmarks.data.mot_text import FIRST, MotRows, read_mot
from benchmarks.data.mots_text import MotsRows, has_masks, read_mots
from benchmarks.data.pictures import short
from sim.checks import check
from trackers.regions import Rectangle, Region, Special, read_region
from trackers.types import Estimate, Track

LINES = {"vot": 0.0, "otb": 1.0}
"""Format with a line a frame → coordinate of the top left corner of the picture."""
FORMATS = (*LINES, "mot", "mots", "coco")
_NUMBER = re.compile(r"\d+$")


@dataclass(frozen=True)
class SequenceFile:
    """Where the predictions of a sequence are.

    Attributes:
        sequence: its name. frame_count: of the episode.
        skipped: number of pictures before the episode's first one; after: after its last one. Files may have these.
        path: of the file; None if there is none. format: of ``FORMATS``.
        annotations: file that the numbers of pictures in ``coco`` are of.
        pictures: ``FOLDER/NAME`` of each frame's picture of a real sequence; () of an episode, whose pictures are those
            of the folder of its name, in their order.
    """

    sequence: str
    frame_count: int
    skipped: int = 0
    after: int = 0
    path: Path | None = None
    format: str = ""
    annotations: Path | None = None
    pictures: tuple[str, ...] = ()

    @property
    def folder(self) -> str:
        """Name of the folder of its pictures in files of annotations."""
        return self.pictures[0].partition("/")[0] if self.pictures else self.sequence

    @property
    def whole(self) -> int:
        """Number of all pictures of its files."""
        return self.skipped + self.frame_count + self.after


@dataclass(frozen=True)
class Predictions:
    """The answers on F frames of a sequence.

    Attributes:
        regions: (F,) of one target; None of many.
        confidence: (F,) that the target is in view, NaN where it is not said.
        tracks: frame → tracks of many targets.
        masks: frame → of each of its tracks the mask, see ``codec.mask_of``; None where files have none.
        detections: frame → what was found, without identities.
        digest: of all of it.
    """

    digest: str
    regions: Sequence[Region] | None = None
    confidence: Sequence[float] = ()
    tracks: Mapping[int, list[Track]] | None = None
    masks: Mapping[int, list[Mapping[str, Any]]] | None = None
    detections: Mapping[int, list[Track]] | None = None


def read_predictions(file: SequenceFile) -> Predictions:
    """Return what a file says of its sequence.

    Raises:
        ValueError: for a file that is broken, of another format, or of frames that the sequence does not have; names
            file and line.
    """
    assert file.path is not None
    if file.format in LINES:
        return _read_lines(file, file.path)
    read = {"mot": _read_mot, "mots": _read_mots, "coco": _read_coco}[file.format]
    return read(file, file.path)


def format_of(path: Path) -> str:
    """Return the format of a file by its ending and its first lines; one without a line has no row.

    A line of six numbers or more is a row of MOT if the first two, frame and identity, are whole, else a polygon.
    """
    if path.suffix == ".json":
        return "coco"
    first = next((line for line in text_lines(path) if line.strip()), "")
    if has_masks(path):
        return "mots"
    numbers = numbers_of(first)
    is_row = len(numbers) >= 6 and all(each.is_integer() for each in numbers[:2])
    return "mot" if is_row or not first else "vot"


def sequences_in(path: Path, annotations: Path | None) -> list[str]:
    """Return the folders of the pictures that JSON results are of."""
    folders, numbers = _annotations_in(annotations).folders, set(read_results(path).image_id.tolist())
    return sorted(name for name, own in folders.items() if not numbers.isdisjoint(own.values()))


def _read_lines(file: SequenceFile, path: Path) -> Predictions:
    lines, where = text_lines(path), short(path, 4)
    while len(lines) > file.whole and not lines[-1].strip():
        lines.pop()
    fits = len(lines) in (file.frame_count, file.whole)
    check(where, fits, f"{file.whole} lines, one a frame of {file.sequence}", len(lines))
    regions = [_region(f"{where}, line {number}", line, file.format) for number, line in enumerate(lines, start=1)]
    beside = path.with_name(f"{path.stem}_confidence.value")
    confidence = np.full(len(lines), np.nan)
    if beside.is_file():
        values = text_lines(beside)
        check(short(beside, 4), len(values) == len(lines), f"{len(lines)} lines, as {path.name} has", len(values))
        for k, value in enumerate(values):
            confidence[k] = _probability(f"{short(beside, 4)}, line {k + 1}", value)
    begin = 0 if len(lines) == file.frame_count else file.skipped
    own = slice(begin, begin + file.frame_count)
    digest = _digest(file.format, *map(str, regions[own]), confidence[own].tolist())
    return Predictions(digest, regions[own], confidence[own].tolist())


def _region(where: str, line: str, name: str) -> Region:
    numbers = numbers_of(line)
    if not line.strip() or numbers == [-1.0] * 4 or (len(numbers) == 4 and np.isinf(numbers).any()):
        return Special()
    try:
        region = read_region(",".join(BETWEEN.split(line.strip())))
    except ValueError as error:
        raise ValueError(f"{where}: {str(error).partition(': ')[2]}") from None
    if name == "vot" or isinstance(region, Special):
        return region
    check(where, isinstance(region, Rectangle), "left,top,width,height, as OTB has them", repr(line[:80]))
    assert isinstance(region, Rectangle)
    return Rectangle(region.box_xyxy - LINES[name])


def _probability(where: str, text: str) -> float:
    """Return the number of a line, NaN for none."""
    numbers = numbers_of(text) if text.strip() else [float("nan")]
    good = len(numbers) == 1 and (np.isnan(numbers[0]) or 0.0 <= numbers[0] <= 1.0)
    check(where, good, "a number from 0 to 1, or nothing", repr(text[:80]))
    return numbers[0]


def _read_mot(file: SequenceFile, path: Path) -> Predictions:
    rows, tracks = read_mot(path), defaultdict[int, list[Track]](list)
    for k, frame in _own_rows(file, path, rows, FIRST):
        confidence = float(rows.confidence[k])
        none = confidence == -1 or np.isnan(confidence)
        wanted = "a confidence from 0 to 1, or -1 for none"
        check(f"{short(path, 4)}, line {rows.line[k]}", none or 0 <= confidence <= 1, wanted, f"{confidence:g}")
        tracks[frame].append(_track(int(rows.identity[k]), rows.box_xyxy[k], None if none else confidence))
    return Predictions(_digest("mot", rows.frame, rows.identity, rows.box_xyxy, rows.confidence), tracks=tracks)


def _read_mots(file: SequenceFile, path: Path) -> Predictions:
    rows = read_mots(path)
    boxes = rows.box_xyxy
    tracks, masks = defaultdict[int, list[Track]](list), defaultdict[int, list[Mapping[str, Any]]](list)
    # MOTS Challenge counts its pictures from 1, KITTI from 0.
    first = max(_order(PurePosixPath(file.pictures[0]).name)[0] - file.skipped, 0) if file.pictures else 0
    for k, frame in _own_rows(file, path, rows, first):
        if (boxes[k, 2:] > boxes[k, :2]).all():
            tracks[frame].append(_track(int(rows.identity[k]), boxes[k], None))
            masks[frame].append(rows.runs[k])
    return Predictions(_digest("mots", rows.frame, rows.identity, rows.runs), tracks=tracks, masks=masks)


def _own_rows(file: SequenceFile, path: Path, rows: MotRows | MotsRows, first: int) -> Iterator[tuple[int, int]]:
    """Yield place and frame of the rows of an episode's own pictures, of which all of its files have numbers.

    Args:
        first: number of the first picture.

    Raises:
        ValueError: for the number of no picture; names file and line.
    """
    last = first + file.whole - 1
    for k, number in enumerate(rows.frame.tolist()):
        wanted = f"a frame of {first} to {last}"
        check(f"{short(path, 4)}, line {rows.line[k]}", first <= number <= last, wanted, number)
        frame = number - first - file.skipped
        if 0 <= frame < file.frame_count:
            yield k, frame


def _read_coco(file: SequenceFile, path: Path) -> Predictions:
    results, said, where = read_results(path), _annotations_in(file.annotations), short(path, 4)
    own = _own_frames(file, said)
    fit = bool(own) if file.pictures else len(own) == file.frame_count
    wanted = f"{file.frame_count} pictures of {file.sequence} in its annotations"
    check(where, fit, wanted, len(own))
    tracks: dict[int, list[Track]] = defaultdict(list)
    chosen = np.flatnonzero(np.isin(results.image_id, list(own)))
    seen = set[tuple[int, int]]()
    for k in chosen.tolist():
        at, score = f"{where}, entry {k + 1}", float(results.score[k])
        check(at, 0 <= score <= 1, "a score from 0 to 1", f"{score:g}")
        number, identity = int(results.image_id[k]), int(results.track_id[k])
        once = identity == NO_TRACK or (number, identity) not in seen
        check(at, once, "each track_id once in a picture", f"{identity} again in picture {number}")
        seen.add((number, identity))
        kind = said.categories.get(int(results.category_id[k]))
        tracks[own[number]].append(_track(max(identity, 0), results.box_xyxy[k], score, kind))
    identities = results.track_id[chosen]
    parts = (results.image_id, results.category_id, results.box_xyxy, results.score, results.track_id)
    digest = _digest("coco", *(each[chosen] for each in parts))
    if (identities == NO_TRACK).any():
        mixed = int((identities != NO_TRACK).sum())
        check(where, not mixed, "a track_id in each result, or in none", f"{counted(mixed, 'result')} with one")
        return Predictions(digest, detections=tracks)
    return Predictions(digest, tracks=tracks)


def _track(identity: int, box_xyxy: np.ndarray, confidence: float | None, kind: str | None = None) -> Track:
    """Return a track whose position is the middle of its box; a box without area is a position alone."""
    box = box_xyxy if (box_xyxy[2:] > box_xyxy[:2]).all() else None
    place_px = 0.5 * (box_xyxy[:2] + box_xyxy[2:])
    return Track(identity, Estimate(place_px, box, in_view_probability=confidence), kind, confidence=confidence)


def _own_frames(file: SequenceFile, said: Annotations) -> dict[int, int]:
    """Return number of a picture → frame of a sequence, of those pictures that annotations name.

    Frames of an episode are in the order of the numbers in the names of its pictures.
    """
    numbers = said.folders.get(file.folder, {})
    names = [PurePosixPath(each).name for each in file.pictures] or sorted(numbers, key=_order)
    return {numbers[name]: frame for frame, name in enumerate(names) if name in numbers}


def _order(name: str) -> tuple[int, str]:
    stem = PurePosixPath(name).stem
    match = _NUMBER.search(stem)
    return int(match[0]) if match else -1, stem


def _annotations_in(file: Path | None) -> Annotations:
    wanted = "the file of annotations that the image_ids of JSON results are of"
    check("annotations", file is not None, wanted, "none")
    assert file is not None
    check("annotations", file.is_file(), "a file that exists", repr(str(file)))
    said = read_annotations(file)
    check(
        short(file, 3), said is not None, 'annotations with "images": [{"id": 1, "file_name": "NAME/0.png"}, …]', "none"
    )
    assert said is not None
    return said


def _digest(*parts: object) -> str:
    content = hashlib.sha256()
    for part in parts:
        content.update(np.ascontiguousarray(part).tobytes() if isinstance(part, np.ndarray) else repr(part).encode())
    return content.hexdigest()[:10]
