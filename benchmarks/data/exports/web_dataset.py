"""WebDataset: tar shards of pictures, arrays and truth, read in sequence (https://github.com/webdataset/webdataset)."""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Iterator
from functools import partial
from typing import Any, get_origin, get_type_hints

import numpy as np
from fsspec.implementations.local import LocalFileSystem

from benchmarks.data.codec import given
from benchmarks.data.exports.exporter import Exporter, export_format, set_name
from benchmarks.data.exports.labels import Labels, StoredFrame
from benchmarks.data.sets.channels import value_of
from benchmarks.data.sets.episode_writer import ShardWriter
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios.truth import dtype_of, meanings
from trackers.types import Observation

SHARD_BYTES = 512 * 2**20
"""Size from which a new shard begins."""
_OBSERVED = ("time_s", "camera", "settings", "ego")
"""What a tracker gets beside the pictures."""
_NAMES = {"image_rgb": "", "right_rgb": ".right"}
"""Before the endings of pictures."""
NO_NUMBER = -1e9
_OF_INSTANCE = {"names": "name", "kinds": "kind"}
"""Field of objects -> that of an ``Instance``, where it has another name."""
_NONE: dict[str, Any] = {"U": "", "f": NO_NUMBER, "b": False}
"""Kind of dtype -> what stands for none; else -1."""


@export_format("webdataset")
class WebDataset(Exporter):
    """Tar shards of everything: pictures, maps and truth.

    Format: WebDataset, https://github.com/webdataset/webdataset: `SET-train-00000.tar` and so on, `SET-val-…` and
    `SET-test-…` for the splits of the set; without any, episodes of the benchmark's test split (seeds 10,000 to 19,999)
    are `test`. Files of one sample share a key, `SET-SEED_FRAME`, which no
    data set of another scene, preset, size, rate, length or renderer has:

    - `png` or `jpg`: the picture; `right.png`: the right one of a stereo pair, black where `lost` in the JSON file says
      that there is none.
    - `json`: the frame's truth, `objects` with an entry each, and `observed`: what a tracker gets beside the pictures.
      `class_number` (of `class`) is the same in every export of the scene with the same `--classes`. What only stands
      about, a parked car or a moored boat, comes last, with `stands` true, and lacks what is told of the others. Units
      are in the names, boxes are x_min, y_min, x_max, y_max in pixels. `visible_box_xyxy` is the box around the pixels
      that are seen.
    - `CHANNEL.npy`: each map with a value a pixel that the data set holds, and `counts.npy`: the raw counts of a
      thermal camera, uint16.

    Each field has one type in all samples, so nothing is null: for what there is none of stands -1000000000.0 for a
    number, -1 for a whole number, an empty string for a word.
    """

    has_classes = True
    data_files = "*-{split}-*.tar"

    def begin(self) -> None:
        """Begin the shards of each split."""
        self.reads = tuple(channel for channel in self.data.request.channels if channel not in _NAMES)
        name, files = set_name(self.data), LocalFileSystem()
        self._splits: dict[str, ShardWriter] = {}
        for split in self.data.splits:
            shards = ShardWriter(files, str(self.folder), f"{name}-{split}", 2 * SHARD_BYTES)
            self._splits[split] = shards
            self.stack.callback(shards.finish)

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write the samples of an episode."""
        shards = self._splits[self.data.request.split_of(episode.seed)]
        for stored in self.frames(episode):
            for ending, content in self._files(stored):
                place = shards.add(f"{self.name_of(episode)}_{stored.index:06d}{ending}", content)
            if place.offset + place.bytes > SHARD_BYTES:
                # Between samples only: a reader takes what follows in another shard for another sample.
                shards.finish()

    def _files(self, stored: StoredFrame) -> Iterator[tuple[str, bytes]]:
        """Yield the ending and the content of each file of a sample."""
        lost = {}
        for channel in self.data.request.channels:
            if channel in _NAMES:
                picture = self.picture(stored.episode, stored.index, channel)
                lost[channel] = picture is None
                yield _NAMES[channel] + self.ending, picture or self.black_picture(stored.camera)
                continue
            # Counts are no picture of 16 bits: of these the usual decoders keep 8, and clip.
            values = value_of(stored.frame, channel, partial(stored.episode.normals_of, stored.index))
            if values is not None:
                file = io.BytesIO()
                np.save(file, np.ascontiguousarray(values), allow_pickle=False)
                yield f".{channel}.npy", file.getvalue()
        known = sample(stored, self.labels) | ({"lost": lost} if lost else {})
        yield ".json", json.dumps(known, allow_nan=False, separators=(",", ":")).encode()


def sample(stored: StoredFrame, labels: Labels) -> dict[str, Any]:
    """Return a frame's truth without its pixels, and what was observed beside pictures, as JSON values.

    Each field has the same type in all samples: readers that infer types from the first samples, as the Hugging Face
    library ``datasets`` does, read no others.
    """
    truth, observation, objects = stored.frame.truth, stored.frame.observation, []
    hints, seen, fields = get_type_hints(type(truth)), get_type_hints(Observation), meanings(truth)
    known = {
        name: _typed(getattr(truth, name), hints[name], meaning.shape)
        for name, meaning in fields.items()
        if meaning.table == "frames"
    }
    observed = {name: _typed(getattr(observation, name), seen[name]) for name in _OBSERVED}
    for k, each in enumerate(labels.instances(stored)):
        stands = k >= len(truth.names)
        entry: dict[str, Any] = {}
        for name, meaning in fields.items():
            if meaning.table == "objects":
                # Of one that only stands about, an instance has what is known.
                value = getattr(each, _OF_INSTANCE.get(name, name), None) if stands else getattr(truth, name)[k]
                missing = value is None
                entry[name] = _none(dtype_of(type(truth), name), meaning.shape[1:]) if missing else _numbers(value)
        entry |= {
            "visible_box_xyxy": _numbers(each.visible_xyxy),
            "class": labels.names[each.class_number],
            "class_number": each.class_number,
            "stands": stands,
        }
        objects.append(entry)
    return {"seed": stored.episode.seed, **known, "observed": observed, "objects": objects}


def _none(dtype: np.dtype[Any], shape: tuple[Any, ...]) -> Any:
    """Return what stands for no value: a number or word, or nested lists of numbers."""
    return np.full(shape, _NONE.get(dtype.kind, -1), dtype).tolist()


def _typed(value: Any, hint: Any, shape: tuple[Any, ...] = (), name: str = "") -> Any:
    """Return a value as JSON of the type that its hint says, also where there is none."""
    hint = given(hint)
    if dataclasses.is_dataclass(hint):
        hints = get_type_hints(hint)
        return {key: _typed(getattr(value, key, None), each, (), key) for key, each in hints.items()}
    if value is not None:
        return _numbers(float(value) if hint is float else value)
    if get_origin(hint) is np.ndarray:
        return _none(np.dtype(float), shape or ((4, 4) if name.startswith("T_") else (1,)))
    return _none(np.dtype(hint if hint in (bool, int, float) else str), ())


def _numbers(value: Any) -> Any:
    """Return an array or a value as nested lists, with a number in place of those that are not finite."""
    if isinstance(value, np.ndarray | float) and np.asarray(value).dtype.kind == "f":
        value = np.where(np.isfinite(value), np.asarray(value, float), NO_NUMBER)
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
