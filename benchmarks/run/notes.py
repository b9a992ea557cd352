"""Notes that workers leave of what they are at, so that a worker's sudden death can be explained."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_BYTES = 160


class Note:
    """A small file that says which tracker is at which frame."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def write(self, tracker: str, frame: int) -> None:
        """Replace what the note says, by one write in place (some microseconds)."""
        text = json.dumps({"tracker": tracker, "frame": frame})
        os.pwrite(self._descriptor, text.ljust(_BYTES).encode(), 0)


@contextmanager
def note_at(path: Path) -> Iterator[Note]:
    """Keep a note at ``path`` while the context lasts; only a process that dies leaves it behind."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(path, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
    try:
        yield Note(descriptor)
    finally:
        os.close(descriptor)
        path.unlink(missing_ok=True)


def read_note(path: Path) -> tuple[str, int] | None:
    """Return the tracker and the frame of a note left behind; None if there is none, or nothing in it."""
    try:
        said = json.loads(path.read_text())
    except (OSError, json.JSONDecodeError):
        return None
    return said["tracker"], int(said["frame"])
