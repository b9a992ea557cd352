"""What is read back is what was written: the same values, dtypes and shapes."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np


def assert_same(stored: Any, live: Any, where: str) -> None:
    """Compare dataclasses, tuples, arrays and single values; NaN is NaN."""
    if dataclasses.is_dataclass(live):
        assert type(stored) is type(live), where
        for field in dataclasses.fields(live):
            assert_same(getattr(stored, field.name), getattr(live, field.name), f"{where}.{field.name}")
    elif isinstance(live, np.ndarray):
        assert stored.shape == live.shape, where
        assert stored.dtype.kind == live.dtype.kind, where
        assert stored.dtype.kind == "U" or stored.dtype == live.dtype, where
        np.testing.assert_array_equal(stored, live, err_msg=where)
    elif isinstance(live, tuple):
        assert len(stored) == len(live), where
        for k, (one, other) in enumerate(zip(stored, live, strict=True)):
            assert_same(one, other, f"{where}[{k}]")
    else:
        assert type(stored) is type(live), where
        assert stored == live or (stored != stored and live != live), where
