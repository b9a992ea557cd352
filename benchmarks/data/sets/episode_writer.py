"""Writes one episode: tables, shards and, last of all, its mark, without which it does not exist."""

from __future__ import annotations

import dataclasses
import json
import secrets
import shutil
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from fsspec import AbstractFileSystem
from fsspec.implementations.local import LocalFileSystem
from numpy.typing import NDArray

from benchmarks.data.sets import tables
from benchmarks.data.sets.channels import CODINGS, PICTURES, coding_of, value_of
from benchmarks.data.sets.request import Request
from benchmarks.data.sets.shards import FileMark, MarkedFile, Place, ShardWriter
from benchmarks.data.sets.visible_boxes import visible_boxes
from scenarios import catalog
from scenarios.scenario import Episode, Frame
from scenarios.truth import Truth, check_truth, without_pixels
from trackers.types import Observation, Start

MARK = "episode.json"
_UNFINISHED = ".unfinished-"
ROWS_AT_ONCE = 256
"""Frames of a row group: what is held in memory until it is written."""


def episode_folder(root: str, seed: int) -> str:
    """Return the folder of an episode in a data set."""
    return f"{root}/episodes/{seed:06d}"


def read_mark(files: AbstractFileSystem, folder: str) -> dict[str, Any]:
    """Return an episode's mark. Raises ValueError if it is damaged, FileNotFoundError if there is none."""
    try:
        mark: dict[str, Any] = json.loads(files.cat_file(f"{folder}/{MARK}"))
        for key in ("seed", "frame_count", "rate_hz", "start", "files"):
            mark[key]
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{folder}/{MARK}: expected the mark of an episode, got {error}") from None
    return mark


def write_episode(files: AbstractFileSystem, root: str, request: Request, seed: int, live: Episode) -> None:
    """Run an episode and write it; after a failure nothing of it is left.

    In a folder of this machine it is written beside and moved: a worker that outlived a killed run may still be writing
    the same one.
    """
    final = episode_folder(root, seed)
    is_local = isinstance(files, LocalFileSystem)
    folder = f"{root}/episodes/{_UNFINISHED}{seed:06d}-{secrets.token_hex(8)}" if is_local else final
    files.makedirs(folder, exist_ok=True)
    try:
        marks = _write_files(files, folder, request, seed, live)
        mark = {
            "seed": seed,
            "frame_count": live.frame_count,
            "rate_hz": live.rate_hz,
            "start": _start_row(live.start),
            "files": {name: dataclasses.asdict(mark) for name, mark in sorted(marks.items())},
        }
        files.pipe_file(f"{folder}/{MARK}", (json.dumps(mark, indent=1) + "\n").encode())
        if is_local:
            _move(files, Path(folder), Path(final))
    except BaseException:
        # Another run on the same data set may have cleared it away.
        with suppress(FileNotFoundError):
            files.rm(folder, recursive=True)
        raise


def clear(files: AbstractFileSystem, root: str) -> None:
    """Remove what killed runs have left."""
    if isinstance(files, LocalFileSystem):
        for folder in Path(root, "episodes").glob(f"{_UNFINISHED}*"):
            shutil.rmtree(folder, ignore_errors=True)


def _move(files: LocalFileSystem, folder: Path, final: Path) -> None:
    """Move a finished episode to its place. One that is there already is the same, unless its mark is gone."""
    try:
        folder.rename(final)
    except OSError:
        if not final.is_dir():
            raise
        try:
            read_mark(files, str(final))
        except (ValueError, FileNotFoundError):
            shutil.rmtree(final)
            folder.rename(final)
        else:
            shutil.rmtree(folder)


def _write_files(
    files: AbstractFileSystem, folder: str, request: Request, seed: int, live: Episode
) -> dict[str, FileMark]:
    with ExitStack() as stack:
        marks = write_background(stack, files, folder, request, live.start.background)
        writer = stack.enter_context(_Writer(files, folder, request, seed))
        for _ in range(live.frame_count):
            writer.add(live.step(), live.normals)
        return marks | writer.finish()


class _Writer:
    """The open tables and shards of an episode."""

    def __init__(self, files: AbstractFileSystem, folder: str, request: Request, seed: int) -> None:
        kind = catalog.scenario(request.scenario).truth
        self._request, self._seed = request, seed
        self._frames = _Table(files, f"{folder}/frames.parquet", tables.frame_schema(kind, request.channels))
        self._objects = {
            name: _Table(files, f"{folder}/{name}.parquet", tables.object_schema(kind, name))
            for name in ("objects", "standing")
        }
        self._shards = ShardWriter(files, folder, "pixels")
        self._rows: list[dict[str, Any]] = []
        self._truths: list[Truth] = []
        self._boxes: dict[str, list[NDArray[np.float64]]] = {name: [] for name in self._objects}

    def __enter__(self) -> _Writer:
        return self

    def __exit__(self, *_: object) -> None:
        """Close what is open."""
        for each in (self._frames, *self._objects.values()):
            each.close()
        self._shards.abandon()

    def add(self, frame: Frame, normals: Callable[[], NDArray[np.float32]]) -> None:
        truth = frame.truth
        if truth.frame == 0:
            check_truth(truth)
        row = tables.frame_row(truth, frame.observation)
        for channel in self._request.channels:
            value = value_of(frame, channel, normals)
            pictures = self._request.pictures
            row[channel] = None if value is None else _add(self._shards, truth.frame, channel, value, pictures)
        self._rows.append(row | {"seed": self._seed})
        for name, ids in (("objects", truth.instance_id), ("standing", truth.standing_id)):
            self._boxes[name].append(visible_boxes(truth.instance_map, ids))
        self._truths.append(without_pixels(truth))
        if len(self._rows) == ROWS_AT_ONCE:
            self._flush()

    def finish(self) -> dict[str, FileMark]:
        """Write what is left; return the marks of all files."""
        self._flush()
        self._shards.finish()
        return {
            "frames.parquet": self._frames.close(),
            **{f"{name}.parquet": each.close() for name, each in self._objects.items()},
            **self._shards.marks,
        }

    def _flush(self) -> None:
        if self._rows:
            self._frames.write(pa.Table.from_pylist(self._rows, self._frames.schema))
            for name, table in self._objects.items():
                table.write(tables.object_table(self._truths, self._boxes[name], self._seed, name))
        self._rows, self._truths, self._boxes = [], [], {name: [] for name in self._objects}


class _Table:
    """A Parquet file being written."""

    def __init__(self, files: AbstractFileSystem, path: str, schema: pa.Schema) -> None:
        self.schema = schema
        self._file = MarkedFile(files, path)
        self._writer = pq.ParquetWriter(self._file, schema, compression="zstd")

    def write(self, table: pa.Table) -> None:
        """Append a row group."""
        self._writer.write_table(table)

    def close(self) -> FileMark:
        """Finish the file, once; return its mark."""
        self._writer.close()
        self._file.close()
        return self._file.mark


def write_background(
    stack: ExitStack, files: AbstractFileSystem, folder: str, request: Request, background: Sequence[Observation]
) -> dict[str, FileMark]:
    """Write the pictures without targets that trackers learn from, if there are any, with the coding of others.

    ``stack`` closes the files.
    """
    if not background:
        return {}
    pictures = tuple(channel for channel in request.channels if channel in PICTURES)
    shards = ShardWriter(files, folder, "background")
    stack.callback(shards.abandon)
    schema = tables.observation_schema(pictures)
    table = _Table(files, f"{folder}/background.parquet", schema)
    stack.callback(table.close)
    rows = []
    for k, observation in enumerate(background):
        row = tables.observation_row(observation)
        for channel in pictures:
            value = getattr(observation, channel)
            row[channel] = None if value is None else _add(shards, k, channel, value, request.pictures)
        rows.append(row)
    shards.finish()
    table.write(pa.Table.from_pylist(rows, schema))
    return {"background.parquet": table.close(), **shards.marks}


def _add(shards: ShardWriter, frame: int, channel: str, value: NDArray[Any], pictures: str) -> dict[str, int]:
    coding = CODINGS[coding_of(channel, pictures)]
    place: Place = shards.add(f"{frame:06d}.{channel}.{coding.extension}", coding.encode(value))
    return dataclasses.asdict(place)


def _start_row(start: Start) -> dict[str, Any]:
    box = start.box_xyxy
    return {
        "camera": dataclasses.asdict(start.camera),
        "box_xyxy": None if box is None else box.tolist(),
        "site": None if start.site is None else dataclasses.asdict(start.site),
    }
