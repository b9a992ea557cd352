"""Folders and stores that data sets lie in."""

from __future__ import annotations

from pathlib import Path

import fsspec
from fsspec import AbstractFileSystem
from fsspec.core import url_to_fs
from fsspec.implementations.local import LocalFileSystem

from trackers.atomic_file import write_atomic

_STORES = {"file", "s3", "gs", "az", "memory"}


def place_of(url: str) -> tuple[AbstractFileSystem, str]:
    """Return the file system of a folder or URL and the path in it.

    Raises:
        ValueError: for a store that is unknown, or whose package is missing.
    """
    try:
        return url_to_fs(str(url))
    except ImportError as error:
        raise ValueError(f"place: expected one that can be reached, got {url} ({error})") from None
    except ValueError as error:
        known = ", ".join(sorted({*fsspec.available_protocols()} & _STORES))
        raise ValueError(f"place: expected a folder or a URL with one of {known}, got {url} ({error})") from None


def lasting(url: str) -> str:
    """Return a folder or URL as workers in other folders understand it."""
    files, path = place_of(url)
    return path if isinstance(files, LocalFileSystem) else url


def put(files: AbstractFileSystem, path: str, content: bytes) -> None:
    """Write a whole file, or nothing of it."""
    if isinstance(files, LocalFileSystem):
        write_atomic(Path(path), content)
    else:
        # Stores write whole objects.
        files.pipe_file(path, content)
