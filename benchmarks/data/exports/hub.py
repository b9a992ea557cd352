"""The layout of the Hugging Face Hub: Parquet with pictures and labels, which ``datasets`` loads.

https://huggingface.co/docs/hub/datasets-data-files-configuration, https://huggingface.co/docs/datasets/object_detection.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import ATTRIBUTES, as_xywh
from benchmarks.data.sets.stored_episode import StoredEpisode

SHARD_BYTES, ROWS_AT_ONCE = 256 * 2**20, 100
"""Size of pictures from which a new file begins, and rows of a row group, which viewers of the Hub read at once."""
_TYPES = {"int64": pa.int64(), "float64": pa.float64(), "string": pa.string(), "bool": pa.bool_()}
_STORED_IMAGE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
_ATTRIBUTE_TYPES = dict(
    zip(ATTRIBUTES, ("string", "string", "string", "float64", "float64", "bool", "bool"), strict=True)
)


@export_format("hub")
class Hub(Exporter):
    """Pictures and boxes of what is seen in Parquet files, as the Hugging Face Hub has them.

    Format: https://huggingface.co/docs/hub/datasets-data-files-configuration. `load_dataset("FOLDER")` of the library
    `datasets` reads this folder, and one on the Hub after it was uploaded there (`hf upload`): the head of this file
    names the files of each split, `data/SPLIT-NNNNN.parquet`, and those tell their features.

    A row is a picture: `image` (decoded by the library), `image_id` (from 1), `seed` and `frame` of the episode,
    `time_s`, `width`, `height`, and `objects`, lists with an entry for each object of which at least one pixel is seen,
    parked cars and moored boats too: `id` (from 1), `bbox` (left, top, width, height of the box around those pixels;
    the top left corner of the picture is 0, 0), `area` of that box, `category` (a `ClassLabel`, with the same numbers
    in every export of the scene with the same `--classes`) and `iscrowd`, 1 for what is to be ignored
    (`--min-visible`, without what glare covers, `--min-size`, `--ignore-standing`). `objects` has these lists too:
    """

    channels = ("image_rgb",)
    packages = ("pyarrow",)
    has_attributes = True
    has_classes = True
    leaves_out = True
    of_stills = True
    data_files = "data/{split}-*.parquet"

    def begin(self) -> None:
        """Begin the files of each split."""
        of_object = {
            "id": _value("int64"),
            "bbox": _list(_value("float64")),
            "area": _value("float64"),
            "category": {"names": list(self.labels.names), "_type": "ClassLabel"},
            "iscrowd": _value("int64"),
            **{name: _value(kind) for name, kind in _ATTRIBUTE_TYPES.items()},
        }
        numbers = {name: _value("int64") for name in ("image_id", "seed", "frame", "width", "height")}
        features = {
            "image": {"_type": "Image"},
            **numbers,
            "time_s": _value("float64"),
            "objects": {name: _list(feature) for name, feature in of_object.items()},
        }
        told = json.dumps({"info": {"features": features}})
        fields = [pa.field(name, _stored_as(feature)) for name, feature in features.items()]
        self._schema = pa.schema(fields, metadata={"huggingface": told})
        self._files = {split: _Files(self, split, self._schema) for split in self.data.splits}
        self._counts = {"images": 0, "objects": 0}

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write the rows of an episode."""
        files = self._files[self.data.request.split_of(episode.seed)]
        for stored in self.frames(episode):
            content = self.picture(episode, stored.index)
            objects: dict[str, list[Any]] = {field.name: [] for field in self._schema.field("objects").type}
            for each, taken in self.labels.seen(stored):
                self._counts["objects"] += 1
                box = as_xywh(each.visible_xyxy)
                entry = {"id": self._counts["objects"], "bbox": box, "area": box[2] * box[3]}
                entry |= {"category": each.class_number, "iscrowd": int(not taken)}
                for name, value in (entry | each.attributes()).items():
                    objects[name].append(value)
            self._counts["images"] += 1
            row = {
                "image": {"bytes": content, "path": f"{self.name_of(episode)}_{stored.index:06d}{self.ending}"},
                "image_id": self._counts["images"],
                "seed": episode.seed,
                "frame": stored.index,
                "width": stored.camera.width_px,
                "height": stored.camera.height_px,
                "time_s": stored.frame.truth.time_s,
                "objects": objects,
            }
            files.add(row, len(content or b""))

    def end(self) -> None:
        """Write what is still held."""
        for files in self._files.values():
            files.finish()


class _Files:
    """The Parquet files of one split, one after the other."""

    def __init__(self, exporter: Exporter, split: str, schema: pa.Schema) -> None:
        self._exporter, self._split, self._schema = exporter, split, schema
        self._rows: list[dict[str, Any]] = []
        self._writer: pq.ParquetWriter | None = None
        self._count = self._bytes = 0

    def add(self, row: dict[str, Any], size: int) -> None:
        """Add a row with a picture of ``size`` bytes."""
        self._rows.append(row)
        self._bytes += size
        if len(self._rows) == ROWS_AT_ONCE or self._bytes >= SHARD_BYTES:
            self._write()
        if self._bytes >= SHARD_BYTES:
            self.finish()

    def finish(self) -> None:
        """Write what is held, and end the file."""
        self._write()
        if self._writer is not None:
            self._writer.close()
        self._writer, self._bytes = None, 0

    def _write(self) -> None:
        if not self._rows:
            return
        if self._writer is None:
            path = self._exporter.place(f"data/{self._split}-{self._count:05d}.parquet")
            self._writer = self._exporter.stack.enter_context(pq.ParquetWriter(path, self._schema, compression="zstd"))
            self._count += 1
        self._writer.write_table(pa.Table.from_pylist(self._rows, self._schema))
        self._rows = []


def _value(kind: str) -> dict[str, Any]:
    return {"dtype": kind, "_type": "Value"}


def _list(feature: Mapping[str, Any]) -> dict[str, Any]:
    # Releases of ``datasets`` before 4 know no ``List``; later ones read this as one.
    return {"feature": feature, "_type": "Sequence"}


def _stored_as(feature: Mapping[str, Any]) -> pa.DataType:
    """Return how a feature is stored."""
    match feature.get("_type"):
        case "Image":
            return _STORED_IMAGE
        case "Sequence":
            return pa.list_(_stored_as(feature["feature"]))
        case "ClassLabel":
            return pa.int64()
        case "Value":
            return _TYPES[feature["dtype"]]
    return pa.struct([(name, _stored_as(each)) for name, each in feature.items()])
