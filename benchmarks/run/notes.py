"""Notes that workers leave of what they are at, so that a worker's sudden death can be explained."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_BYTES = 160


class Note:
    """A small file that says which tracker is at which frame; without a file nothing is written."""

    def __init__(self, descriptor: int | None) -> None:
        self._descriptor = descriptor

    def write(self, tracker: str, frame: int) -> None:
        """Replace what the note says, by one write in place (some microseconds)."""
        if self._descriptor is None:
            return
        text = json.dumps({"tracker": tracker, "frame": frame})
        os.pwrite(self._descriptor, text.ljust(_BYTES).encode(), 0)


@contextmanager
def note_at(path: Path | None) -> Iterator[Note]:
    """Keep a note at ``path`` while the context lasts, if there is one; only a process that dies leaves it behind."""
    if path is None:
        yield Note(None)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    # The name can be foreseen: what an earlier run left is taken away, and no link that another left is followed.
    path.unlink(missing_ok=True)
    descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_WRONLY)
    try:
        yield Note(descriptor)
    finally:
        os.close(descriptor)
        path.unlink(missing_ok=True)


def read_note(path: Path | None) -> tuple[str, int] | None:
    """Return the tracker and the frame of a note left behind; None if there is none, or nothing in it."""
    try:
        said = json.loads(path.read_text()) if path is not None else None
    except (OSError, json.JSONDecodeError):
        return None
    return None if said is None else (said["tracker"], int(said["frame"]))
