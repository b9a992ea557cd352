"""Writes one episode: tables, shards and, last of all, its mark, without which it does not exist."""

from __future__ import annotations

import dataclasses
import json
import secrets
import shutil
from collections.abc import Iterable, Sequence
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
from benchmarks.data.sets.shards import FileMark, MarkedFile, ShardWriter
from benchmarks.data.sets.visible_boxes import visible_boxes
from scenarios import catalog
from scenarios.scenario import Episode
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
    kind = catalog.scenario(request.scenario).truth
    with ExitStack() as stack:
        marks = write_background(stack, files, folder, request, live.start.background)
        frames = _Frames(stack, files, folder, "frames", "pixels", tables.frame_schema(kind, request.channels))
        objects = {
            name: _Table(stack, files, f"{folder}/{name}.parquet", tables.object_schema(kind, name))
            for name in ("objects", "standing")
        }
        for first in range(0, live.frame_count, ROWS_AT_ONCE):
            truths: list[Truth] = []
            boxes: dict[str, list[NDArray[np.float64]]] = {name: [] for name in objects}
            for _ in range(first, min(first + ROWS_AT_ONCE, live.frame_count)):
                frame = live.step()
                truth = frame.truth
                if truth.frame == 0:
                    check_truth(truth)
                row = tables.frame_row(truth, frame.observation) | {"seed": seed}
                values = ((channel, value_of(frame, channel, live.normals)) for channel in request.channels)
                frames.add(truth.frame, row, values, request.pictures)
                for name, ids in (("objects", truth.instance_id), ("standing", truth.standing_id)):
                    boxes[name].append(visible_boxes(truth.instance_map, ids))
                truths.append(without_pixels(truth))
            frames.flush()
            for name, table in objects.items():
                table.write(tables.object_table(truths, boxes[name], seed, name))
        return marks | frames.close() | {f"{name}.parquet": each.close() for name, each in objects.items()}


class _Table:
    """A Parquet file being written; ``stack`` closes it."""

    def __init__(self, stack: ExitStack, files: AbstractFileSystem, path: str, schema: pa.Schema) -> None:
        self.schema = schema
        self._file = MarkedFile(files, path)
        self._writer = pq.ParquetWriter(self._file, schema, compression="zstd")
        stack.callback(self.close)

    def write(self, table: pa.Table) -> None:
        """Append a row group."""
        self._writer.write_table(table)

    def close(self) -> FileMark:
        """Finish the file, once; return its mark."""
        self._writer.close()
        self._file.close()
        return self._file.mark


class _Frames:
    """A table of frames and the shards with their channels, being written; ``stack`` closes them."""

    def __init__(
        self, stack: ExitStack, files: AbstractFileSystem, folder: str, name: str, shards: str, schema: pa.Schema
    ) -> None:
        self._name, self._rows = f"{name}.parquet", list[dict[str, Any]]()
        self._table = _Table(stack, files, f"{folder}/{self._name}", schema)
        self._shards = ShardWriter(files, folder, shards)
        stack.callback(self._shards.abandon)

    def add(
        self, number: int, row: dict[str, Any], values: Iterable[tuple[str, NDArray[Any] | None]], pictures: str
    ) -> None:
        """Append a frame: its row, and values by channel; ``pictures``: coding of those."""
        for channel, value in values:
            row[channel] = None
            if value is not None:
                coding = CODINGS[coding_of(channel, pictures)]
                place = self._shards.add(f"{number:06d}.{channel}.{coding.extension}", coding.encode(value))
                row[channel] = dataclasses.asdict(place)
        self._rows.append(row)

    def flush(self) -> None:
        """Write the rows so far as a row group."""
        self._table.write(pa.Table.from_pylist(self._rows, self._table.schema))
        self._rows = []

    def close(self) -> dict[str, FileMark]:
        """Finish all files; return their marks."""
        self._shards.finish()
        return {self._name: self._table.close(), **self._shards.marks}


def write_background(
    stack: ExitStack, files: AbstractFileSystem, folder: str, request: Request, background: Sequence[Observation]
) -> dict[str, FileMark]:
    """Write the pictures without targets that trackers learn from, if there are any, with the coding of others.

    ``stack`` closes the files.
    """
    if not background:
        return {}
    pictures = tuple(channel for channel in request.channels if channel in PICTURES)
    schema = tables.observation_schema(pictures)
    frames = _Frames(stack, files, folder, "background", "background", schema)
    for k, observation in enumerate(background):
        values = ((channel, getattr(observation, channel)) for channel in pictures)
        frames.add(k, tables.observation_row(observation), values, request.pictures)
    frames.flush()
    return frames.close()


def _start_row(start: Start) -> dict[str, Any]:
    box = start.box_xyxy
    return {
        "camera": dataclasses.asdict(start.camera),
        "box_xyxy": None if box is None else box.tolist(),
        "site": None if start.site is None else dataclasses.asdict(start.site),
    }
