"""WebDataset: tar shards of pictures, arrays and truth, read in sequence (https://github.com/webdataset/webdataset)."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from fsspec.implementations.local import LocalFileSystem

from benchmarks.data_sets.channels import NORMALS, PICTURES
from benchmarks.data_sets.data_set import DataSet
from benchmarks.data_sets.shards import ShardWriter
from benchmarks.export.export_format import ExportFormat
from benchmarks.export.frames import StoredFrame, episodes, frames, picture_bytes
from benchmarks.export.json_lists import as_text
from benchmarks.export.objects import Labels
from scenarios.truth import meanings

SHARD_BYTES = 512 * 2**20
"""Size from which a new shard begins."""
_NAMES = {"image_rgb": "", "right_rgb": "right.", "counts": "counts."}
"""Before the endings of pictures."""
NOTE = """
Format: WebDataset, https://github.com/webdataset/webdataset: `frames-00000.tar` and so on. Files of one sample share
the key SEED_FRAME:

- `png` or `jpg`: the picture; `right.png`: the right one of a stereo pair; `counts.png`: raw counts, 16 bits.
- `json`: the frame's truth, `objects` and `standing` (parked, moored) with an entry each, and `observed`: what a
  tracker gets beside the pictures. `class_number` (of `class`) is the same in every export of the scene.
  Units are in the names, boxes are x_min, y_min, x_max, y_max in pixels from the picture's top left corner, null stands
  for a number that there is none of. `visible_box_xyxy` is the box around the pixels that are seen.
- `CHANNEL.npy`: each map with a value a pixel that the data set holds.
"""


def _write(data: DataSet, folder: Path, labels: Labels) -> None:
    shards = ShardWriter(LocalFileSystem(), str(folder), "frames", shard_bytes=2 * SHARD_BYTES)
    try:
        for episode in episodes(data):
            for stored in frames(episode, tuple(c for c in data.request.channels if c not in PICTURES)):
                for name, content in _files(data, stored, labels):
                    place = shards.add(f"{episode.seed:06d}_{stored.index:06d}.{name}", content)
                if place.offset + place.bytes > SHARD_BYTES:
                    # Between samples only: a reader takes what follows in another shard for another sample.
                    shards.finish()
        shards.finish()
    finally:
        shards.abandon()


def _files(data: DataSet, stored: StoredFrame, labels: Labels) -> Iterator[tuple[str, bytes]]:
    """Yield the ending and the content of each file of a sample."""
    for channel in data.request.channels:
        if channel in PICTURES:
            picture = picture_bytes(stored.episode, stored.index, channel)
            if picture is not None:
                yield _NAMES[channel] + picture[0], picture[1]
        elif channel == NORMALS:
            yield f"{channel}.npy", _array(stored.episode.normals_of(stored.index))
        elif getattr(stored.frame.truth, channel).size:
            yield f"{channel}.npy", _array(getattr(stored.frame.truth, channel))
    yield "json", as_text(sample(stored, labels)).encode()


def sample(stored: StoredFrame, labels: Labels) -> dict[str, Any]:
    """Return a frame's truth without its pixels, and what was observed beside pictures, as JSON values."""
    truth, observation = stored.frame.truth, stored.frame.observation
    fields = meanings(truth)
    known = {name: plain(getattr(truth, name)) for name, meaning in fields.items() if meaning.table == "frames"}
    observed = {name: plain(getattr(observation, name)) for name in ("time_s", "camera", "settings", "ego")}
    instances = list(labels.instances(stored))
    entries = {}
    for table, seen in (("objects", instances[: len(truth.names)]), ("standing", instances[len(truth.names) :])):
        columns = {name: plain(getattr(truth, name)) for name, meaning in fields.items() if meaning.table == table}
        columns["visible_box_xyxy"] = [plain(each.visible_xyxy) for each in seen]
        columns["class"] = [labels.names[each.class_number] for each in seen]
        columns["class_number"] = [each.class_number for each in seen]
        entries[table] = [dict(zip(columns, entry, strict=True)) for entry in zip(*columns.values(), strict=True)]
    return {"seed": stored.episode.seed, **known, "observed": observed, **entries}


def plain(value: Any) -> Any:
    """Return an array, a dataclass or a number as nested lists, dictionaries and numbers."""
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def _array(values: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, np.ascontiguousarray(values), allow_pickle=False)
    return file.getvalue()


WEB_DATASET = ExportFormat(
    summary="tar shards of everything: pictures, maps and truth",
    needs="nothing more than a data set",
    channels=(),
    packages=(),
    note=NOTE,
    write=_write,
)
