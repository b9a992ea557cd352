"""Shards: the coded channels of many frames in tar files, each value at a known place.

Any program can open a tar file; the place of each value stands in the table of frames, so that one value is read
without the others.
"""

from __future__ import annotations

import hashlib
import io
import tarfile
from dataclasses import dataclass
from typing import Any, BinaryIO

from fsspec import AbstractFileSystem

SHARD_BYTES = 512 * 2**20
"""Size from which a new shard begins."""


@dataclass(frozen=True)
class Place:
    """Where a value lies: ``bytes`` bytes of shard number ``shard`` from ``offset`` on."""

    shard: int
    offset: int
    bytes: int


@dataclass(frozen=True)
class FileMark:
    """What a stored file is known by: its size and SHA-256."""

    bytes: int
    sha256: str


class MarkedFile(io.RawIOBase):
    """A file being written, with its size and its SHA-256 so far."""

    def __init__(self, files: AbstractFileSystem, path: str) -> None:
        self._file: BinaryIO = files.open(path, "wb")
        self._sha256, self._bytes = hashlib.sha256(), 0

    def writable(self) -> bool:
        """It is."""
        return True

    def write(self, data: Any) -> int:
        """Write bytes; return their number."""
        written = memoryview(data).nbytes
        self._file.write(data)
        self._sha256.update(data)
        self._bytes += written
        return written

    def tell(self) -> int:
        """Return the number of bytes so far."""
        return self._bytes

    def close(self) -> None:
        """Finish the file."""
        if not self.closed:
            self._file.close()
        super().close()

    @property
    def mark(self) -> FileMark:
        """Size and checksum so far."""
        return FileMark(self._bytes, self._sha256.hexdigest())


class ShardWriter:
    """Writes values into the shards ``NAME-00000.tar`` … of a folder.

    Attributes:
        marks: name -> mark of all finished shards.
    """

    def __init__(self, files: AbstractFileSystem, folder: str, name: str, shard_bytes: int = SHARD_BYTES) -> None:
        self._files, self._folder, self._name, self._limit = files, folder, name, shard_bytes
        self.marks: dict[str, FileMark] = {}
        self._file: MarkedFile | None = None

    def add(self, name: str, coded: bytes) -> Place:
        """Append a value under a name; return its place."""
        if self._file is not None and self._file.tell() > self._limit:
            self.finish()
        if self._file is None:
            self._file = MarkedFile(self._files, f"{self._folder}/{shard_name(self._name, len(self.marks))}")
        member = tarfile.TarInfo(name)
        member.size = len(coded)
        # Names above 100 characters take a header more.
        self._file.write(member.tobuf(tarfile.PAX_FORMAT))
        place = Place(len(self.marks), self._file.tell(), len(coded))
        self._file.write(coded)
        self._file.write(bytes(-len(coded) % tarfile.BLOCKSIZE))
        return place

    def finish(self) -> None:
        """Finish the current shard."""
        if self._file is not None:
            # Two empty blocks end a tar file.
            self._file.write(bytes(2 * tarfile.BLOCKSIZE))
            self._file.close()
            self.marks[shard_name(self._name, len(self.marks))] = self._file.mark
        self._file = None

    def abandon(self) -> None:
        """Close what is open, after a failure."""
        if self._file is not None:
            self._file.close()


def shard_name(name: str, shard: int) -> str:
    """Return the file name of a shard."""
    return f"{name}-{shard:05d}.tar"
