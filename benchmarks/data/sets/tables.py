"""Frames as rows of Arrow tables, and back: the columns follow from the fields of ``Truth`` and ``Observation``.

``frames`` has a row a frame: all of its truth that is not per object or per pixel, and under ``observed_…`` what
trackers get beside the pictures. ``objects`` has a row an object a frame, ``standing`` likewise for those that stand
about, with the box about the visible pixels of each.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, get_origin, get_type_hints

import numpy as np
import pyarrow as pa
from numba import njit
from numpy.typing import NDArray

from benchmarks.data.codec import array_of, column_of, field_of, plain, type_of, value_of
from scenarios.truth import Meaning, Truth, dtype_of, meanings
from trackers.types import CameraModel, CameraSettings, EgoPose, Observation

OBSERVED = "observed_"
VISIBLE_BOX = "visible_box_xyxy"
_OBSERVED_FIELDS: dict[str, Any] = {
    "time_s": float,
    "camera": CameraModel,
    "settings": CameraSettings | None,
    "ego": EgoPose | None,
}
_NO_PICTURE = np.empty((0, 0, 3), np.uint8)
_SEED = pa.field("seed", pa.int64())
_PLACE = pa.struct([("shard", pa.int32()), ("offset", pa.int64()), ("bytes", pa.int64())])


def frame_schema(kind: type[Truth], channels: Iterable[str]) -> pa.Schema:
    """Return the schema of ``frames``: the episode's seed, truth, what was observed, and the places of channels."""
    return pa.schema([_SEED, *_fields(kind, "frames"), *observation_schema(channels)])


def observation_schema(channels: Iterable[str]) -> pa.Schema:
    """Return the schema of what was observed, and of the places of channels."""
    fields = [pa.field(OBSERVED + name, type_of(hint)) for name, hint in _OBSERVED_FIELDS.items()]
    return pa.schema(fields + [pa.field(channel, _PLACE) for channel in channels])


def object_schema(kind: type[Truth], table: str) -> pa.Schema:
    """Return the schema of ``objects`` or ``standing``: seed, frame, the object's index, truth, its visible box."""
    box = field_of(VISIBLE_BOX, NDArray[np.float64], Meaning("px", ("N", 4), "NaN: not seen"))
    places = (pa.field("frame", pa.int64()), pa.field("index", pa.int32()))
    return pa.schema([_SEED, *places, *_fields(kind, table), box])


def frame_row(truth: Truth, observation: Observation) -> dict[str, Any]:
    """Return a frame's row, without seed and channels."""
    return {name: plain(getattr(truth, name)) for name in _of(type(truth), "frames")} | observation_row(observation)


def observation_row(observation: Observation) -> dict[str, Any]:
    """Return what was observed beside the pictures."""
    return {OBSERVED + name: plain(getattr(observation, name)) for name in _OBSERVED_FIELDS}


def object_table(truths: Sequence[Truth], boxes: Sequence[NDArray[np.float64]], seed: int, table: str) -> pa.Table:
    """Return the rows of ``objects`` or ``standing`` of successive frames, with their visible boxes (N, 4)."""
    counts = [len(each) for each in boxes]
    columns: dict[str, NDArray[Any]] = {
        "seed": np.full(sum(counts), seed),
        "frame": np.repeat([truth.frame for truth in truths], counts),
        "index": np.concatenate([np.arange(count, dtype=np.int32) for count in counts]),
        VISIBLE_BOX: np.concatenate(list(boxes)),
    }
    schema = object_schema(type(truths[0]), table)
    for name in _of(type(truths[0]), table):
        dtype = str if schema.field(name).type == pa.string() else None
        columns[name] = np.concatenate([np.asarray(getattr(truth, name), dtype) for truth in truths])
    return pa.table([column_of(columns[field.name], field.type) for field in schema], schema=schema)


def truth_of(
    kind: type[Truth], frame: Mapping[str, Any], objects: Mapping[str, NDArray[Any]], pixels: Mapping[str, Any]
) -> Truth:
    """Return the truth of a frame.

    Args:
        frame: its row of ``frames``. objects: its columns of ``objects`` and ``standing``, as from ``object_arrays``.
            Fields that are missing, of a set of an earlier format, become what a truth without them has.
        pixels: its channels; those that are missing become empty.
    """
    hints, values = get_type_hints(kind), {}
    for name, meaning in meanings(kind).items():
        if meaning.per_pixel:
            values[name] = pixels.get(name, np.empty((0, 0, *map(int, meaning.shape[2:])), dtype_of(kind, name)))
        elif meaning.table == "frames":
            if meaning.judged or name in frame:
                values[name] = value_of(frame[name], hints[name], meaning.shape)
        elif meaning.judged or name in objects:
            values[name] = tuple(objects[name].tolist()) if get_origin(hints[name]) is tuple else objects[name]
    return kind(**values)


def observation_of(frame: Mapping[str, Any], pictures: Mapping[str, Any]) -> Observation:
    """Return the observation of a frame; ``pictures``: its ``PICTURES``, those that it has. Without it ``image_rgb`` is
    empty.
    """
    values = {name: value_of(frame[OBSERVED + name], hint) for name, hint in _OBSERVED_FIELDS.items()}
    return Observation(**values, **{"image_rgb": _NO_PICTURE, **pictures})


def object_arrays(kind: type[Truth], rows: pa.Table, table: str) -> dict[str, NDArray[Any]]:
    """Return the columns of ``objects`` or ``standing`` as arrays, of the shapes and dtypes of ``Truth``, and the
    visible boxes.
    """
    arrays = {VISIBLE_BOX: array_of(rows[VISIBLE_BOX], np.dtype(float), (4,))}
    for name, meaning in _of(kind, table).items():
        if name in rows.column_names:
            dtype = np.dtype(str) if rows.schema.field(name).type == pa.string() else dtype_of(kind, name)
            arrays[name] = array_of(rows[name], dtype, meaning.shape[1:])
    return arrays


def _of(kind: type[Truth], table: str) -> dict[str, Meaning]:
    return {name: meaning for name, meaning in meanings(kind).items() if meaning.table == table}


def _fields(kind: type[Truth], table: str) -> list[pa.Field]:
    hints = get_type_hints(kind)
    return [field_of(name, hints[name], meaning) for name, meaning in _of(kind, table).items()]


def visible_boxes(instance_map: NDArray[np.int32], instance_id: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the tight boxes (N, 4) around the pixels of ``instance_map`` (H, W) that show the objects ``instance_id``
    (N,), as x_min, y_min, x_max, y_max; NaN for objects of which none does.
    """
    ends = _ends(instance_map, max(int(instance_map.max(initial=0)), int(instance_id.max(initial=0))) + 1)
    boxes = ends[instance_id].astype(np.float64)
    boxes[boxes[:, 2] < 0] = np.nan
    return boxes


@njit(cache=True)
def _ends(instance_map: NDArray[np.int32], ids: int) -> NDArray[np.int64]:
    """Return first column and row, and those after the last (``ids``, 4), of each id >= 0; -1 at the end of others."""
    height, width = instance_map.shape
    ends = np.empty((ids, 4), np.int64)
    for i in range(ids):
        ends[i, 0], ends[i, 1], ends[i, 2], ends[i, 3] = width, height, -1, -1
    for row in range(height):
        column = 0
        while column < width:
            which, first = instance_map[row, column], column
            while column < width and instance_map[row, column] == which:
                column += 1
            if which >= 0:
                ends[which, 0] = min(ends[which, 0], first)
                ends[which, 1] = min(ends[which, 1], row)
                ends[which, 2] = max(ends[which, 2], column)
                ends[which, 3] = row + 1
    return ends
