"""UAVDT: ``NAME/img000001.jpg …`` and a file of boxes ``NAME_gt.txt`` of one target, or of all (DET and MOT).

Du et al., The unmanned aerial vehicle benchmark: object detection and tracking, ECCV 2018, and the README files of its
toolkits. The pictures are in the data set's folder, in ``UAV-benchmark-S`` or in ``UAV-benchmark-M``; the boxes in
``anno`` (single target: ``left,top,width,height``, a line a picture) or ``GT``, also those inside the toolkits' folders
``UAV-benchmark-SOT_v1.0`` and ``UAV-benchmark-MOTD_v1.0``. Lines of DET, ``NAME_gt_whole.txt``, are
``frame,id,left,top,width,height,out_of_view,occlusion,class``; those of MOT, ``NAME_gt.txt``, begin with the same six
numbers. One target of them is followed; where it has no line it is not seen. Files of attributes (``att``) describe
whole sequences and are not read. The top left corner of the picture is at 1, 1: README files do not tell, and the
toolkits are written in MATLAB.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from pathlib import Path

from benchmarks.data.layouts.layout import Source, layout
from benchmarks.data.layouts.otb import read_one_a_line
from benchmarks.data.pictures import visible

_TOOLKITS = (".", "UAV-benchmark-SOT_v1.0", "UAV-benchmark-MOTD_v1.0")
_PICTURES = (".", "UAV-benchmark-S", "UAV-benchmark-M")
_ENDINGS = ("_gt_whole.txt", "_gt.txt")
"""Of files of boxes; the first has the targets that MOT leaves out too."""


@layout("uavdt", "boxes in anno/NAME_gt.txt or GT/NAME_gt_whole.txt")
def find_uavdt(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    boxes: dict[str, Path] = {}
    for toolkit, place, ending in product(_TOOLKITS, ("anno", "GT"), _ENDINGS):
        for file in visible(path / toolkit / place, f"*{ending}"):
            boxes.setdefault(file.name.removesuffix(ending), file)
    for name, file in boxes.items():
        folders = [path / place / name for place in _PICTURES]
        pictures = next(filter(Path.is_dir, folders), folders[0])
        yield Source(name, (pictures, file), partial(read_one_a_line, name, pictures, file, None))
