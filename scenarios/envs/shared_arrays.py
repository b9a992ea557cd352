"""One block of memory parted into named arrays, a row of each for every env; processes that map the block share them.

The block is anonymous: nothing of it has a name in a file system, so nothing is left behind whoever is killed.
"""

from __future__ import annotations

import ctypes
import math
import multiprocessing.sharedctypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_ALIGNMENT_BYTES = 64


@dataclass(frozen=True)
class Field:
    """What one env has in an array: its dtype's name and its shape."""

    dtype: str
    shape: tuple[int, ...] = ()


Layout = Mapping[str, Field]


def shared_block(layout: Layout, rows: int) -> Any:
    """Return zeroed memory for the arrays; give it to a process that is being spawned, and both see the same."""
    return multiprocessing.sharedctypes.RawArray(ctypes.c_ubyte, sum(_room_bytes(f, rows) for f in layout.values()))


def arrays_in(block: Any, layout: Layout, rows: int) -> dict[str, NDArray[Any]]:
    """Return views (rows, *shape) of the block by name."""
    arrays, offset = {}, 0
    for name, field in layout.items():
        count = rows * math.prod(field.shape)
        flat = np.frombuffer(block, np.dtype(field.dtype), count, offset)
        arrays[name] = flat.reshape(rows, *field.shape)
        offset += _room_bytes(field, rows)
    return arrays


def _room_bytes(field: Field, rows: int) -> int:
    """Return the bytes of an array, so many that the next one is aligned."""
    size = rows * math.prod(field.shape) * np.dtype(field.dtype).itemsize
    return -(-size // _ALIGNMENT_BYTES) * _ALIGNMENT_BYTES
