"""Inputs of a tracker's own: what it changes in them, no other tracker gets.

Read-only flags do not suffice: ``torch.from_numpy`` shares the memory of a read-only array, and ``array.base`` may be
writeable. A copy costs a tenth of a millisecond for a picture of 640 x 480 pixels, and so does the comparison.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

COPY_IT = "inputs are read-only: change a copy, image = observation.image_rgb.copy()"


def own(value: Any) -> Any:
    """Return a copy of what trackers are given, e.g. an ``Observation`` or a ``Start``; its arrays are read-only.

    Objects and tuples in it are copied too. Arrays keep their layout, on which the last digit of a sum may depend.
    """
    if isinstance(value, np.ndarray):
        return _own_array(value)
    if isinstance(value, tuple | list):
        return tuple(map(own, value))
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{each.name: own(getattr(value, each.name)) for each in fields(value)})
    return value


def _own_array(array: NDArray[Any]) -> NDArray[Any]:
    """Return a copy with the same strides: a grey picture repeats one channel with a stride of 0."""
    if array.size == 0:
        return array.copy()
    spans = [(length - 1) * stride for length, stride in zip(array.shape, array.strides, strict=True)]
    before = -sum(span for span in spans if span < 0)
    memory = np.empty(before + sum(span for span in spans if span > 0) + array.itemsize, np.uint8)
    copied: NDArray[Any] = np.ndarray(array.shape, array.dtype, memory, before, array.strides)
    copied[...] = array
    copied.flags.writeable = memory.flags.writeable = False
    return copied


def check_unchanged(given: Any, now: Any, name: str) -> None:
    """Raise ValueError, naming the field, if a copy ``now`` is not what was ``given`` any more. ``name``: of both."""
    values = dict(_values(now, name))
    for place, value in _values(given, name):
        if not _same(value, values.get(place)):
            raise ValueError(f"{place}: expected it as it was given, got it changed; {COPY_IT}")


def _values(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Yield the arrays, numbers and texts in a value, each with its path."""
    if isinstance(value, tuple | list):
        for k, each in enumerate(value):
            yield from _values(each, f"{name}[{k}]")
    elif is_dataclass(value):
        for field in fields(value):
            yield from _values(getattr(value, field.name), f"{name}.{field.name}")
    else:
        yield name, value


def _same(given: Any, now: Any) -> bool:
    if isinstance(given, np.ndarray) and isinstance(now, np.ndarray):
        return given.dtype == now.dtype and np.array_equal(given, now, equal_nan=given.dtype.kind == "f")
    return type(given) is type(now) and bool(given == now)
