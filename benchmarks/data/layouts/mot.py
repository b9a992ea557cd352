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

from benchmarks.contract.text import printable
from benchmarks.data.box_files import rate_of, read_properties
from benchmarks.data.layouts.followed import followed, in_pictures
from benchmarks.data.layouts.layout import Source, Target, folders_with, layout
from benchmarks.data.layouts.mots import pictures_of
from benchmarks.data.mot_text import read_mot
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
    of = np.flatnonzero(rows.confidence != 0) if target is None else np.arange(len(rows.frame))
    chosen, mine = followed(target, file, rows.identity[of].tolist())
    mine = of[mine]
    held, places, notes = in_pictures(file, rows.frame[mine], list(pictures), rows.line[mine])
    mine = mine[held]
    boxes, tags = np.full((len(pictures), 4), np.nan), np.full(len(pictures), "", "<U10")
    seen = rows.further[mine, 1]
    hidden = seen == 0
    boxes[places] = np.where(hidden[:, None], np.nan, rows.box_xyxy[mine])
    tags[places] = np.where((seen >= 0) & (seen < MOSTLY_SEEN), OCCLUDED, "")
    return Labelled(
        f"{printable(folder.name)}-{chosen}",
        file,
        list(pictures.values()),
        boxes,
        tags,
        whole=True,
        rate_hz=rate_of(told.get("exactFrameRate", told.get("frameRate", ""))),
        place=np.array(list(pictures)),
        notes=notes,
    )
