"""Frames as rows of Arrow tables, and back: the columns follow from the fields of ``Truth`` and ``Observation``.

``frames`` has a row a frame: all of its truth that is not per object or per pixel, and under ``observed_…`` what
trackers get beside the pictures. ``objects`` has a row an object a frame, ``standing`` likewise for those that stand
about. Arrays are lists in row-major order; a field
whose name begins with ``T_`` is a pose (4, 4).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import pyarrow as pa

from scenarios.truth import Meaning, Truth, dtype_of, meanings
from trackers.types import CameraModel, CameraSettings, EgoPose, Observation

OBSERVED = "observed_"
_OBSERVED_FIELDS: dict[str, Any] = {
    "time_s": float,
    "camera": CameraModel,
    "settings": CameraSettings | None,
    "ego": EgoPose | None,
}
_NO_PICTURE = np.empty((0, 0, 3), np.uint8)
_PLACE = pa.struct([("shard", pa.int32()), ("offset", pa.int64()), ("bytes", pa.int64())])
_NUMBERS = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), str: pa.string()}


def frame_schema(kind: type[Truth], channels: Iterable[str]) -> pa.Schema:
    """Return the schema of ``frames``: the episode's seed, truth, what was observed, and the places of channels."""
    hints = get_type_hints(kind)
    fields = [pa.field("seed", pa.int64())]
    fields += [_field(name, hints[name], meaning) for name, meaning in _of(kind, "frames")]
    return pa.schema([*fields, *observation_schema(channels)])


def observation_schema(channels: Iterable[str]) -> pa.Schema:
    """Return the schema of what was observed, and of the places of channels."""
    fields = [pa.field(OBSERVED + name, _arrow(hint)) for name, hint in _OBSERVED_FIELDS.items()]
    return pa.schema(fields + [pa.field(channel, _PLACE) for channel in channels])


def object_schema(kind: type[Truth], table: str = "objects") -> pa.Schema:
    """Return the schema of ``objects`` or ``standing``: seed, frame, the object's index, truth, its visible box."""
    hints = get_type_hints(kind)
    fields = [pa.field("seed", pa.int64()), pa.field("frame", pa.int64()), pa.field("index", pa.int32())]
    fields += [_field(name, hints[name], meaning) for name, meaning in _of(kind, table)]
    fields.append(pa.field("visible_box_xyxy", pa.list_(pa.float64(), 4), metadata=_note("px", "NaN: not seen")))
    return pa.schema(fields)


def frame_row(truth: Truth, observation: Observation) -> dict[str, Any]:
    """Return a frame's row, without seed and channels."""
    row = {name: _plain(getattr(truth, name)) for name, _ in _of(type(truth), "frames")}
    return row | observation_row(observation)


def observation_row(observation: Observation) -> dict[str, Any]:
    """Return what was observed beside the pictures."""
    return {OBSERVED + name: _plain(getattr(observation, name)) for name in _OBSERVED_FIELDS}


def object_columns(
    truths: Sequence[Truth], boxes: Sequence[np.ndarray], seed: int, table: str = "objects"
) -> dict[str, pa.Array]:
    """Return the columns of ``objects`` or ``standing`` of successive frames, with their visible boxes (N, 4)."""
    kind = type(truths[0])
    counts = [len(each) for each in boxes]
    index = np.concatenate([np.arange(count, dtype=np.int32) for count in counts])
    columns: dict[str, pa.Array] = {
        "seed": pa.array(np.full(len(index), seed)),
        "frame": pa.array(np.repeat([truth.frame for truth in truths], counts)),
        "index": pa.array(index),
    }
    schema = object_schema(kind, table)
    for name, _ in _of(kind, table):
        held = schema.field(name).type
        as_kind = str if pa.types.is_string(held) else None
        values = np.concatenate([np.asarray(getattr(truth, name), as_kind) for truth in truths])
        columns[name] = _column(values, held)
    columns["visible_box_xyxy"] = _column(np.concatenate(list(boxes)), schema.field("visible_box_xyxy").type)
    return columns


def truth_of(
    kind: type[Truth], frame: Mapping[str, Any], objects: Mapping[str, np.ndarray], pixels: Mapping[str, Any]
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
            lengths = [int(length) for length in meaning.shape[2:]]
            nothing = np.empty((0, 0, *lengths), dtype_of(kind, name))
            values[name] = pixels.get(name, nothing)
        elif meaning.table != "frames":
            if meaning.judged or name in objects:
                values[name] = tuple(objects[name].tolist()) if get_origin(hints[name]) is tuple else objects[name]
        else:
            values[name] = _value(frame[name], hints[name], meaning.shape)
    return kind(**values)


def observation_of(frame: Mapping[str, Any], pictures: Mapping[str, Any]) -> Observation:
    """Return the observation of a frame; ``pictures``: its ``PICTURES``, those that it has. Without it ``image_rgb`` is
    empty.
    """
    values = {name: _value(frame[OBSERVED + name], hint, ()) for name, hint in _OBSERVED_FIELDS.items()}
    return Observation(**values, **{"image_rgb": _NO_PICTURE, **pictures})


def object_arrays(kind: type[Truth], table: pa.Table) -> dict[str, np.ndarray]:
    """Return the columns of ``objects`` or ``standing`` as arrays, of the shapes and dtypes of ``Truth``."""
    hints, arrays = get_type_hints(kind), {}
    for name, meaning in meanings(kind).items():
        if name not in table.column_names or meaning.table == "frames":
            continue
        column = table[name].combine_chunks()
        if get_origin(hints[name]) is tuple or dtype_of(kind, name).kind == "U":
            arrays[name] = np.array(column.to_pylist(), dtype=str)
        else:
            flat = column.flatten() if pa.types.is_fixed_size_list(column.type) else column
            numbers = flat.to_numpy(zero_copy_only=False).astype(dtype_of(kind, name), copy=False)
            arrays[name] = numbers.reshape(-1, *meaning.shape[1:])
    return arrays


def _of(kind: type[Truth], table: str) -> list[tuple[str, Meaning]]:
    return [(name, meaning) for name, meaning in meanings(kind).items() if meaning.table == table]


def _note(unit: str, coding: str) -> dict[str, str]:
    return {"unit": unit, "coding": coding}


def _field(name: str, hint: Any, meaning: Meaning) -> pa.Field:
    each = meaning.shape if meaning.table == "frames" else meaning.shape[1:]
    if get_origin(hint) is tuple:
        kind = _arrow(get_args(hint)[0])
    elif meaning.shape and not dataclasses.is_dataclass(hint):
        scalar = np.dtype(get_args(get_args(hint)[1])[0])
        value = pa.string() if scalar.kind == "U" else pa.from_numpy_dtype(scalar)
        kind = pa.list_(value, math.prod(int(length) for length in each)) if each else value
    else:
        kind = _arrow(hint)
    return pa.field(name, kind, metadata=_note(meaning.unit, meaning.coding))


def _arrow(hint: Any) -> pa.DataType:
    """Return the type of a value of a type hint: a number, a word, an array of any length, or a dataclass of those."""
    if get_origin(hint) in (Union, UnionType):
        return _arrow(_given(hint))
    if hint in _NUMBERS:
        return _NUMBERS[hint]
    if get_origin(hint) is Literal:
        return pa.string()
    if dataclasses.is_dataclass(hint):
        return pa.struct([(name, _arrow(each)) for name, each in get_type_hints(hint).items()])
    if get_origin(hint) is np.ndarray:
        return pa.list_(pa.from_numpy_dtype(np.dtype(get_args(get_args(hint)[1])[0])))
    raise ValueError(f"truth: expected numbers, words, arrays or dataclasses of them, got {hint}")


def _given(hint: Any) -> Any:
    """Return the type of a value that may be missing, where it is given."""
    return next(each for each in get_args(hint) if each is not NoneType)


def _column(values: np.ndarray, kind: pa.DataType) -> pa.Array:
    """Return an array (M, …) as a column."""
    if pa.types.is_fixed_size_list(kind):
        return pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(values).ravel()), type=kind)
    return pa.array(values.tolist() if values.dtype.kind == "U" else values, kind)


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return value.ravel().tolist()
    return value.item() if isinstance(value, np.generic) else value


def _value(stored: Any, hint: Any, shape: tuple[Any, ...], name: str = "") -> Any:
    if stored is None:
        return None
    if get_origin(hint) in (Union, UnionType):
        return _value(stored, _given(hint), shape, name)
    if dataclasses.is_dataclass(hint):
        hints = get_type_hints(hint)
        return hint(**{key: _value(stored[key], each, (), key) for key, each in hints.items()})  # type: ignore[operator]
    if get_origin(hint) is np.ndarray:
        array = np.array(stored, np.dtype(get_args(get_args(hint)[1])[0]))
        return array.reshape(shape or ((4, 4) if name.startswith("T_") else -1))
    return stored
