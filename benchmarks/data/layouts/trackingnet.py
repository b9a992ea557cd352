"""TrackingNet: ``TRAIN_0/frames/NAME/0.jpg …`` and ``TRAIN_0/anno/NAME.txt``, a line a picture.

Müller et al., TrackingNet: a large-scale dataset and benchmark for object tracking in the wild, ECCV 2018, and its
README, https://github.com/SilvioGiancola/TrackingNet-devkit. Chunks are ``TRAIN_0`` to ``TRAIN_11`` and ``TEST``, of
whose sequences only the first picture has a box: nothing can be scored on them. Pictures are counted from 0. The top
left corner of the picture is at 0, 0 of ``left,top,width,height``, where the devkit draws boxes
(``generate_BB_frames.py``).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from benchmarks.data.box_files import corners_of, read_boxes
from benchmarks.data.layouts.layout import Source, Target, check_one_target, layout
from benchmarks.data.pictures import numbered_pictures, visible
from benchmarks.data.sequences import Labelled

FIRST = 0.0


@layout("trackingnet", "anno/NAME.txt beside frames/NAME/, in the folder or in TRAIN_0/ to TRAIN_11/")
def find_trackingnet(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for chunk in (path, *visible(path, "*")):
        for file in visible(chunk / "anno", "*.txt"):
            pictures = chunk / "frames" / file.stem
            if pictures.is_dir():
                yield Source(file.stem, (pictures, file), partial(_read, pictures, file))


def _read(folder: Path, file: Path, target: Target) -> Labelled:
    check_one_target(target)
    pictures = list(numbered_pictures(folder).values())
    _, boxes = read_boxes(file, len(pictures), keyed=False)
    return Labelled(file.stem, file, pictures, corners_of(boxes, FIRST))
