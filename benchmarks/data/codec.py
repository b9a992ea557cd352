"""The codec of data sets and estimates: fields of dataclasses as columns of Arrow tables, and back.

The type of a column follows from the type hint and the ``Meaning`` of a field. Arrays are lists in row-major order; a
field whose name begins with ``T_`` is a pose (4, 4).
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Mapping
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import pyarrow as pa
import pycocotools.mask
from numpy.typing import NDArray

from scenarios.truth import Meaning

MASK = pa.field(
    "mask",
    pa.struct([("size", pa.list_(pa.int64(), 2)), ("counts", pa.string())]),
    metadata={"unit": "1", "coding": "run lengths as of COCO: pycocotools.mask.decode(mask) is (H, W); null: none"},
)
"""Column of masks."""
_SCALARS = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), str: pa.string()}


def field_of(name: str, hint: Any, meaning: Meaning) -> pa.Field:
    """Return the column of a field: one value, or one array, in each row.

    The first axis of a field with an entry for each object is that of the rows. An array with an axis ``K`` may have
    any length.
    """
    shape = meaning.shape if meaning.table == "frames" else meaning.shape[1:]
    return pa.field(name, type_of(hint, shape), metadata={"unit": meaning.unit, "coding": meaning.coding})


def type_of(hint: Any, shape: tuple[Any, ...] = ("K",)) -> pa.DataType:
    """Return the type of a value of a type hint: a number, a word, an array, or a dataclass of those.

    Args:
        shape: of an array in one row; by default it may have any length.

    Raises:
        ValueError: for another type hint.
    """
    hint = given(hint)
    if hint in _SCALARS:
        return _SCALARS[hint]
    if get_origin(hint) is Literal:
        return pa.string()
    if get_origin(hint) is tuple:
        return type_of(get_args(hint)[0])
    if dataclasses.is_dataclass(hint):
        return pa.struct([(name, type_of(each)) for name, each in get_type_hints(hint).items()])
    if get_origin(hint) is np.ndarray:
        dtype = _dtype_of(hint)
        kind = pa.string() if dtype.kind == "U" else pa.from_numpy_dtype(dtype)
        return pa.list_(kind, -1 if "K" in shape else math.prod(shape)) if shape else kind
    raise ValueError(f"truth: expected numbers, words, arrays or dataclasses of them, got {hint}")


def plain(value: Any) -> Any:
    """Return a value as Arrow takes it: dataclasses as mappings, arrays as flat lists, NumPy's scalars as Python's."""
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return value.ravel().tolist()
    return value.item() if isinstance(value, np.generic) else value


def value_of(stored: Any, hint: Any, shape: tuple[Any, ...] = (), name: str = "") -> Any:
    """Return what ``plain`` was given, from the type hint and, of an array, its shape or the name of the field."""
    hint = given(hint)
    if stored is None:
        return None
    if dataclasses.is_dataclass(hint):
        hints = get_type_hints(hint)
        # What an earlier format did not have is as the class says.
        known = {key: each for key, each in hints.items() if key in stored}
        return hint(**{key: value_of(stored[key], each, (), key) for key, each in known.items()})  # type: ignore[operator]
    if get_origin(hint) is np.ndarray:
        return np.array(stored, _dtype_of(hint)).reshape(shape or ((4, 4) if name.startswith("T_") else -1))
    if get_origin(hint) is not tuple:
        return stored
    return tuple(tuple(each) if isinstance(each, list) else each for each in stored)


def runs_of(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return a mask (H, W) as run lengths of COCO, a few hundred bytes: ``size`` and ``counts``."""
    runs = pycocotools.mask.encode(np.asfortranarray(mask, np.uint8))
    return {"size": list(mask.shape), "counts": runs["counts"].decode()}


def mask_of(runs: Mapping[str, Any]) -> NDArray[np.bool_]:
    """Return the mask (H, W) of ``runs_of``."""
    with warnings.catch_warnings():
        # Of pycocotools about NumPy 2.
        warnings.simplefilter("ignore", DeprecationWarning)
        return np.ascontiguousarray(pycocotools.mask.decode(dict(runs)), bool)


def column_of(values: NDArray[Any], kind: pa.DataType) -> pa.Array:
    """Return an array (M, …) as a column."""
    if pa.types.is_fixed_size_list(kind):
        return pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(values).ravel()), type=kind)
    return pa.array(values, kind)


def array_of(column: pa.ChunkedArray, dtype: np.dtype[Any], shape: tuple[Any, ...]) -> NDArray[Any]:
    """Return a column as an array (M, *shape)."""
    whole = column.combine_chunks()
    flat = whole.flatten() if pa.types.is_fixed_size_list(whole.type) else whole
    return flat.to_numpy(zero_copy_only=False).astype(dtype, copy=False).reshape(-1, *shape)


def given(hint: Any) -> Any:
    """Return the type of a value that may be missing, where it is given."""
    if get_origin(hint) in (Union, UnionType):
        return next(each for each in get_args(hint) if each is not NoneType)
    return hint


def _dtype_of(hint: Any) -> np.dtype[Any]:
    return np.dtype(get_args(get_args(hint)[1])[0])
