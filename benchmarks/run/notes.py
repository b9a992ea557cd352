"""Notes of the tracker and frame that a worker runs, which explain a crash of the worker."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_BYTES = 160


class Note:
    """A small file with the current tracker and frame; without a file nothing is written."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor

    def write(self, tracker: str, frame: int) -> None:
        """Replace the note by one write in place (some microseconds)."""
        if self._descriptor is None:
            return
        text = json.dumps({"tracker": tracker, "frame": frame})
        os.pwrite(self._descriptor, text.ljust(_BYTES).encode(), 0)


@contextmanager
def note_at(path: Path | None) -> Iterator[Note]:
    """Keep a note at ``path`` (None = none) during the context; only a crashed process leaves it behind."""
    if path is None:
        yield Note(None)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    # The name is predictable: an earlier run's note is removed, and no planted link is followed.
    path.unlink(missing_ok=True)
    descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_WRONLY)
    try:
        yield Note(descriptor)
    finally:
        os.close(descriptor)
        path.unlink(missing_ok=True)


def read_note(path: Path | None) -> tuple[str, int] | None:
    """Return the tracker and frame of a note left behind; None without a note or with an empty one."""
    try:
        note = json.loads(path.read_text()) if path is not None else None
    except (OSError, json.JSONDecodeError):
        return None
    return None if note is None else (note["tracker"], int(note["frame"]))
