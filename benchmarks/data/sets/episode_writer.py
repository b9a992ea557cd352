"""Writes one episode: tables, shards and, last of all, its mark, without which it does not exist.

Background pictures, which several episodes may share, lie in a folder of their own, likewise with a mark; that of each
episode names them, with their checksums.

Shards are tar files with the coded channels of many frames. Any program can open them; the place of each value stands
in the table of frames, so that one value is read without the others.
"""

from __future__ import annotations

import hashlib
import io
import json
import secrets
import shutil
import tarfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from fsspec import AbstractFileSystem
from fsspec.implementations.local import LocalFileSystem
from numpy.typing import NDArray

from benchmarks.data.codec import plain
from benchmarks.data.sets import tables
from benchmarks.data.sets.channels import CODINGS, PICTURES, coding_of, encoded, value_of
from benchmarks.data.sets.request import Request
from scenarios import catalog
from scenarios.scenario import Episode
from scenarios.truth import Truth, check_truth, without_pixels
from trackers.types import Observation

MARK, BACKGROUND_MARK = "episode.json", "background.json"
_UNFINISHED = ".unfinished-"
ROWS_AT_ONCE = 256
"""Frames of a row group: what is held in memory until it is written."""
SHARD_BYTES = 512 * 2**20
"""Size from which a new shard begins."""
_MARKS_AT_ONCE = 500


@dataclass(frozen=True)
class Place:
    """Where a value lies: ``bytes`` bytes of shard number ``shard`` from ``offset`` on."""

    shard: int
    offset: int
    bytes: int


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
    def mark(self) -> dict[str, Any]:
        """Size and checksum so far."""
        return {"bytes": self._bytes, "sha256": self._sha256.hexdigest()}


class ShardWriter:
    """Writes values into the shards ``NAME-00000.tar`` … of a folder.

    Attributes:
        written: name -> all shards so far.
    """

    def __init__(self, files: AbstractFileSystem, folder: str, name: str, shard_bytes: int | None = None) -> None:
        self._files, self._folder, self._name = files, folder, name
        self._limit = SHARD_BYTES if shard_bytes is None else shard_bytes
        self.written: dict[str, MarkedFile] = {}
        self._file: MarkedFile | None = None

    def add(self, name: str, coded: bytes) -> Place:
        """Append a value under a name; return its place."""
        if self._file is not None and self._file.tell() > self._limit:
            self.finish()
        if self._file is None:
            shard = shard_name(self._name, len(self.written))
            self._file = self.written[shard] = MarkedFile(self._files, f"{self._folder}/{shard}")
        member = tarfile.TarInfo(name)
        member.size = len(coded)
        # Names above 100 characters take a header more.
        self._file.write(member.tobuf(tarfile.PAX_FORMAT))
        place = Place(len(self.written) - 1, self._file.tell(), len(coded))
        self._file.write(coded)
        self._file.write(bytes(-len(coded) % tarfile.BLOCKSIZE))
        return place

    def finish(self) -> None:
        """Finish the current shard."""
        if self._file is not None:
            with self._file as file:
                # Two empty blocks end a tar file.
                file.write(bytes(2 * tarfile.BLOCKSIZE))
            self._file = None


def shard_name(name: str, shard: int) -> str:
    """Return the file name of a shard."""
    return f"{name}-{shard:05d}.tar"


def episode_folder(root: str, seed: int) -> str:
    """Return the folder of an episode in a data set."""
    return f"{root}/episodes/{seed:06d}"


def background_folder(root: str, day: int) -> str:
    """Return the folder of background pictures in a data set; ``day``: see ``Request.day_of``."""
    return f"{root}/backgrounds/{day:06d}"


def read_mark(files: AbstractFileSystem, folder: str, name: str = MARK) -> dict[str, Any]:
    """Return an episode's mark. Raises ValueError if it is damaged, FileNotFoundError if there is none."""
    try:
        mark: dict[str, Any] = json.loads(files.cat_file(f"{folder}/{name}"))
    except ValueError as error:
        raise ValueError(f"{folder}/{name}: expected the mark of an episode, got {error}") from None
    return mark


def read_marks(files: AbstractFileSystem, root: str, seeds: Sequence[int]) -> Iterator[tuple[int, bytes]]:
    """Yield seed and mark of each episode that was written to its end, of those of ``seeds``, in their order."""
    is_local = isinstance(files, LocalFileSystem)
    for first in range(0, len(seeds), _MARKS_AT_ONCE):
        paths = {f"{episode_folder(root, seed)}/{MARK}": seed for seed in seeds[first : first + _MARKS_AT_ONCE]}
        # Stores are asked for many at once.
        found = {} if is_local else files.cat(list(paths), on_error="omit")
        for path, seed in paths.items():
            mark = _local(path) if is_local else found.get(path)
            with suppress(ValueError):
                if mark is not None and json.loads(mark):
                    yield seed, mark


def _local(path: str) -> bytes | None:
    try:
        with open(path, "rb", buffering=0) as file:
            return file.read()
    except (FileNotFoundError, NotADirectoryError):
        return None


def is_whole(files: AbstractFileSystem, root: str, seed: int) -> bool:
    """Return whether an episode was written to its end."""
    return _has_mark(files, episode_folder(root, seed), MARK)


def has_background(files: AbstractFileSystem, root: str, day: int) -> bool:
    """Return whether background pictures were written to their end."""
    return _has_mark(files, background_folder(root, day), BACKGROUND_MARK)


def _has_mark(files: AbstractFileSystem, folder: str, name: str) -> bool:
    try:
        read_mark(files, folder, name)
    except (FileNotFoundError, ValueError):
        return False
    return True


def write_episode(files: AbstractFileSystem, root: str, request: Request, seed: int, live: Episode) -> None:
    """Run an episode and write it, and its background pictures if they are not there yet.

    After a failure nothing of it is left.
    """
    background = write_background(files, root, request, seed, live) if request.background else None

    def write(opened: EpisodeFiles) -> dict[str, Any]:
        _write_frames(opened, request, seed, live)
        return {
            "seed": seed,
            "frame_count": live.frame_count,
            "rate_hz": live.rate_hz,
            "start": {name: plain(getattr(live.start, name)) for name in ("camera", "box_xyxy", "site")},
            "background": background,
        }

    _write_folder(files, episode_folder(root, seed), MARK, write)


def write_background(
    files: AbstractFileSystem, root: str, request: Request, seed: int, live: Episode
) -> dict[str, Any] | None:
    """Write the pictures without targets that trackers learn from, if there are any and they are not there yet.

    Returns:
        ``day``, see ``Request.day_of``, and ``files``, size and checksum of each; None if there are no pictures.
    """
    day = request.day_of(seed)
    folder = background_folder(root, day)
    if not has_background(files, root, day):
        pictures = live.start.background
        if not pictures:
            return None

        def write(opened: EpisodeFiles) -> dict[str, Any]:
            _write_pictures(opened, request, pictures)
            return {"day": day}

        _write_folder(files, folder, BACKGROUND_MARK, write)
    return read_mark(files, folder, BACKGROUND_MARK)


def _write_folder(
    files: AbstractFileSystem, final: str, mark_name: str, write: Callable[[EpisodeFiles], dict[str, Any]]
) -> None:
    """Write a folder's files and, last of all, what ``write`` returns with their checksums, its mark.

    In a folder of this machine it is written beside and moved: a worker that outlived a killed run may still be writing
    the same one.
    """
    is_local = isinstance(files, LocalFileSystem)
    parent, name = final.rsplit("/", 1)
    folder = f"{parent}/{_UNFINISHED}{name}-{secrets.token_hex(8)}" if is_local else final
    files.makedirs(folder, exist_ok=True)
    try:
        with EpisodeFiles(files, folder) as opened:
            mark = write(opened)
        mark["files"] = opened.marks()
        files.pipe_file(f"{folder}/{mark_name}", (json.dumps(mark, indent=1) + "\n").encode())
        if is_local:
            # One that is there already is the same, unless its mark is gone.
            if not _has_mark(files, final, mark_name):
                shutil.rmtree(final, ignore_errors=True)
            try:
                Path(folder).rename(final)
            except OSError:
                if not _has_mark(files, final, mark_name):
                    raise
                shutil.rmtree(folder)
    except BaseException:
        # Another run on the same data set may have cleared it away.
        with suppress(FileNotFoundError):
            files.rm(folder, recursive=True)
        raise


def clear(files: AbstractFileSystem, root: str, seeds: range, backgrounds: bool = False) -> None:
    """Remove what killed runs have left of episodes of these seeds; of ``backgrounds`` too, if no other job is left."""
    if isinstance(files, LocalFileSystem):
        for folder in Path(root, "episodes").glob(f"{_UNFINISHED}*"):
            if int(folder.name.removeprefix(_UNFINISHED).partition("-")[0]) in seeds:
                shutil.rmtree(folder, ignore_errors=True)
        for folder in Path(root, "backgrounds").glob(f"{_UNFINISHED}*") if backgrounds else ():
            shutil.rmtree(folder, ignore_errors=True)


class EpisodeFiles(ExitStack):
    """The files of one episode, being written; the end of the context closes them."""

    def __init__(self, files: AbstractFileSystem, folder: str) -> None:
        super().__init__()
        self._files, self._folder = files, folder
        self._tables: dict[str, MarkedFile] = {}
        self._shards: list[ShardWriter] = []

    def table(self, name: str, schema: pa.Schema) -> pq.ParquetWriter:
        """Open a table."""
        file = self.enter_context(MarkedFile(self._files, f"{self._folder}/{name}.parquet"))
        self._tables[f"{name}.parquet"] = file
        return self.enter_context(pq.ParquetWriter(file, schema, compression="zstd"))

    def shards(self, name: str) -> ShardWriter:
        """Open shards."""
        self._shards.append(ShardWriter(self._files, self._folder, name))
        self.callback(self._shards[-1].finish)
        return self._shards[-1]

    def marks(self) -> dict[str, dict[str, Any]]:
        """Return size and checksum of each file by name, after the context."""
        written = self._tables | {name: file for shards in self._shards for name, file in shards.written.items()}
        return {name: written[name].mark for name in sorted(written)}


def _write_frames(opened: EpisodeFiles, request: Request, seed: int, live: Episode) -> None:
    """Run an episode and write its frames, and the objects of these."""
    kind = catalog.scenario(request.scenario).truth
    schema, shards = tables.frame_schema(kind, request.channels), opened.shards("pixels")
    frames = opened.table("frames", schema)
    objects = {name: opened.table(name, tables.object_schema(kind, name)) for name in ("objects", "standing")}
    for first in range(0, live.frame_count, ROWS_AT_ONCE):
        rows: list[dict[str, Any]] = []
        truths: list[Truth] = []
        boxes: dict[str, list[NDArray[np.float64]]] = {name: [] for name in objects}
        for _ in range(first, min(first + ROWS_AT_ONCE, live.frame_count)):
            frame = live.step()
            truth = frame.truth
            if truth.frame == 0:
                check_truth(truth)
            values = ((channel, value_of(frame, channel, live.normals)) for channel in request.channels)
            places = _written(shards, truth.frame, values, request.pictures)
            rows.append(tables.frame_row(truth, frame.observation) | {"seed": seed} | places)
            for name, ids in (("objects", truth.instance_id), ("standing", truth.standing_id)):
                boxes[name].append(tables.visible_boxes(truth.instance_map, ids))
            truths.append(without_pixels(truth))
        frames.write_table(pa.Table.from_pylist(rows, schema))
        for name, table in objects.items():
            table.write_table(tables.object_table(truths, boxes[name], seed, name))


def _write_pictures(opened: EpisodeFiles, request: Request, background: Sequence[Observation]) -> None:
    """Write background pictures with the coding of others."""
    pictures = tuple(channel for channel in request.channels if channel in PICTURES)
    schema, shards = tables.observation_schema(pictures), opened.shards("background")
    rows = []
    for k, observation in enumerate(background):
        values = ((channel, getattr(observation, channel)) for channel in pictures)
        rows.append(tables.observation_row(observation) | _written(shards, k, values, request.pictures))
    opened.table("background", schema).write_table(pa.Table.from_pylist(rows, schema))


def _written(
    shards: ShardWriter, number: int, values: Iterable[tuple[str, NDArray[Any] | None]], pictures: str
) -> dict[str, dict[str, int] | None]:
    """Write a frame's values by channel, pictures in the coding ``pictures``; return the place of each that exists."""
    places: dict[str, dict[str, int] | None] = {}
    for channel, value in values:
        places[channel] = None
        if value is not None:
            extension = CODINGS[coding_of(channel, pictures)].extension
            coded = encoded(channel, pictures, value)
            places[channel] = asdict(shards.add(f"{number:06d}.{channel}.{extension}", coded))
    return places
