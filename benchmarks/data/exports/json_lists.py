"""JSON files whose long lists do not fit into memory."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

_TEMPORARY = ".part"


def as_text(value: Any) -> str:
    """Return a value as JSON on one line; NaN and infinity, which JSON lacks, become null."""
    return json.dumps(_finite(value), allow_nan=False, separators=(",", ":"))


class JsonLists:
    """Writes one JSON object whose values are lists, to which items are appended in any order."""

    def __init__(self, path: Path, names: Sequence[str], head: dict[str, Any]) -> None:
        """Begin the lists ``names``; ``head`` holds what comes before them."""
        self._path, self._head = path, head
        self._stack = ExitStack()
        self._parts: dict[str, TextIO] = {}
        self._empty: set[str] = set(names)
        for name in names:
            part = path.with_name(f"{path.name}.{name}{_TEMPORARY}")
            self._parts[name] = self._stack.enter_context(part.open("w+", encoding="utf-8"))

    def __enter__(self) -> JsonLists:
        return self

    def add(self, name: str, item: dict[str, Any]) -> None:
        """Append an item to a list."""
        self._parts[name].write(("\n" if name in self._empty else ",\n") + as_text(item))
        self._empty.discard(name)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Join the lists to one file."""
        with self._stack:
            if kind is None:
                with self._path.open("w", encoding="utf-8") as file:
                    self._join(file)
        for part in self._parts.values():
            Path(part.name).unlink()

    def _join(self, file: TextIO) -> None:
        file.write("{" + ",\n".join(f"{as_text(name)}:{as_text(value)}" for name, value in self._head.items()))
        for name, part in self._parts.items():
            file.write(f",\n{as_text(name)}:[")
            part.seek(0)
            shutil.copyfileobj(part, file)
            file.write("]")
        file.write("}\n")


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    return [_finite(each) for each in value] if isinstance(value, list | tuple) else value
