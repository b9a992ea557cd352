"""Files that are there wholly or not at all, whatever ends the process or fills the disk."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


@contextmanager
def atomic_file(path: Path) -> Iterator[BinaryIO]:
    """Open a new file beside ``path``, and put it in that place when the context ends without an error.

    Its name is drawn, since process ids repeat between the machines that share a disk; it must not exist, so no link
    that lies there is followed. Text is UTF-8.

    Raises:
        OSError: if it cannot be written; says ``path``, where an earlier file still stands.
    """
    beside = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    try:
        with beside.open("xb") as file:
            try:
                yield file
                file.flush()
                os.fsync(file.fileno())
                beside.replace(path)
            except BaseException:
                beside.unlink()
                raise
    except OSError as error:
        error.filename = str(path)
        raise


def write_atomic(path: Path, content: str | bytes) -> None:
    """Write a whole file as ``atomic_file`` does."""
    with atomic_file(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)
