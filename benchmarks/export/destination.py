"""A folder that appears whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from sim.checks import check


@contextmanager
def whole_folder(out: Path) -> Iterator[Path]:
    """Yield an empty folder beside ``out`` that takes its name at the end; after a failure nothing is left.

    Raises:
        ValueError: if ``out`` is a file, holds something, or cannot be written.
    """
    # What a link points to is what is replaced, and a folder cannot be where a disk is mounted.
    out = out.resolve()
    check("out", not os.path.ismount(out), "a folder inside of a disk", f"{str(out)!r}, where one is mounted")
    taken = out.exists() and (not out.is_dir() or any(out.iterdir()))
    check("out", not taken, "an empty folder or one that does not exist", repr(str(out)))
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        beside = TemporaryDirectory(prefix=f".{out.name}-", dir=out.parent)
    except OSError as error:
        raise ValueError(f"out: expected a folder that can be written, got {str(out)!r} ({error.strerror})") from None
    with beside as scratch:
        # A folder of its own, since the temporary one is closed to other users.
        folder = Path(scratch) / "whole"
        folder.mkdir()
        yield folder
        os.replace(folder, out)
