"""One run at a time writes into a folder."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def alone_in(folder: Path, parameter: str = "out") -> Iterator[None]:
    """Hold a folder while the context lasts; the system lets go of it when the process ends, however that is.

    Windows, and network disks without such locks, hold nothing.

    Raises:
        ValueError: if another process, or another thread of this one, holds it.
    """
    if os.name == "nt":
        yield
        return
    import fcntl

    held = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            wanted = f"{parameter}: expected a folder that no other run writes"
            raise ValueError(f"{wanted}, got {str(folder)!r}, which one writes now") from None
        except OSError:
            pass
        yield
    finally:
        os.close(held)
