"""The folder of an export: one of this machine appears whole or not at all, one on a store is whole with README.md."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from fsspec.implementations.local import LocalFileSystem

from benchmarks.data.sets.places import new_folder, place_of, reached
from benchmarks.run.result_folder import make_folder
from sim.checks import check

README = "README.md"


@contextmanager
def whole_folder(out: str) -> Iterator[Path]:
    """Yield an empty folder of this machine that becomes ``out`` at the end; after a failure nothing of it is left.

    Args:
        out: a folder, or the URL of one on a store, to which the files are sent at the end, one by one, ``README``
            last. After a failure they are removed, unless the process was killed or the store is out of reach.

    Raises:
        ValueError: if ``out`` is a file, holds something, or cannot be written.
    """
    files, root = place_of(out)
    # What a link points to is what is replaced.
    target = Path(root).resolve() if isinstance(files, LocalFileSystem) else None
    if target is None:
        new_folder(out)
    else:
        check("out", not os.path.ismount(target), "a folder inside of a disk", f"{out!r}, where one is mounted")
        make_folder(target.parent)
    with reached(out, "out"):
        files.invalidate_cache()
        taken = files.isfile(root) or (target is not None and target.is_dir() and any(target.iterdir()))
        if target is None and files.exists(root):
            # Folders without files are none to most stores.
            taken |= any(names for *_, names in files.walk(root, on_error="raise"))
    check("out", not taken, "an empty folder or one that does not exist", repr(out))
    with TemporaryDirectory(prefix=".frameout-export-", dir=target and target.parent) as scratch:
        # A folder of its own, since the temporary one is closed to other users.
        folder = Path(scratch) / "whole"
        folder.mkdir()
        yield folder
        if target is not None:
            os.replace(folder, target)
            return
        names = [path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()]
        try:
            with reached(out, "out"):
                for name in sorted(names, key=lambda name: (name == README, name)):
                    files.put_file(str(folder / name), f"{root}/{name}")
        except BaseException:
            for name in names:
                with suppress(Exception):
                    files.rm_file(f"{root}/{name}")
            raise
