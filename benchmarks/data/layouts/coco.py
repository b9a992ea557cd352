"""COCO of sequences: ``annotations/instances.json`` and ``images/NAME/000000.png …``, those of our export.

https://cocodataset.org/#format-data. See ``layouts.annotated``. COCO has no sequences and tracks: a folder of pictures
is a sequence here, also ``images`` itself, in the order of their names, and targets are known by ``track_id`` or by the
``name`` in their ``attributes``. The box is that of the pixels that are seen; without one the target is not seen, and
no file says why.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from benchmarks.data.coco_json import Annotations, Entry, read_annotations
from benchmarks.data.layouts.annotated import labelled
from benchmarks.data.layouts.layout import Source, layout
from benchmarks.data.pictures import visible


@layout("coco", "annotations/*.json without videos, whose boxes have names or track_id, beside images/")
def find_coco(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    root = path / "images"
    for file in visible(path / "annotations", "*.json") if root.is_dir() else ():
        said = read_annotations(file)
        if said is not None and not said.videos:
            yield from _sequences(root, file, said)


def _sequences(root: Path, file: Path, said: Annotations) -> Iterator[Source]:
    sequences: dict[Path, list[Entry]] = {}
    for each in said.images:
        sequences.setdefault(root / Path(each["file_name"]).parent, []).append(each)
    for folder, images in sequences.items():
        name = "-".join(folder.relative_to(root).parts) or root.parent.name
        yield Source(name, (folder, file), partial(labelled, name, root, file, said.boxes, images, 0.0))
