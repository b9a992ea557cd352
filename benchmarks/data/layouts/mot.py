"""MOT and MOTS Challenge, DanceTrack and KITTI MOTS: pictures, and a text file of all boxes or masks.

MOT: ``NAME/img1/000001.jpg …``, ``NAME/seqinfo.ini`` and ``NAME/gt/gt.txt``. Rows are those of
``benchmarks.data.mot_text``. Milan et al., MOT16, https://arxiv.org/abs/1603.00831, and
https://github.com/DanceTrack/DanceTrack, which has the same files; ``export --format mot`` writes them too. Sequences
lie in the folder, or in ``train`` and ``val``; that of an export has them in ``gt/mot_challenge/frameout-train``. One
target is followed, see ``layouts.followed``, by default one whose rows count (seventh number 1). Boxes are around whole
objects, hidden parts and those beyond the border too. The last number is the visible share: of 0 the target is hidden,
and a box does not count; of less than a half it is hidden in part. MOT15 has none. Pictures may be missing.
``frameRate`` is the rate, ``exactFrameRate`` that of an export.

MOTS: Voigtlaender et al., MOTS: multi-object tracking and segmentation, CVPR 2019,
https://www.vision.rwth-aachen.de/page/mots. Rows are those of ``benchmarks.data.mots_text``. The files of KITTI MOTS
are ``instances_txt/0000.txt`` and ``training/image_02/0000/000000.png …``, with ``label_02`` in place of
``instances_txt`` where TrackEval and ``export --format mots`` have them; those of MOTS Challenge lie as in MOT. A frame
is the number of its picture. The mask and the box around it count. Class 10, what is not annotated, is no target. Where
the target has no row it is not seen, and no file says why. KITTI takes 10 pictures a second.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.data.box_files import read_properties
from benchmarks.data.layouts.followed import check_mask_sizes, of_one_target
from benchmarks.data.layouts.kitti import RATE_HZ
from benchmarks.data.layouts.layout import Source, Target, folders_with, layout
from benchmarks.data.mot_text import rate_told, read_mot
from benchmarks.data.mots_text import IGNORED, has_masks, read_mots
from benchmarks.data.pictures import numbered_pictures, visible
from benchmarks.data.sequences import OCCLUDED, Labelled
from scenarios.visibility import MOSTLY_SEEN
from trackers.regions import Mask

_EXPORT = "gt/mot_challenge"
_LABELS, _PICTURES = ("instances_txt", "label_02", "training/label_02"), ("training/image_02", "image_02")


@layout("mot", "NAME/gt/gt.txt beside NAME/img1/, in the folder or in train/ and val/")
def find_mot(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for root in (path, path / _EXPORT):
        for folder in folders_with(root, "seqinfo.ini"):
            file = folder / "gt" / "gt.txt"
            if file.is_file() and not has_masks(file):
                yield Source(folder.name, (folder, pictures_of(folder), file), partial(_read_boxes, folder, file))


def _read_boxes(folder: Path, file: Path, target: Target) -> Labelled:
    told, rows = read_properties(folder / "seqinfo.ini"), read_mot(file)
    pictures = numbered_pictures(pictures_of(folder), gaps=True)
    of = (rows.confidence != 0) | (target is not None)
    seen = rows.further[of, 1]
    boxes = np.where((seen == 0)[:, None], np.nan, rows.box_xyxy[of])
    tags = np.where((seen >= 0) & (seen < MOSTLY_SEEN), OCCLUDED, "")
    labels = (rows.frame[of], rows.identity[of], rows.line[of], boxes, tags)
    return of_one_target(folder.name, file, pictures, target, *labels, whole=True, rate_hz=rate_told(told))


@layout("mots", "instances_txt/0000.txt or label_02/0000.txt with masks, beside training/image_02/; or NAME/gt/gt.txt")
def find_mots(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for labels, place in product(_LABELS, _PICTURES):
        for file in visible(path / labels, "*.txt"):
            pictures = path / place / file.stem
            if pictures.is_dir() and has_masks(file):
                yield Source(file.stem, (pictures, file), partial(_read_masks, file.stem, pictures, file, RATE_HZ))
    for folder in folders_with(path, "seqinfo.ini"):
        file = folder / "gt" / "gt.txt"
        if file.is_file() and has_masks(file):
            pictures = pictures_of(folder)
            yield Source(folder.name, (folder, pictures, file), partial(_read_masks, folder.name, pictures, file, 0.0))


def pictures_of(folder: Path) -> Path:
    """Return the folder of pictures that ``seqinfo.ini`` names; the usual one where that is broken."""
    try:
        told = read_properties(folder / "seqinfo.ini")
    except ValueError:
        told = {}  # What is wrong is named where the sequence is read.
    return folder / told.get("imDir", "img1")


def _read_masks(name: str, folder: Path, file: Path, rate_hz: float, target: Target) -> Labelled:
    told, rows = read_properties(file.parents[1] / "seqinfo.ini"), read_mots(file)
    pictures, rate_hz = numbered_pictures(folder, gaps=True), rate_hz or rate_told(told)
    check_mask_sizes(file, (runs["size"] for runs in rows.runs), next(iter(pictures.values())))
    of = np.flatnonzero(rows.kind != IGNORED)
    labels = (rows.frame[of], rows.identity[of], rows.line[of], rows.box_xyxy[of])
    return of_one_target(
        name, file, pictures, target, *labels, mask_of=lambda k: Mask(rows.mask(of[k])).trimmed(), rate_hz=rate_hz
    )
