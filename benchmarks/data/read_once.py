"""Files of many sequences, which are read once for all of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from pathlib import Path
from typing import TypeVar

_Content = TypeVar("_Content")


def read_once(read: Callable[[Path], _Content]) -> Callable[[Path], _Content]:
    """Return a reader that keeps the content of the latest four files, until they change on disk."""
    kept = lru_cache(maxsize=4)(lambda path, changed_ns: read(path))

    @wraps(read)
    def reader(path: Path) -> _Content:
        return kept(path, path.stat().st_mtime_ns)

    return reader
