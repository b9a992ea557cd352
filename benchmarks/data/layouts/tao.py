"""TAO and TAO-Amodal: ``annotations/validation.json`` or ``amodal_annotations/validation.json``, and ``frames/``.

Dave et al., TAO: a large-scale benchmark for tracking any object, ECCV 2020; its fields are in
``tao/toolkit/tao/tao.py`` of https://github.com/TAO-Dataset/tao. Hsieh et al., https://arxiv.org/abs/2312.12433, extend
them; ``export --format tao-amodal`` writes them. See ``layouts.annotated``. ``images`` names the labelled pictures of
each of ``videos``. In TAO that is one a second; the others of the folder are shown to trackers and not scored.

Of TAO-Amodal the box around the whole target counts, ``amodal_bbox``, unless it is uncertain; with a ``visibility`` of
0 the target is hidden, or outside where that box is, and with less than a half hidden in part. Files for TAO-Amodal's
evaluation (``…_lvis_v1.json``) repeat others and are not read. ``metadata`` of an export's videos tells ``fps``.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from benchmarks.data.box_files import rate_of
from benchmarks.data.coco_json import Annotations, Entry, read_annotations
from benchmarks.data.layouts.annotated import labelled
from benchmarks.data.layouts.layout import Source, layout
from benchmarks.data.pictures import visible

_FOLDERS = ("annotations", "amodal_annotations")
_REPEATS = "_lvis_v1.json"


@layout("tao", "annotations/*.json or amodal_annotations/*.json, with videos, beside frames/")
def find_tao(path: Path) -> Iterator[Source]:
    """See ``Find``."""
    root = path / "frames"
    files = [file for place in _FOLDERS for file in visible(path / place, "*.json") if root.is_dir()]
    for file in files:
        said = None if file.name.endswith(_REPEATS) else read_annotations(file)
        if said is not None:
            yield from _sequences(root, file, said)


def _sequences(root: Path, file: Path, said: Annotations) -> Iterator[Source]:
    images: dict[int, list[Entry]] = {}
    for each in said.images:
        images.setdefault(each.get("video_id", -1), []).append(each)
    for video in said.videos:
        if mine := images.get(video["id"]):
            name, metadata = Path(video["name"]).name, video.get("metadata")
            rate_hz = rate_of(str(metadata.get("fps", ""))) if isinstance(metadata, dict) else 0.0
            places = ((root / mine[0]["file_name"]).parent, file)
            yield Source(name, places, partial(labelled, name, root, file, said.boxes, mine, rate_hz))
