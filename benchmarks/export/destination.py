"""A folder, of this machine or on a store, that appears whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from fsspec import AbstractFileSystem
from fsspec.implementations.local import LocalFileSystem

from benchmarks.data_sets.places import new_folder, place_of, reached
from sim.checks import check


@contextmanager
def whole_folder(out: str) -> Iterator[Path]:
    """Yield an empty folder of this machine that becomes ``out`` at the end; after a failure nothing is left.

    Args:
        out: a folder, or the URL of one on a store, to which the files are sent at the end.

    Raises:
        ValueError: if ``out`` is a file, holds something, or cannot be written.
    """
    files, root = place_of(out)
    with _beside(Path(root)) if isinstance(files, LocalFileSystem) else _sent(files, root, out) as folder:
        yield folder


@contextmanager
def _beside(out: Path) -> Iterator[Path]:
    """Yield a folder beside ``out`` that takes its name at the end."""
    # What a link points to is what is replaced, and a folder cannot be where a disk is mounted.
    out = out.resolve()
    check("out", not os.path.ismount(out), "a folder inside of a disk", f"{str(out)!r}, where one is mounted")
    _check_empty(str(out), out.exists() and (not out.is_dir() or any(out.iterdir())))
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
        try:
            os.replace(folder, out)
        except OSError:
            # Another process may have written there meanwhile.
            _check_empty(str(out), out.exists())
            raise


@contextmanager
def _sent(files: AbstractFileSystem, root: str, out: str) -> Iterator[Path]:
    """Yield a temporary folder whose files are sent to a store at the end."""
    new_folder(out)
    with reached(out, "out"):
        _check_empty(out, files.exists(root) and bool(files.ls(root)))
    with TemporaryDirectory(prefix="frameout-export-") as scratch:
        folder = Path(scratch)
        yield folder
        try:
            with reached(out, "out"):
                for path in sorted(path for path in folder.rglob("*") if path.is_file()):
                    files.put_file(str(path), f"{root}/{path.relative_to(folder).as_posix()}")
        except BaseException:
            with suppress(Exception):
                files.rm(root, recursive=True)
            raise


def _check_empty(out: str, is_taken: bool) -> None:
    check("out", not is_taken, "an empty folder or one that does not exist", repr(out))
