"""One target of a file of many: which one is followed, and its labels in the pictures of a sequence.

Once for all layouts: the target of an id or name that the user gives, else the one with a label in most pictures; where
it has none it is not seen, and no file says why.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.layouts.layout import Target
from benchmarks.data.pictures import read_picture, short
from benchmarks.data.sequences import Labelled
from sim.checks import check
from trackers.regions import Mask


def followed(target: Target, file: Path, ids: Sequence[Any]) -> tuple[str, NDArray[np.int64]]:
    """Return the target that is followed, and which of the labels (R,) of a file are its own.

    Args:
        ids: (R,) target of each label, maybe with a name in place of a number.

    Raises:
        ValueError: for a file without labels and an unknown target.
    """
    check(short(file, 3), len(ids) > 0, "labels of at least one target", "none")
    known, lines = np.unique(np.array(ids), return_counts=True)
    names = [str(each) if isinstance(each, str) else f"{each:.0f}" for each in known]
    chosen = names[int(np.argmax(lines))] if target is None else str(target)
    check("target", chosen in names, f"one in {short(file, 3)}: {', '.join(names[:10])}", target)
    return chosen, np.flatnonzero(np.array(ids) == known[names.index(chosen)])


def of_one_target(
    name: str,
    file: Path,
    pictures: Mapping[int, Path],
    target: Target,
    frames: NDArray[np.int64],
    ids: NDArray[np.int64],
    lines: NDArray[np.int64],
    box_xyxy: NDArray[np.float64],
    tags: NDArray[np.str_] | None = None,
    mask_of: Callable[[int], Mask] | None = None,
    **more: Any,
) -> Labelled:
    """Return the labels of the target that is followed, of a sequence whose pictures a file's R labels number.

    Args:
        name: of the sequence. pictures: by their numbers, in order; some may be missing.
        frames: (R,) number of each label's picture. ids: (R,) of its target.
        lines: (R,) its place in the file, for messages.
        box_xyxy: (R, 4). tags: (R,), see ``Labelled``.
        mask_of: returns the mask of a label by its place among the R; None: files have no masks.
        more: of the ``Labelled``.

    Raises:
        ValueError: see ``followed`` and ``in_pictures``.
    """
    chosen, mine = followed(target, file, ids.tolist())
    held, places, notes = in_pictures(file, frames[mine], list(pictures), lines[mine])
    mine, count = mine[held], len(pictures)
    boxes, words = np.full((count, 4), np.nan), np.full(count, "", "<U10")
    boxes[places], words[places] = box_xyxy[mine], "" if tags is None else tags[mine]
    if mask_of is not None:
        masks = dict(zip(places.tolist(), map(mask_of, mine.tolist()), strict=True))
        more["masks"] = [masks.get(place) for place in range(count)]
    place = np.array(list(pictures))
    name = f"{name}-{chosen}"
    return Labelled(name, file, list(pictures.values()), boxes, words, place=place, notes=notes, **more)


def check_mask_sizes(file: Path, sizes: Iterable[Sequence[int]], picture: Path) -> None:
    """Raise ValueError for masks of another size (height, width) than a picture's."""
    height, width = read_picture(picture).shape[:2]
    other = next((tuple(size) for size in sizes if tuple(size) != (height, width)), None)
    got = "" if other is None else f"one of {other[1]} x {other[0]}"
    check(short(file, 3), other is None, f"masks of {width} x {height} pixels, as the pictures have", got)


def in_pictures(
    file: Path, frames: NDArray[Any], pictures: Sequence[int], lines: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], tuple[str, ...]]:
    """Return which labels (L,) of a target have a picture, and their places in the sequence (L,); and notes.

    Args:
        frames: (R,) numbers of the pictures of the labels. pictures: (F,) numbers of those that there are, in order;
            where one is missing between others its label is left out.
        lines: (R,) numbers in the file, for messages.

    Raises:
        ValueError: for a frame before the first picture or after the last one, and two labels of one frame.
    """
    numbers = np.array(pictures)
    held = with_picture(file, frames, numbers, lines)
    _, firsts, counts = np.unique(frames, return_index=True, return_counts=True)
    again = int(np.argmax(counts))
    check(
        short(file, 3), counts[again] == 1, "one label a frame of a target", f"two of frame {frames[firsts[again]]:g}"
    )
    gone = len(frames) - len(held)
    notes = (f"{short(file, 3)}: {gone} labels of frames without a picture are left out",) if gone else ()
    return held, np.searchsorted(numbers, frames[held]), notes


def with_picture(
    file: Path, frames: NDArray[Any], numbers: NDArray[np.int64], lines: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return which labels (L,) have a picture, of ``in_pictures``' ``frames``, ``numbers`` and ``lines``.

    Raises:
        ValueError: for a frame before the first picture or after the last one.
    """
    beyond = (frames < numbers[0]) | (frames > numbers[-1])
    wanted = f"frames from {numbers[0]} to {numbers[-1]}, of which there are pictures"
    first = int(np.argmax(beyond))
    check(f"{short(file, 3)}, line {lines[first]}", not beyond.any(), wanted, f"{frames[first]:g}")
    return np.flatnonzero(np.isin(frames, numbers))
