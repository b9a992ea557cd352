"""MOTS and KITTI MOTS: pictures, and a text file with a mask of each object and frame.

Voigtlaender et al., MOTS: multi-object tracking and segmentation, CVPR 2019,
https://www.vision.rwth-aachen.de/page/mots. Rows are those of ``benchmarks.data.mots_text``. The files of KITTI MOTS
are ``instances_txt/0000.txt`` and ``training/image_02/0000/000000.png …``, with ``label_02`` in place of
``instances_txt`` where TrackEval and ``export --format mots`` have them; those of MOTS Challenge lie as in MOT:
``NAME/gt/gt.txt`` and ``NAME/img1/000001.jpg …``. A frame is the number of its picture. The mask and the box around it
count.
One target is followed, see ``layouts.followed``; class 10, what is not annotated, is none. Where it has no row it is
not seen, and no file says why. KITTI takes 10 pictures a second; ``seqinfo.ini`` tells that of MOTS Challenge.
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
from benchmarks.data.mot_text import rate_told
from benchmarks.data.mots_text import IGNORED, has_masks, read_mots
from benchmarks.data.pictures import numbered_pictures, visible
from benchmarks.data.sequences import Labelled
from trackers.regions import Mask

_LABELS, _PICTURES = ("instances_txt", "label_02", "training/label_02"), ("training/image_02", "image_02")


@layout("mots", "instances_txt/0000.txt or label_02/0000.txt with masks, beside training/image_02/; or NAME/gt/gt.txt")
def find_mots(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for labels, place in product(_LABELS, _PICTURES):
        for file in visible(path / labels, "*.txt"):
            pictures = path / place / file.stem
            if pictures.is_dir() and has_masks(file):
                yield Source(file.stem, (pictures, file), partial(_read, file.stem, pictures, file, RATE_HZ))
    for folder in folders_with(path, "seqinfo.ini"):
        file = folder / "gt" / "gt.txt"
        if file.is_file() and has_masks(file):
            pictures = pictures_of(folder)
            yield Source(folder.name, (folder, pictures, file), partial(_read, folder.name, pictures, file, 0.0))


def pictures_of(folder: Path) -> Path:
    """Return the folder of pictures that ``seqinfo.ini`` names; the usual one where that is broken."""
    try:
        told = read_properties(folder / "seqinfo.ini")
    except ValueError:
        told = {}  # What is wrong is named where the sequence is read.
    return folder / told.get("imDir", "img1")


def _read(name: str, folder: Path, file: Path, rate_hz: float, target: Target) -> Labelled:
    told, rows = read_properties(file.parents[1] / "seqinfo.ini"), read_mots(file)
    pictures, rate_hz = numbered_pictures(folder, gaps=True), rate_hz or rate_told(told)
    check_mask_sizes(file, (runs["size"] for runs in rows.runs), next(iter(pictures.values())))
    of = np.flatnonzero(rows.kind != IGNORED)
    labels = (rows.frame[of], rows.identity[of], rows.line[of], rows.box_xyxy[of])
    return of_one_target(
        name, file, pictures, target, *labels, mask_of=lambda k: Mask(rows.mask(of[k])).trimmed(), rate_hz=rate_hz
    )
