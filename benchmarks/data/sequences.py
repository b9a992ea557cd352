"""Real sequences: pictures of one target with its box where it is seen, and the episode that shows them.

What finds and reads them is in ``benchmarks.data.layouts``.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import USUAL_RATE_HZ, UnreadableSequence
from benchmarks.contract.sequence_truth import SequenceTruth, truth_in_pixels
from benchmarks.contract.text import printable
from benchmarks.data.pictures import Picture, bytes_of, read_picture, short
from scenarios.scenario import Frame
from sim.checks import check
from trackers.regions import Mask
from trackers.types import CameraCommand, CameraModel, Observation, Start

USUAL_FOCAL = 1.2
"""Focal length over the longer side of the picture where none is known: COLMAP's ``default_focal_length_factor``
(Schönberger, Frahm, Structure-from-motion revisited, CVPR 2016, and its documentation).
"""
TARGET = "target"
IN, PARTIAL, OCCLUDED, OUT, UNSEEN, UNLABELLED = "in", "partial", "occluded", "out", "unseen", "unlabelled"
"""What files say of the target in a picture: it has a box; and the border cuts it; it is hidden, perhaps in part;
outside the picture; without a box, and no file says why; nothing."""


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
        state: (F,) words, see ``IN``; by default ``in`` where there is a box, else ``unseen``.
        place: (F,) places of the pictures among all that were taken at the rate; by default without gaps.
        skipped, after: numbers of pictures of its files before the first one, and after the last one.
        masks: (F,) the target's pixels; None where it is not seen; () where files have no masks.
    """

    name: str
    pictures: tuple[Picture, ...]
    box_xyxy: NDArray[np.float64]
    rate_hz: float = USUAL_RATE_HZ
    number: int = 0
    notes: tuple[str, ...] = ()
    state: NDArray[np.str_] = field(default_factory=lambda: np.empty(0, "<U10"))
    place: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    skipped: int = 0
    after: int = 0
    masks: tuple[Mask | None, ...] = ()

    def __post_init__(self) -> None:
        """Fill in the states and places that are not given."""
        if not len(self.state):
            object.__setattr__(self, "state", np.where(np.isnan(self.box_xyxy).any(axis=1), UNSEEN, IN))
        if not len(self.place):
            object.__setattr__(self, "place", np.arange(len(self.box_xyxy)))

    @cached_property
    def fingerprint(self) -> str:
        """Hash of the boxes, of the rate, and of the names and bytes of the pictures: rows of others are outdated.

        Raises:
            UnreadableSequence: if a picture is gone.
        """
        content = hashlib.sha256(f"{self.name}\0{self.rate_hz}".encode())
        content.update(np.ascontiguousarray(self.box_xyxy).tobytes())
        # Nothing of sequences with boxes alone, whose rows are older than states and places.
        usual = BoxedSequence(self.name, self.pictures, self.box_xyxy)
        content.update("".join(f"\0{mask}" for mask in self.masks).encode())
        for mine, other in ((self.state, usual.state), (self.place, usual.place)):
            content.update(b"" if np.array_equal(mine, other) else repr(mine.tolist()).encode())
        for picture in self.pictures:
            content.update(os.fsencode(picture.name) + hashlib.sha256(bytes_of(picture)).digest())
        return content.hexdigest()[:10]


@dataclass(frozen=True, eq=False)
class Labelled:
    """What files say of one target in F pictures, before any picture is read.

    Attributes:
        name: of the sequence.
        file: that the boxes are from.
        pictures: (F,) files, in order of time.
        box_xyxy: (F, 4) pixels, from the top left corner of the picture; NaN where there is none.
        tags: (F,) what else is said: ``partial``, ``occluded``, ``out``, ``unlabelled``; "" where nothing is. A box of
            an ``out`` or ``unlabelled`` picture does not count.
        whole: whether boxes reach beyond the border where it cuts the target, which is then ``partial``.
        rate_hz: frames a second; 0 where files do not tell.
        place, masks: see ``BoxedSequence``.
        notes: what a user should know, a line each.
    """

    name: str
    file: Path
    pictures: Sequence[Picture]
    box_xyxy: NDArray[np.float64]
    tags: NDArray[np.str_] | None = None
    whole: bool = False
    rate_hz: float = 0.0
    place: NDArray[np.int64] | None = None
    notes: tuple[str, ...] = ()
    masks: Sequence[Mask | None] = ()


def boxed_sequence(labelled: Labelled) -> BoxedSequence:
    """Return a sequence; it begins with the first picture that has a box, which starts trackers.

    Of a box without area, or wholly outside the picture, nothing is seen. What follows the last label is left out.

    Raises:
        ValueError: if there are not as many boxes as pictures, no box at all, or boxes in other units than pixels; or
            if the first picture cannot be read.
    """
    name, where = printable(labelled.name), short(labelled.file)
    pictures, box_xyxy = labelled.pictures, labelled.box_xyxy
    check(where, len(box_xyxy) == len(pictures), f"{len(pictures)} boxes, one a picture", len(box_xyxy))
    tags = np.full(len(pictures), "") if labelled.tags is None else labelled.tags
    none = np.isin(tags, (OUT, UNLABELLED)) | (box_xyxy[:, 2:] <= box_xyxy[:, :2]).any(axis=1)
    box_xyxy = np.where(none[:, None], np.nan, box_xyxy)
    given = ~np.isnan(box_xyxy[:, 0])
    check(where, bool(given.any()), "a box in at least one picture", "none")
    height, width = read_picture(pictures[0]).shape[:2]
    size, corner_px, size_px = f"the picture of {width} x {height}", box_xyxy[:, :2], box_xyxy[:, 2:] - box_xyxy[:, :2]
    small = np.nanmax(np.abs(np.concatenate([corner_px, size_px]))) <= 1.0
    check(where, not small, f"boxes in pixels of {size}", "numbers of at most 1, as of shares of it")
    seen = np.all((box_xyxy[:, :2] < (width, height)) & (box_xyxy[:, 2:] > 0), axis=1)
    check(where, bool(seen.any()), f"a box that meets {size}", "none")
    outside, begin, notes = given & ~seen, int(np.argmax(seen)), list(labelled.notes)
    if outside.any():
        first, count = int(np.argmax(outside)) + 1, int(outside.sum())
        notes.append(
            f"{name}: {count} of {len(given)} boxes lie wholly outside {size}, the first of picture {first}: not seen"
        )
    low, high, limit = corner_px[seen], size_px[seen], (width + 1, height + 1)
    if (high > low + 1).all() and (high <= limit).all() and (low + high > limit).any():
        reach = "reach outside the picture as left,top,width,height, and would fit as left,top,right,bottom"
        notes.append(f"{name}: the boxes {reach}")
    if begin:
        notes.append(f"{name}: the target is first seen in picture {begin + 1} of {len(given)}, where trackers start")
    is_cut = labelled.whole & seen & ((box_xyxy < 0) | (box_xyxy > (width, height, width, height))).any(axis=1)
    tags = np.where((tags == PARTIAL) & ~seen, "", tags)
    state = np.select([is_cut, tags != "", outside & labelled.whole, ~seen], [PARTIAL, tags, OUT, UNSEEN], IN)
    known = state != UNLABELLED
    check(where, len(pictures) == 1 or known.sum() > 1, "labels of at least two pictures", int(known.sum()))
    end = len(state) - int(np.argmax(known[::-1]))
    return BoxedSequence(
        name,
        tuple(pictures[begin:end]),
        np.where(seen[:, None], box_xyxy, np.nan)[begin:end],
        labelled.rate_hz or USUAL_RATE_HZ,
        notes=tuple(notes),
        state=state[begin:end],
        place=np.empty(0, np.int64) if labelled.place is None else (labelled.place - labelled.place[begin])[begin:end],
        skipped=begin,
        after=len(pictures) - end,
        masks=tuple(labelled.masks[begin:end]),
    )


class PicturesEpisode:
    """What episodes of real pictures share, see ``scenarios.scenario.Episode``: no more than the pictures is known."""

    closed_loop = False

    def __init__(self, frame_count: int, rate_hz: float, width_px: int, height_px: int) -> None:
        self.frame_count, self.rate_hz = frame_count, rate_hz
        self._camera = CameraModel(width_px, height_px, USUAL_FOCAL * max(width_px, height_px))

    def map_of(self) -> Any:
        """See ``Episode``. None is known."""
        return None

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """See ``Episode``. Raises ValueError: the surroundings of a real picture are not known."""
        raise ValueError(f"scale: expected none for real pictures, which have no larger view, got {scale:g}")

    def normals(self) -> NDArray[np.float32]:
        """See ``Episode``. None are known, so all are 0."""
        return np.zeros((self._camera.height_px, self._camera.width_px, 3), np.float32)

    def close(self) -> None:
        """See ``Episode``. Nothing is open."""


class SequenceEpisode(PicturesEpisode):
    """See ``scenarios.scenario.Episode``. Pictures are read when they are needed; none is kept but the latest.

    A recording of tracks is one without pictures. Truth is that of ``SequenceTruth``.
    """

    def __init__(self, sequence: BoxedSequence, size_px: tuple[int, int] = (1, 1)) -> None:
        """Read the first picture, if there is one; else its width and height are ``size_px``.

        Raises:
            UnreadableSequence: if it is broken.
        """
        width, height = read_picture(sequence.pictures[0]).shape[1::-1] if sequence.pictures else size_px
        super().__init__(len(sequence.box_xyxy), sequence.rate_hz, width, height)
        self._sequence = sequence
        self._next = self._last_in = 0

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
        return Frame(Observation(picture, self._time_s(k), self._camera), self._truth(k))

    def _time_s(self, k: int) -> float:
        return float(self._sequence.place[k]) / self.rate_hz

    def _instance_map(self, k: int) -> NDArray[np.int32]:
        """Return 0 on the target's pixels, else -1; empty where no file has them."""
        masks, camera = self._sequence.masks, self._camera
        if not masks or self._sequence.state[k] == UNLABELLED:
            return np.empty((0, 0), np.int32)
        mask = masks[k]
        there = False if mask is None else mask.mask(camera.height_px, camera.width_px)
        return np.where(there, 0, np.full((camera.height_px, camera.width_px), -1)).astype(np.int32)

    def _truth(self, k: int) -> SequenceTruth:
        box_xyxy, state = self._sequence.box_xyxy[k], str(self._sequence.state[k])
        seen, gone = not np.isnan(box_xyxy).any(), state in (OUT, UNSEEN)
        self._last_in = self._last_in if gone else k
        return truth_in_pixels(
            SequenceTruth,
            k,
            self._time_s(k),
            (TARGET,),
            ("unknown",),
            box_xyxy[None].copy(),
            np.array([OUT if gone else state]),
            visible_fraction=np.array([np.nan if seen or state == UNLABELLED else 0.0]),
            frames_since_exit=np.array([k - self._last_in - 1 if gone else -1]),
            instance_map=self._instance_map(k),
            outside=np.array([state == OUT]),
        )
