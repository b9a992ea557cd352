"""An episode read back: the same observations and truths as when it was made, without rendering."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from threading import Lock
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from fsspec import AbstractFileSystem
from numpy.typing import NDArray
from pyarrow import ArrowException

from benchmarks.data.sets import tables
from benchmarks.data.sets.channels import CODINGS, NORMALS, PICTURES, coding_of
from benchmarks.data.sets.episode_writer import ROWS_AT_ONCE, read_mark
from benchmarks.data.sets.request import Request
from benchmarks.data.sets.shards import shard_name
from scenarios import catalog
from scenarios.scenario import Frame
from sim.checks import check
from trackers.types import CameraCommand, CameraModel, Observation, SiteSurvey, Start

_KEPT_GROUPS = 4
"""Row groups that are kept for reading in any order: an episode's length costs no memory."""


@dataclass(frozen=True, slots=True)
class _Group:
    """A row group of all tables.

    Attributes:
        rows: of ``frames``. fields: table of objects -> field -> (K, …) of all objects of these frames.
        ends: table of objects -> (frames + 1,) where each frame's objects begin.
    """

    rows: list[dict[str, Any]]
    fields: dict[str, dict[str, NDArray[Any]]]
    ends: dict[str, NDArray[np.int64]]

    def objects(self, table: str, at: int) -> dict[str, NDArray[Any]]:
        """Return the fields of one frame's objects."""
        part = slice(*self.ends[table][at : at + 2])
        return {name: values[part] for name, values in self.fields[table].items()}


class StoredEpisode:
    """See ``scenarios.scenario.Episode``; frames can also be read in any order.

    Attributes:
        seed, frame_count, rate_hz: of the episode.
        marks: name -> size and SHA-256 of its files.
    """

    closed_loop = False

    def __init__(self, files: AbstractFileSystem, folder: str, request: Request) -> None:
        """Open an episode. Raises ValueError if its mark is damaged, FileNotFoundError if there is none."""
        self._files, self._folder, self._request = files, folder, request
        self._scenario = catalog.scenario(request.scenario)
        mark = read_mark(files, folder)
        self.seed, self.frame_count, self.rate_hz = mark["seed"], mark["frame_count"], mark["rate_hz"]
        self.marks: dict[str, dict[str, Any]] = mark["files"]
        self._start = mark["start"]
        self._next = 0
        self._live: Any = None
        self._groups: dict[int, _Group] = {}
        self._open: dict[tuple[int, str], Any] = {}
        self._lock = Lock()

    def __getstate__(self) -> dict[str, Any]:
        """Without open files and the lock: another process has its own."""
        return {name: value for name, value in self.__dict__.items() if name != "_lock"} | {"_open": {}, "_live": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__ |= state | {"_lock": Lock()}

    def __len__(self) -> int:
        """Return the number of frames."""
        return int(self.frame_count)

    def __iter__(self) -> Iterator[Frame]:
        """Yield all frames in order."""
        return map(self.frame, range(self.frame_count))

    @property
    def preset(self) -> Any:
        """The configuration of the episode, see its scenario."""
        return self._scenario.presets[self._request.preset]

    @property
    def camera(self) -> CameraModel:
        """The camera of the first frame."""
        return CameraModel(**self._start["camera"])

    @property
    def start(self) -> Start:
        """What a tracker gets before the first picture."""
        box, site = self._start["box_xyxy"], self._start["site"]
        return Start(
            self.camera,
            None if box is None else np.array(box),
            tuple(self._background()) if "background.parquet" in self.marks else (),
            None if site is None else SiteSurvey(**{name: _plain(value) for name, value in site.items()}),
        )

    def frame(self, index: int, channels: tuple[str, ...] | None = None) -> Frame:
        """Return a frame; of its pixels only ``channels``, None = all that are stored. Raises IndexError."""
        if not 0 <= index < self.frame_count:
            raise IndexError(f"frame: expected 0 to {self.frame_count - 1}, got {index}")
        group, at = self._group(index)
        row = group.rows[at]
        stored = self._request.channels
        wanted = stored if channels is None else channels
        check("channels", set(wanted) <= set(stored), f"some of {', '.join(stored)}", ", ".join(map(str, wanted)))
        pixels = {c: self._pixels("pixels", c, row[c]) for c in wanted if c != NORMALS and row[c] is not None}
        fields = {name: each for table in group.fields for name, each in group.objects(table, at).items()}
        truth = tables.truth_of(self._scenario.truth, row, fields, pixels)
        return Frame(tables.observation_of(row, _pictures(pixels)), truth)

    def normals_of(self, index: int) -> NDArray[np.float32]:
        """Return the normals of a frame, see ``Episode.normals``. Raises ValueError if they are not stored."""
        check("channels", NORMALS in self._request.channels, f"a data set with {NORMALS}", "one without")
        return self._pixels("pixels", NORMALS, self._row(index)[NORMALS])

    def visible_boxes_of(self, index: int, table: str = "objects") -> NDArray[np.float64]:
        """Return the boxes (N, 4) about the visible pixels of a frame's objects; NaN where none is seen.

        Args:
            table: ``objects``, or ``standing`` for those that stand about (S, 4).
        """
        group, at = self._group(index)
        return group.objects(table, at)[tables.VISIBLE_BOX] if table in group.fields else np.empty((0, 4))

    def rows(self) -> list[int]:
        """Return the numbers of the frames in the table, in its order."""
        table = self._table("frames", lambda file: pq.read_table(file, columns=["frame"]))
        found: list[int] = table["frame"].to_pylist()
        return found

    def coded(self, index: int, channel: str) -> tuple[str, bytes] | None:
        """Return the name of the coding and the stored bytes of a frame's channel; None if it has none."""
        place = self._row(index)[channel]
        return None if place is None else (coding_of(channel, self._request.pictures), self._bytes("pixels", place))

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame; see ``Episode.step``. Raises ValueError for a command, StopIteration at the end."""
        check("command", command is None, "None, since stored pictures cannot be steered", command)
        if self._next >= self.frame_count:
            raise StopIteration(f"episode: expected at most {self.frame_count} steps")
        self._next += 1
        return self.frame(self._next - 1)

    def normals(self) -> NDArray[np.float32]:
        """Return the normals of the current frame."""
        return self.normals_of(self._next - 1)

    def map_of(self) -> Any:
        """Return the scenario's map, of the same episode built anew without its pictures."""
        if self._live is None:
            self._live = self._request.episode(self.seed)
        return self._live.map_of()

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Raise ValueError: what surrounds the pictures is not stored."""
        raise ValueError(f"larger_view: expected a rendered episode, got a stored one (scale {scale:g})")

    def close(self) -> None:
        """Close all files, and forget the tables; what is read afterwards opens them again."""
        with self._lock:
            for file in self._open.values():
                file.close()
            self._open, self._groups = {}, {}
        if self._live is not None:
            self._live.close()

    def _row(self, index: int) -> dict[str, Any]:
        group, at = self._group(index)
        return group.rows[at]

    def _group(self, index: int) -> tuple[_Group, int]:
        """Return the rows that were written together with a frame's, and its place among them."""
        number, at = divmod(index, ROWS_AT_ONCE)
        found = self._groups.get(number)
        if found is None:
            found = _Group(self._row_group("frames", number).to_pylist(), {}, {})
            firsts = number * ROWS_AT_ONCE + np.arange(len(found.rows) + 1)
            for name in ("objects", "standing"):
                if f"{name}.parquet" in self.marks:
                    rows = self._row_group(name, number)
                    found.fields[name] = tables.object_arrays(self._scenario.truth, rows, name)
                    found.ends[name] = np.searchsorted(rows["frame"].to_numpy(), firsts)
            with self._lock:
                self._groups[number] = found
                if len(self._groups) > _KEPT_GROUPS:
                    self._groups.pop(next(iter(self._groups)))
        return found, at

    def _row_group(self, name: str, number: int) -> pa.Table:
        return self._table(name, lambda file: pq.ParquetFile(file).read_row_group(number))

    def _table(self, name: str, read: Callable[[Any], pa.Table] = pq.read_table) -> pa.Table:
        path = f"{self._folder}/{name}.parquet"
        try:
            with self._files.open(path, "rb") as file:
                return read(file)
        except (ArrowException, OSError, IndexError) as error:
            raise ValueError(f"{path}: expected a whole table, got {' '.join(str(error).split())}") from None

    def _background(self) -> Iterator[Observation]:
        for row in self._table("background").to_pylist():
            stored = (c for c in self._request.channels if c in PICTURES and row[c] is not None)
            yield tables.observation_of(row, {c: self._pixels("background", c, row[c]) for c in stored})

    def _pixels(self, shards: str, channel: str, place: dict[str, int]) -> NDArray[Any]:
        return CODINGS[coding_of(channel, self._request.pictures)].decode(self._bytes(shards, place))

    def _bytes(self, shards: str, place: dict[str, int]) -> bytes:
        name = shard_name(shards, place["shard"])
        # A forked process opens its own: it would share the place in the file with its parent and siblings.
        key = os.getpid(), name
        with self._lock:
            if key not in self._open:
                self._open[key] = self._files.open(f"{self._folder}/{name}", "rb")
            file = self._open[key]
            file.seek(place["offset"])
            found: bytes = file.read(place["bytes"])
        check(f"{self._folder}/{name}", len(found) == place["bytes"], f"{place['bytes']} bytes", len(found))
        return found


def _plain(value: Any) -> Any:
    """Return a number, or a list as a tuple."""
    return tuple(value) if isinstance(value, list) else value


def _pictures(pixels: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {channel: pixels[channel] for channel in PICTURES if channel in pixels}
