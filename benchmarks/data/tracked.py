"""Real sequences of many targets: pictures with all boxes of MOT Challenge's truth, and the episode that shows them.

Layouts are those of ``layouts.mot``. Targets are pedestrians that count, class 1 with the seventh number 1; persons on
vehicles, resting persons, distractors and reflections (classes 2, 7, 8 and 12, and 6, vehicles without a motor, in
sequences called MOT20) are distractors, as in TrackEval's preprocessing; the others are none. Files without classes, as
of MOT15, have targets alone.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import USUAL_RATE_HZ
from benchmarks.contract.sequence_truth import DISTRACTOR, OTHER, truth_in_pixels
from benchmarks.contract.text import printable
from benchmarks.data.box_files import read_properties
from benchmarks.data.layouts.followed import with_picture
from benchmarks.data.layouts.mot import find_mot
from benchmarks.data.mot_text import rate_told, read_mot
from benchmarks.data.pictures import numbered_pictures, short
from benchmarks.data.sequences import BoxedSequence, SequenceEpisode
from scenarios.scenario import Frame
from scenarios.truth import Truth
from sim.checks import check
from trackers.types import CameraCommand, Observation, Start

TARGET_KIND, _ABSENT = "target", "absent"
_MOST = 10**6
"""Frames of a sequence, and pixels of a side of its pictures."""
_PEDESTRIAN, _DISTRACTORS, _OF_MOT20 = 1, (2, 7, 8, 12), (6,)


@dataclass(frozen=True, eq=False)
class TrackedSequence:
    """N objects in F pictures.

    Attributes:
        pictured: the pictures and their rate, without boxes; no picture where labels alone are known.
        size_px: width and height of the pictures, where there are none.
        names: (N,) of the objects. kinds: (N,) ``target``, or see ``benchmarks.judges.many.judge``.
        frame: (R,) of R boxes, from 0 on. object: (R,) of them. box_xyxy: (R, 4) pixels.
    """

    pictured: BoxedSequence
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    frame: NDArray[np.int64]
    object: NDArray[np.int64]
    box_xyxy: NDArray[np.float64]
    size_px: tuple[int, int] = (1, 1)

    @property
    def name(self) -> str:
        """Name of the sequence."""
        return self.pictured.name

    @cached_property
    def fingerprint(self) -> str:
        """See ``BoxedSequence.fingerprint``, with all boxes."""
        content = hashlib.sha256(f"{self.pictured.fingerprint}{self.names}{self.kinds}".encode())
        for each in (self.frame, self.object, self.box_xyxy):
            content.update(np.ascontiguousarray(each).tobytes())
        return content.hexdigest()[:10]


def read_tracked(
    paths: Sequence[Path], rate_hz: float | None, *, labels_serve: bool = False
) -> tuple[list[tuple[str, TrackedSequence]], list[str]]:
    """Return folder and sequence of all sequences of folders, and what is wrong with others, a line each.

    Args:
        rate_hz: frames a second; None = as files say.
        labels_serve: whether a sequence without pictures can be used.

    Raises:
        ValueError: for a folder that is missing or has none, two of one name, and if no sequence can be read.
    """
    found, unusable = list[tuple[str, TrackedSequence]](), list[str]()
    names = [printable(path.resolve().name) for path in paths]
    check("real", len(set(names)) == len(names), "folders of different names", ", ".join(names))
    for path, name in zip(paths, names, strict=True):
        check("real", path.is_dir(), "folders that exist", repr(printable(path)))
        sources = sorted(find_mot(path.resolve()), key=lambda each: printable(each.name))
        check(
            "real",
            bool(sources),
            "NAME/gt/gt.txt beside NAME/img1/, as of MOT Challenge",
            f"{str(path.resolve())!r}, without any",
        )
        for number, source in enumerate(sources):
            try:
                folder, directory, file = source.places
                found.append((name, _read(folder, directory, file, number, rate_hz, labels_serve)))
            except ValueError as error:
                unusable.append(str(error))
    if not found:
        raise ValueError(unusable[0])
    return found, unusable


def _read(
    folder: Path, directory: Path, file: Path, number: int, rate_hz: float | None, labels_serve: bool
) -> TrackedSequence:
    rows, told = read_mot(file), read_properties(folder / "seqinfo.ini")
    check(short(file, 3), len(rows.frame) > 0, "rows of targets", "none")
    size_px = (1, 1)
    if labels_serve and not directory.is_dir():
        words = [told.get(each, "") for each in ("seqLength", "imWidth", "imHeight")]
        good = all(word.isdecimal() and 0 < int(word) <= _MOST for word in words)
        wanted = "seqLength, imWidth and imHeight, whole numbers, as there are no pictures"
        check(short(folder / "seqinfo.ini"), good, wanted, ", ".join(map(repr, words)))
        count, size_px = int(words[0]), (int(words[1]), int(words[2]))
        pictures, numbers = {}, np.arange(1, count + 1)
    else:
        pictures = numbered_pictures(directory, gaps=True)
        numbers = np.array(list(pictures))
    held = with_picture(file, rows.frame, numbers, rows.line)
    classes = np.where(np.isnan(rows.further[:, 0]) | (rows.further[:, 0] < 0), _PEDESTRIAN, rows.further[:, 0])
    distractors = _DISTRACTORS + (_OF_MOT20 if folder.name.startswith("MOT20") else ())
    counts = (classes == _PEDESTRIAN) & (rows.confidence != 0)
    kinds = np.select([counts, np.isin(classes, distractors)], [TARGET_KIND, DISTRACTOR], OTHER)[held]
    # A target may count on some frames alone, and is another object on the others.
    known, objects = np.unique(np.column_stack([rows.identity[held].astype(str), kinds]), axis=0, return_inverse=True)
    rate = rate_hz or rate_told(told) or USUAL_RATE_HZ
    nowhere = np.full((len(numbers), 4), np.nan)
    place = numbers - numbers[0]
    pictured = BoxedSequence(printable(folder.name), tuple(pictures.values()), nowhere, rate, number, place=place)
    frames = np.searchsorted(numbers, rows.frame[held])
    names, kind = known.T.tolist()
    return TrackedSequence(pictured, tuple(names), tuple(kind), frames, objects.ravel(), rows.box_xyxy[held], size_px)


class TrackedEpisode(SequenceEpisode):
    """See ``SequenceEpisode``; of many targets, none of which is given."""

    def __init__(self, tracked: TrackedSequence) -> None:
        super().__init__(tracked.pictured, tracked.size_px)
        self._tracked = tracked
        self._rows = np.split(
            np.argsort(tracked.frame, kind="stable"),
            np.cumsum(np.bincount(tracked.frame, minlength=self.frame_count))[:-1],
        )

    @property
    def start(self) -> Start:
        """See ``Episode``. No picture without targets is known."""
        return Start(self._camera)

    def step(self, command: CameraCommand | None = None) -> Frame:
        """See ``SequenceEpisode``. Where there are no pictures they are black."""
        if self._tracked.pictured.pictures:
            return super().step(command)
        k, black = self._next, np.zeros((self._camera.height_px, self._camera.width_px, 3), np.uint8)
        self._next += 1
        return Frame(Observation(black, self._time_s(k), self._camera), self._truth(k))

    def _truth(self, k: int) -> Truth:  # type: ignore[override]
        count, mine = len(self._tracked.names), self._rows[k]
        box_xyxy, there = np.full((count, 4), np.nan), np.zeros(count, bool)
        box_xyxy[self._tracked.object[mine]], there[self._tracked.object[mine]] = self._tracked.box_xyxy[mine], True
        tracked, state = self._tracked, np.where(there, "in", _ABSENT)
        return truth_in_pixels(Truth, k, self._time_s(k), tracked.names, tracked.kinds, box_xyxy, state)
