"""Inputs of a tracker's own: what it changes in them, no other tracker gets.

Read-only flags do not suffice: ``torch.from_numpy`` shares the memory of a read-only array, and ``array.base`` may be
writeable. A copy costs a tenth of a millisecond for a picture of 640 x 480 pixels, and so does the comparison.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_Input = TypeVar("_Input")

COPY_IT = "inputs are read-only: change a copy, image = observation.image_rgb.copy()"


def own(value: _Input) -> _Input:
    """Return a copy of what trackers are given, e.g. an ``Observation`` or a ``Start``; its arrays are read-only.

    Objects and tuples in it are copied too. Arrays keep their layout, on which the last digit of a sum may depend.
    """
    return _own(value)  # type: ignore[no-any-return]


def check_unchanged(given: Any, now: Any, name: str) -> None:
    """Raise ValueError, naming the field, if a copy ``now`` is not what was ``given`` any more. ``name``: of both."""
    if (changed := _first_change(given, now, name)) is not None:
        raise ValueError(f"{changed}: expected it as it was given, got it changed; {COPY_IT}")


def _own(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return _own_array(value)
    if isinstance(value, tuple | list):
        return tuple(map(_own, value))
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{each.name: _own(getattr(value, each.name)) for each in fields(value)})
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


def _first_change(given: Any, now: Any, name: str) -> str | None:
    """Return the path of the first field that differs, None if there is none."""
    if given is now:
        return None
    if type(given) is not type(now) and not isinstance(given, list):
        return name
    if isinstance(given, np.ndarray):
        same = given.dtype == now.dtype and np.array_equal(given, now, equal_nan=given.dtype.kind == "f")
        return None if same else name
    if isinstance(given, tuple | list):
        parts = [(old, new, f"{name}[{k}]") for k, (old, new) in enumerate(zip(given, now, strict=True))]
    elif is_dataclass(given):
        parts = [(getattr(given, each.name), getattr(now, each.name), f"{name}.{each.name}") for each in fields(given)]
    else:
        return None if given == now else name
    return next((changed for part in parts if (changed := _first_change(*part)) is not None), None)
