"""The folder of an export: one of this machine appears whole or not at all, one on a store is whole with README.md."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from fsspec import AbstractFileSystem
from fsspec.implementations.local import LocalFileSystem

from benchmarks.data.sets.places import new_folder, place_of, reached
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
        _check_empty(out, _holds_files(files, root))
    with TemporaryDirectory(prefix="frameout-export-") as scratch:
        folder = Path(scratch)
        yield folder
        made = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
        begun: list[str] = []
        try:
            with reached(out, "out"):
                # Others may have written there meanwhile.
                _check_empty(out, _holds_files(files, root))
                for name in sorted(made, key=lambda name: (name == README, name)):
                    begun.append(f"{root}/{name}")
                    files.put_file(str(folder / name), begun[-1])
        except BaseException:
            for path in begun:
                with suppress(Exception):
                    files.rm_file(path)
            raise


def _holds_files(files: AbstractFileSystem, root: str) -> bool:
    """Return whether a store has a file at ``root`` or below; folders without files are none to most stores."""
    files.invalidate_cache()
    return files.exists(root) and any(names for *_, names in files.walk(root, on_error="raise"))


def _check_empty(out: str, is_taken: bool) -> None:
    check("out", not is_taken, "an empty folder or one that does not exist", repr(out))
