"""``record_kernel``: compiles functions that take records, so that each compiled form has a name of its own.

numba names a compiled form after the types of its arguments, and a record's type after a number that counts the types
of one process. The files with compiled forms outlive the process. Two processes that compile a function for different
records may thus give both the same name, and a third process that loads both calls the one in place of the other,
without a word. Here a record's type is named after its fields (``Record.mangling_args`` of numba 0.68).
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit, types

_Kernel = TypeVar("_Kernel", bound=Callable[..., Any])


def _named_after_fields(record: Any) -> tuple[str, tuple[int]]:
    digest = hashlib.sha256(record.name.encode()).digest()
    return type(record).__name__, (int.from_bytes(digest[:7]),)


types.Record.mangling_args = property(_named_after_fields)  # type: ignore[assignment, method-assign]


def record_kernel(**options: Any) -> Callable[[_Kernel], _Kernel]:
    """Return ``numba.njit`` for a function that takes records, or arrays of them, with more options of it."""
    decorator: Callable[[_Kernel], _Kernel] = njit(cache=True, **options)
    return decorator
