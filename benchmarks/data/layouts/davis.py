"""DAVIS and YouTube-VOS: ``JPEGImages/480p/NAME/00000.jpg …`` and masks ``Annotations/480p/NAME/00000.png …``.

Perazzi et al., A benchmark dataset and evaluation methodology for video object segmentation, CVPR 2016; Pont-Tuset et
al., The 2017 DAVIS challenge on video object segmentation, https://arxiv.org/abs/1704.00675. Of ``480p`` and
``Full-Resolution`` the first that there is; Xu et al., YouTube-VOS, ECCV 2018, has neither. A mask is a PNG with a
palette: a pixel is the number of its object, 0 of none, 255 of what does not count; masks of DAVIS 2016 have 0 and 255
alone, and 255 is the object. The mask and the box around it count. A picture without a mask (of YouTube-VOS four in
five) is shown to trackers and not scored. One object of each sequence is followed, see ``layouts.followed``: by its
number, or by its name in ``objects.csv``, which ``export --format davis`` adds. Where no pixel is its own it is not
seen, and no file says why.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.box_files import text_lines
from benchmarks.data.layouts.followed import check_mask_sizes, followed
from benchmarks.data.layouts.layout import Source, Target, layout
from benchmarks.data.pictures import numbered_pictures, short, visible
from benchmarks.data.sequences import UNLABELLED, UNSEEN, Labelled
from benchmarks.run.packages import check_packages
from sim.checks import check
from trackers.regions import Mask

_SIZES = ("480p", "Full-Resolution", ".")
_VOID = 255


@layout("davis", "Annotations/480p/NAME/ beside JPEGImages/480p/NAME/, also without 480p/")
def find_davis(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    roots = (path / "Annotations" / size for size in _SIZES)
    root = next((each for each in roots if each.is_dir()), path / "Annotations")
    for masks in visible(root, "*"):
        pictures = path / "JPEGImages" / masks.relative_to(path / "Annotations")
        if masks.is_dir() and pictures.is_dir():
            read = partial(_read, masks.name, pictures, masks, path / "objects.csv")
            yield Source(masks.name, (pictures, masks), read)


def _read(name: str, folder: Path, masks: Path, objects: Path, target: Target) -> Labelled:
    pictures = numbered_pictures(folder, gaps=True)
    numbers = {number: _mask(file) for number, file in numbered_pictures(masks, gaps=True).items()}
    unknown = next((number for number in numbers if number not in pictures), None)
    check(short(masks), unknown is None, f"masks of pictures in {short(folder)}", f"one of number {unknown}")
    check_mask_sizes(masks, (mask.shape for mask in numbers.values()), next(iter(pictures.values())))
    alone = all(set(np.unique(each)) <= {0, _VOID} for each in numbers.values())
    ids = [int(each) for mask in numbers.values() for each in np.unique(mask) if each and (alone or each != _VOID)]
    wanted = _named(objects, name).get(str(target), target)
    chosen, _ = followed(wanted, masks, ids)
    boxes, tags = np.full((len(pictures), 4), np.nan), np.full(len(pictures), UNLABELLED)
    own: list[Mask | None] = [None] * len(pictures)
    for k, number in enumerate(pictures):
        if number in numbers:
            own[k] = mask = Mask(numbers[number] == int(chosen)).trimmed()
            boxes[k], tags[k] = (np.nan, UNSEEN) if mask.box_xyxy is None else (mask.box_xyxy, "")
    place = np.array(list(pictures))
    return Labelled(f"{name}-{chosen}", masks, list(pictures.values()), boxes, tags, place=place, masks=own)


def _mask(file: Path) -> NDArray[np.uint8]:
    """Return the numbers (H, W) of a mask. Raises ValueError for a file that is none."""
    check_packages(("PIL",), "data")
    from PIL import Image

    try:
        with Image.open(file) as image:
            mask = np.asarray(image)
    except (OSError, SyntaxError):
        mask = np.empty(0, np.uint8)
    check(short(file, 3), mask.ndim == 2 and mask.itemsize == 1, "a PNG with a palette, or of 8 bits", "something else")
    return mask.astype(np.uint8)


def _named(objects: Path, sequence: str) -> dict[str, int]:
    """Return name → number of the objects of a sequence; none without the file."""
    lines = [line.split(",") for line in text_lines(objects)] if objects.is_file() else []
    own = [cells for cells in lines if len(cells) > 2 and cells[0] == sequence and cells[1].isdecimal()]
    return {cells[2]: int(cells[1]) for cells in own}
