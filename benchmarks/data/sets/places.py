"""Folders and stores that data sets lie in."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from fsspec import AbstractFileSystem
from fsspec.core import url_to_fs
from fsspec.implementations.local import LocalFileSystem

from benchmarks.run.result_folder import PROBE, make_folder
from trackers.atomic_file import atomic_file, write_atomic

_CLIENTS = ("botocore", "aiobotocore", "aiohttp", "gcsfs", "google", "azure", "adlfs")
"""Packages whose errors are about the way to a store."""
_READ_AT_ONCE = 2**20
_UNFINISHED = re.compile(r"\..+\.[0-9a-f]{16}")
"""Name of a file that is being written, see ``atomic_file``."""


def place_of(url: str) -> tuple[AbstractFileSystem, str]:
    """Return the file system of a folder or URL and the path in it.

    Raises:
        ValueError: for a store that is unknown, or whose package is missing.
    """
    try:
        return url_to_fs(str(url))
    except (ImportError, ValueError) as error:
        raise ValueError(f"place: expected a folder or a URL that fsspec can open, got {url} ({error})") from None


@contextmanager
def reached(url: str, parameter: str) -> Iterator[None]:
    """Raise ValueError, which names the parameter, in place of what a store that is not reached raises."""
    try:
        yield
    except Exception as error:
        of_client = type(error).__module__.partition(".")[0] in _CLIENTS
        # A worker that ended is an OSError too.
        of_way = isinstance(error, OSError) and not isinstance(error, FileNotFoundError | ChildProcessError)
        if isinstance(place_of(url)[0], LocalFileSystem) or not (of_client or of_way):
            raise
        why = " ".join(str(error).split())
        raise ValueError(f"{parameter}: expected a store that can be reached, got {url!r} ({why})") from None


def new_folder(url: str) -> None:
    """Make the folder ``out``, or check the bucket that it is to lie in.

    Raises:
        ValueError: if it cannot be written, or there is no such bucket.
    """
    files, root = place_of(url)
    if isinstance(files, LocalFileSystem):
        make_folder(Path(root), "out")
    elif "memory" not in files.protocol:
        # A store makes a bucket of a name that was mistyped, for all the world to see.
        bucket = root.partition("/")[0]
        with reached(url, "out"):
            try:
                files.info(bucket)
            except FileNotFoundError:
                expected = "out: expected a bucket that exists"
                raise ValueError(f"{expected}, got {url!r} without a bucket {bucket!r}") from None
            except PermissionError:
                # It is there: the right to write does not include the right to list.
                pass


def put(files: AbstractFileSystem, path: str, content: bytes) -> None:
    """Write a whole file, or nothing of it."""
    if isinstance(files, LocalFileSystem):
        write_atomic(Path(path), content)
    else:
        # Stores write whole objects.
        files.pipe_file(path, content)


def put_new(files: AbstractFileSystem, path: str, content: bytes) -> None:
    """Write a whole file unless there is one; of several processes at once, one does. On a store the last one does."""
    if not isinstance(files, LocalFileSystem):
        put(files, path, content)
        return
    target = Path(path)
    beside = target.with_name(f".{target.name}.{secrets.token_hex(8)}")
    beside.write_bytes(content)
    try:
        os.link(beside, target)
    except FileExistsError:
        pass
    except OSError:
        # A disk on which files have no second names.
        if not target.exists():
            beside.replace(target)
    finally:
        beside.unlink(missing_ok=True)


def clear_unfinished(folder: str) -> None:
    """Remove what killed runs have left of files of a folder of this machine that ``put`` and others write whole."""
    for path in Path(folder).glob(".*"):
        if path.name == PROBE or _UNFINISHED.fullmatch(path.name):
            path.unlink(missing_ok=True)


@contextmanager
def whole_file(files: AbstractFileSystem, path: str) -> Iterator[IO[bytes]]:
    """Yield a file to write, which appears under its name when it is whole."""
    if not isinstance(files, LocalFileSystem):
        with files.open(path, "wb") as file:
            yield file
    else:
        with atomic_file(Path(path)) as file:
            yield file


def size_and_sha256(files: AbstractFileSystem, path: str) -> tuple[int, bytes]:
    """Return the size of a file and the SHA-256 of its bytes. Raises FileNotFoundError."""
    # A set has hundreds of thousands of files: on this machine they are opened without detours.
    is_local = isinstance(files, LocalFileSystem)
    sha256, size = hashlib.sha256(), 0
    with open(path, "rb", buffering=0) if is_local else files.open(path, "rb") as file:
        while part := file.read(_READ_AT_ONCE):
            sha256.update(part)
            size += len(part)
    return size, sha256.digest()
