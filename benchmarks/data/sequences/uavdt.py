"""UAVDT: ``NAME/img000001.jpg …`` and a file of boxes ``NAME_gt.txt`` of one target, or of all (DET and MOT).

Du et al., The unmanned aerial vehicle benchmark: object detection and tracking, ECCV 2018, and the README files of its
toolkits. The pictures are in the data set's folder, in ``UAV-benchmark-S`` or in ``UAV-benchmark-M``; the boxes in
``anno`` (single target: ``left,top,width,height``, a line a picture) or ``GT``, also those inside the toolkits'
folders ``UAV-benchmark-SOT_v1.0`` and ``UAV-benchmark-MOTD_v1.0``.

Lines of DET, ``NAME_gt_whole.txt``, are ``frame,id,left,top,width,height,out_of_view,occlusion,class``; those of MOT,
``NAME_gt.txt``, begin with the same six numbers. One target of them is followed from its first picture on, by default
the one that is seen in most pictures; where it has no line it is not seen. Files of attributes (``att``) describe whole
sequences and are not read. The README files do not say where the first pixel is: 1, 1 is taken, as usual in MATLAB,
in which the toolkits are written.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.printable import printable
from benchmarks.data.sequences.box_files import checked_boxes, read_rows
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
_TOOLKITS = (".", "UAV-benchmark-SOT_v1.0", "UAV-benchmark-MOTD_v1.0")
_PICTURES = (".", "UAV-benchmark-S", "UAV-benchmark-M")
_ENDINGS = ("_gt_whole.txt", "_gt.txt")
"""Of files of boxes; the first has the targets that MOT leaves out too."""
_LINE = "left,top,width,height, or frame,id,left,top,width,height and three or four more numbers"


def is_uavdt(folder: Path) -> bool:
    """Return whether a folder is a data set of this layout, or the pictures of one sequence in it."""
    return folder.is_dir() and (bool(_boxes(folder)) or _boxes_of(folder) is not None)


def find_uavdt(folder: Path, target: int | None = None) -> list[Unread]:
    """Return the sequences of a folder.

    Args:
        target: id of the target that is followed, where a file holds several; None = the one seen most.

    Raises:
        ValueError: if there are none.
    """
    own = _boxes_of(folder)
    if own is not None:
        return [Unread(printable(folder.name), partial(_read, own, folder, target))]
    found = _boxes(folder)
    check(short(folder), bool(found), "boxes in anno/NAME_gt.txt or GT/NAME_gt_whole.txt", "none")
    return [Unread(printable(name), partial(_read_in_set, file, folder, name, target)) for name, file in found.items()]


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


def _read_in_set(file: Path, folder: Path, name: str, target: int | None) -> BoxedSequence:
    return _read(file, _pictures(folder, name), target)


def _read(file: Path, folder: Path, target: int | None) -> BoxedSequence:
    name, pictures = printable(folder.name), numbered_pictures(folder)
    rows = read_rows(file, (4, 9, 10), _LINE, len(pictures))
    if rows.shape[1] == 4:
        return boxed_sequence(name, list(pictures.values()), checked_boxes(file, rows), file, FIRST)
    frames, identities = _whole(file, rows[:, 0], "frame"), _whole(file, rows[:, 1], "id")
    boxes = checked_boxes(file, rows[:, 2:6])
    followed = _followed(file, identities, target)
    mine = identities == followed
    strangers = np.flatnonzero(~np.isin(frames, list(pictures)))
    for line in strangers[:1]:
        wanted = f"a frame from {min(pictures)} to {max(pictures)}, of which there are pictures"
        check(f"{short(file)}, line {line + 1}", False, wanted, frames[line])
    twice = len(np.unique(frames[mine])) < int(mine.sum())
    check(short(file), not twice, f"one line a frame of id {followed}", "two of one frame")
    first = int(frames[mine].min())
    box_of = dict(zip(frames[mine].tolist(), boxes[mine], strict=True))
    shown = {number: picture for number, picture in pictures.items() if number >= first}
    lost = np.full(4, np.nan)
    track = np.array([box_of.get(number, lost) for number in shown])
    return boxed_sequence(f"{name}-{followed}", list(shown.values()), track, file, FIRST)


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
