"""MOT Challenge and DanceTrack: ``NAME/img1/000001.jpg …``, ``NAME/seqinfo.ini`` and ``NAME/gt/gt.txt``.

Rows are those of ``benchmarks.data.mot_text``. Milan et al., MOT16, https://arxiv.org/abs/1603.00831, and
https://github.com/DanceTrack/DanceTrack, which has the same files; ``export --format mot`` writes them too. Sequences
lie in the folder, or in ``train`` and ``val``; that of an export has them in ``gt/mot_challenge/frameout-train``. One
target is followed, see ``layouts.followed``, by default one whose rows count (seventh number 1).

Boxes are around whole objects, hidden parts and those beyond the border too. The last number is the visible share: of 0
the target is hidden, and a box does not count; of less than a half it is hidden in part. MOT15 has none. Pictures may
be missing. ``frameRate`` is the rate, ``exactFrameRate`` that of an export.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.data.box_files import read_properties
from benchmarks.data.layouts.followed import of_one_target
from benchmarks.data.layouts.layout import Source, Target, folders_with, layout
from benchmarks.data.layouts.mots import pictures_of
from benchmarks.data.mot_text import rate_told, read_mot
from benchmarks.data.mots_text import has_masks
from benchmarks.data.pictures import numbered_pictures
from benchmarks.data.sequences import OCCLUDED, Labelled
from scenarios.visibility import MOSTLY_SEEN

_EXPORT = "gt/mot_challenge"


@layout("mot", "NAME/gt/gt.txt beside NAME/img1/, in the folder or in train/ and val/")
def find_mot(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    for root in (path, path / _EXPORT):
        for folder in folders_with(root, "seqinfo.ini"):
            file = folder / "gt" / "gt.txt"
            if file.is_file() and not has_masks(file):
                yield Source(folder.name, (folder, pictures_of(folder), file), partial(_read, folder, file))


def _read(folder: Path, file: Path, target: Target) -> Labelled:
    told, rows = read_properties(folder / "seqinfo.ini"), read_mot(file)
    pictures = numbered_pictures(pictures_of(folder), gaps=True)
    of = (rows.confidence != 0) | (target is not None)
    seen = rows.further[of, 1]
    boxes = np.where((seen == 0)[:, None], np.nan, rows.box_xyxy[of])
    tags = np.where((seen >= 0) & (seen < MOSTLY_SEEN), OCCLUDED, "")
    labels = (rows.frame[of], rows.identity[of], rows.line[of], boxes, tags)
    return of_one_target(folder.name, file, pictures, target, *labels, whole=True, rate_hz=rate_told(told))
