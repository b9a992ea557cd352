"""UAV123 and UAV20L: ``data_seq/UAV123/NAME/000001.jpg …`` and ``anno/UAV123/NAME.txt``, a line a picture.

Mueller, Smith, Ghanem, A benchmark and simulator for UAV tracking, ECCV 2016; its ReadMe.txt: ``NaN,NaN,NaN,NaN`` where
the target is fully hidden or outside the picture, and ``configSeqs.m`` names the folder and the first and last picture
of every sequence: several share one folder (``bird1_1`` is a part of ``bird1``). Without that file a sequence is the
folder of its name. A folder of annotations (``anno/UAV20L``) is taken too. The top left corner of the picture is at
1, 1: it uses the toolkit of OTB (MATLAB).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path, PureWindowsPath

from benchmarks.data.layouts.layout import Source, layout
from benchmarks.data.layouts.otb import read_one_a_line
from benchmarks.data.pictures import visible

SET = "UAV123"
_PART = re.compile(
    r"'name'\s*,\s*'(?P<name>[^']+)'\s*,\s*'path'\s*,\s*'(?P<path>[^']+)'\s*,"
    r"\s*'startFrame'\s*,\s*(?P<first>\d+)\s*,\s*'endFrame'\s*,\s*(?P<last>\d+)"
)


@layout("uav123", f"anno/{SET}/NAME.txt")
def find_uav123(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    annotations = path if path.parent.name == "anno" else path / "anno" / SET
    root = annotations.parents[1]
    texts = [file.read_text(encoding="utf-8", errors="replace") for file in root.glob("configSeqs*.m")]
    parts = {part["name"]: part for text in texts for part in _PART.finditer(text)}
    for file in visible(annotations, "*.txt"):
        name, part = file.stem, parts.get(file.stem)
        if part is not None or not file.name.lower().startswith("readme"):
            folder = name if part is None else PureWindowsPath(part["path"]).name
            numbers = None if part is None else (int(part["first"]), int(part["last"]))
            pictures = root / "data_seq" / SET / folder
            read = partial(read_one_a_line, name, pictures, file, numbers, else_where=", or where configSeqs.m says")
            yield Source(name, (pictures, file), read)
