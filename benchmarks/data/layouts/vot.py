"""VOT: ``NAME/color/00000001.jpg …`` and ``NAME/groundtruth.txt``, a region a line; and ``export --format vot``.

The VOT toolkit 0.9, https://github.com/votchallenge/toolkit (``vot/dataset/common.py``, ``docs/details/dataset.rst``).
``NAME/sequence`` holds properties, a line ``name=value`` each: ``channels.color``, the pattern of the pictures, counted
from 1 (default ``color/%08d.jpg``; else the channel ``ir`` or ``depth``), ``fps`` and ``length``. Sequences of VOT2013
to VOT2017 without that file have their pictures beside ``groundtruth.txt``. Regions are rectangles, polygons and masks,
see ``trackers.regions``; the box around each counts, and its pixels where all are masks. A code in place of a region,
NaN, and an empty mask mean that the target is not there; the toolkit takes lines that are missing at the end for
unknown, and so does this.
``groundtruth_NAME.txt`` of VOTS are targets, each of which is a sequence of its own.

Tags are files ``out_of_view.tag``, ``occlusion.tag`` … (``.label`` before 2018) with 0 or 1 for each picture, missing
ones 0. ``out_of_view`` and ``full_occlusion`` say why there is no region; ``occlusion`` says that the target is hidden,
at least in part, with a region or without. A region counts whatever tags say, as in the toolkit. Other tags, and files
``.value``, are not read.

The top left corner of the picture is at 0, 0, as the toolkit takes it. Boxes of VOT-LT2018 end at the border, at 1 and
at width + 1, as if it were at 1, 1; nothing tells which sequences do. So a box that reaches beyond the border says that
the border cuts the target only where the property ``boxes`` of our export is ``whole``.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.box_files import lines_to_the_last, rate_of, read_properties, text_lines
from benchmarks.data.layouts.layout import Source, Target, check_one_target, folders_with, layout
from benchmarks.data.pictures import short
from benchmarks.data.sequences import OCCLUDED, OUT, UNLABELLED, Labelled
from sim.checks import check
from trackers.regions import Mask, Region, read_region

_USUAL, _OLD = "color/%08d.jpg", "%08d.jpg"
_CHANNELS = ("color", "ir", "depth")


@layout("vot", "NAME/groundtruth.txt or groundtruth_TARGET.txt, beside NAME/sequence, NAME/color/ or its pictures")
def find_vot(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for folder in folders_with(path, "groundtruth*.txt"):
        pattern = _pattern_of(folder)
        if pattern is not None:
            one = folder / "groundtruth.txt"
            files = [one] if one.is_file() else sorted(folder.glob("groundtruth_*.txt"))
            for file in files:
                target = file.stem.removeprefix("groundtruth").strip("_")
                name = f"{folder.name}-{target}" if target else folder.name
                yield Source(name, (folder, folder / Path(pattern).parent, file), partial(_read, name, file, pattern))


def _pattern_of(folder: Path) -> str | None:
    """Return the pattern of a sequence's pictures; None for a folder that is no sequence of VOT."""
    try:
        properties = read_properties(folder / "sequence")
    except ValueError:
        properties = {"channels.color": _USUAL}  # What is wrong is named where the sequence is read.
    if properties or (folder / "color").is_dir():
        found = next(filter(None, (properties.get(f"channels.{name}") for name in _CHANNELS)), _USUAL)
        found = found.replace("\\", "/")
        return found if Path(found).suffix else f"{found.rstrip('/')}/{_OLD}"
    # Of GOT-10k, whose pictures lie beside the boxes too.
    other = (folder / "absence.label").is_file()
    return _OLD if (folder / (_OLD % 1)).is_file() and not other else None


def _read(name: str, file: Path, pattern: str, target: Target) -> Labelled:
    check_one_target(target)
    folder, lines = file.parent, lines_to_the_last(file)
    properties = read_properties(folder / "sequence")
    pictures = _pictures(folder, pattern, properties.get("length", ""))
    check(short(file), len(lines) <= len(pictures), f"{len(pictures)} regions at most, one a picture", len(lines))
    boxes = np.full((len(pictures), 4), np.nan)
    regions: list[Region | None] = [None] * len(pictures)
    for k, line in enumerate(lines):
        try:
            region = read_region(line)
        except ValueError as error:
            raise ValueError(f"{short(file)}, line {k + 1}: {error}") from None
        box_xyxy = region.box_xyxy
        if box_xyxy is not None and (box_xyxy[2:] > box_xyxy[:2]).all():
            boxes[k], regions[k] = box_xyxy, region
    masks = [each if isinstance(each, Mask) else None for each in regions]
    masks = masks if any(masks) and masks == regions else []
    none = np.isnan(boxes[:, 0])
    outside, hidden, occluded = (
        _tag(folder, each, len(pictures)) for each in ("out_of_view", "full_occlusion", "occlusion")
    )
    rest = np.arange(len(pictures)) >= len(lines)
    tags = np.select([rest, outside & none, (hidden & none) | occluded], [UNLABELLED, OUT, OCCLUDED], "")
    rate_hz = rate_of(properties.get("exact_fps", properties.get("fps", "")))
    return Labelled(
        name, file, pictures, boxes, tags, whole=properties.get("boxes") == "whole", rate_hz=rate_hz, masks=masks
    )


def _pictures(folder: Path, pattern: str, length: str) -> list[Path]:
    """Return the pictures of a pattern: as many as the properties say, else those that there are."""
    try:
        pattern % 1
        count = int(length or 0)
    except (TypeError, ValueError):
        wanted = "a pattern such as color/%08d.jpg and a whole number as length"
        raise ValueError(f"{short(folder / 'sequence')}: expected {wanted}, got {pattern!r}, {length!r}") from None
    while not length and (folder / (pattern % (count + 1))).is_file():
        count += 1
    check(short(folder), count > 0, f"pictures {pattern}, from 1 on", "none")
    last = folder / (pattern % count)
    check(short(folder / "sequence"), last.is_file(), f"as length the number of pictures {pattern}", count)
    return [folder / (pattern % number) for number in range(1, count + 1)]


def _tag(folder: Path, name: str, count: int) -> NDArray[np.bool_]:
    """Return a tag (F,): which lines are 1, as the toolkit reads it."""
    found = np.zeros(count, bool)
    for file in (folder / f"{name}{ending}" for ending in (".tag", ".label")):
        if file.is_file():
            lines = text_lines(file)[:count]
            found[: len(lines)] = [line.strip() == "1" for line in lines]
    return found
