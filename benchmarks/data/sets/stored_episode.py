"""An episode read back: the same observations and truths as when it was made, without rendering."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, get_type_hints

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from fsspec import AbstractFileSystem
from numpy.typing import NDArray
from pyarrow import ArrowException

from benchmarks.data.codec import value_of
from benchmarks.data.sets import tables
from benchmarks.data.sets.channels import CODINGS, NORMALS, PICTURES, coding_of
from benchmarks.data.sets.episode_writer import ROWS_AT_ONCE, background_folder, read_mark, shard_name
from benchmarks.data.sets.request import Request
from scenarios import catalog
from scenarios.scenario import Frame
from sim.checks import check
from trackers.types import CameraCommand, CameraModel, Observation, Start

_KEPT_GROUPS = 4
"""Row groups that are kept for reading in any order: an episode's length costs no memory."""


_Objects = dict[str, dict[str, NDArray[Any]]]
"""Table -> field -> values (N, …) of one frame's objects."""


class StoredEpisode:
    """See ``scenarios.scenario.Episode``; frames can also be read in any order. No file is open between two calls.

    Attributes:
        seed, frame_count, rate_hz: of the episode.
        marks: name -> size and SHA-256 of its files.
        background_marks: likewise of the background pictures, which other episodes may share.
    """

    closed_loop = False

    def __init__(self, files: AbstractFileSystem, root: str, folder: str, request: Request) -> None:
        """Open the episode in a folder of the data set at ``root``.

        Raises:
            ValueError: if its mark is damaged. FileNotFoundError: if there is none.
        """
        self._files, self._folder, self._request = files, folder, request
        self._scenario = catalog.scenario(request.scenario)
        mark = read_mark(files, folder)
        self.seed, self.frame_count, self.rate_hz = mark["seed"], mark["frame_count"], mark["rate_hz"]
        self.marks: dict[str, dict[str, Any]] = mark["files"]
        shared = mark.get("background")
        self.background_marks: dict[str, dict[str, Any]] = self.marks if shared is None else shared["files"]
        self._background_folder = folder if shared is None else background_folder(root, shared["day"])
        hints = get_type_hints(Start)
        self._start = {name: value_of(value, hints[name]) for name, value in mark["start"].items()}
        self._next = 0
        self._live: Any = None
        self._groups: dict[int, list[tuple[dict[str, Any], _Objects]]] = {}

    def __getstate__(self) -> dict[str, Any]:
        """Without what is only kept: another process reads its own."""
        return self.__dict__ | {"_groups": {}, "_live": None}

    def __len__(self) -> int:
        """Return the number of frames."""
        return int(self.frame_count)

    def __iter__(self) -> Iterator[Frame]:
        """Yield all frames in order."""
        return map(self.frame, range(self.frame_count))

    @property
    def preset(self) -> Any:
        """The configuration of the episode, which the judge of ``frame-out`` asks for."""
        return self._request.configuration(self.seed)

    @property
    def camera(self) -> CameraModel:
        """The camera of the first frame."""
        return self._start["camera"]

    @property
    def start(self) -> Start:
        """What a tracker gets before the first picture."""
        return Start(**self._start, background=tuple(self._background()))

    def frame(self, index: int, channels: tuple[str, ...] | None = None) -> Frame:
        """Return a frame; of its pixels only ``channels``, None = all that are stored. Raises IndexError."""
        row, objects = self._row(index)
        stored = self._request.channels
        wanted = stored if channels is None else channels
        check("channels", set(wanted) <= set(stored), f"some of {', '.join(stored)}", ", ".join(map(str, wanted)))
        pixels = self._pixels(self._folder, "pixels", row, set(wanted) - {NORMALS})
        fields = {name: values for table in objects.values() for name, values in table.items()}
        truth = tables.truth_of(self._scenario.truth, row, fields, pixels)
        pictures = {channel: pixels[channel] for channel in PICTURES if channel in pixels}
        return Frame(tables.observation_of(row, pictures), truth)

    def normals_of(self, index: int) -> NDArray[np.float32]:
        """Return the normals of a frame, see ``Episode.normals``. Raises ValueError if they are not stored."""
        check("channels", NORMALS in self._request.channels, f"a data set with {NORMALS}", "one without")
        return self._pixels(self._folder, "pixels", self._row(index)[0], [NORMALS])[NORMALS]

    def visible_boxes_of(self, index: int, table: str = "objects") -> NDArray[np.float64]:
        """Return the boxes (N, 4) about the visible pixels of a frame's objects; NaN where none is seen.

        Args:
            table: ``objects``, or ``standing`` for those that stand about (S, 4).
        """
        objects = self._row(index)[1]
        return objects[table][tables.VISIBLE_BOX] if table in objects else np.empty((0, 4))

    def coded(self, index: int, channel: str) -> tuple[str, bytes] | None:
        """Return the name of the coding and the stored bytes of a frame's channel; None if it has none."""
        place = self._row(index)[0][channel]
        coding = coding_of(channel, self._request.pictures)
        return None if place is None else (coding, self._bytes(self._shard(self._folder, "pixels", place), place))

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
            self._live = self._request.episode(self.seed, background=False)
        return self._live.map_of()

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Raise ValueError: what surrounds the pictures is not stored."""
        raise ValueError(f"larger_view: expected a rendered episode, got a stored one (scale {scale:g})")

    def close(self) -> None:
        """Forget what was read; what is read afterwards is read again."""
        self._groups = {}
        if self._live is not None:
            self._live.close()

    def _row(self, index: int) -> tuple[dict[str, Any], _Objects]:
        """Return the row of a frame and its objects; those written together are read together. Raises IndexError."""
        if not 0 <= index < self.frame_count:
            raise IndexError(f"frame: expected 0 to {self.frame_count - 1}, got {index}")
        number, at = divmod(index, ROWS_AT_ONCE)
        group = self._groups.get(number)
        if group is None:
            group = self._groups[number] = self._group(number)
            # Threads may read at once.
            for old in list(self._groups)[:-_KEPT_GROUPS]:
                self._groups.pop(old, None)
        return group[at]

    def _group(self, number: int) -> list[tuple[dict[str, Any], _Objects]]:
        group: list[tuple[dict[str, Any], _Objects]] = [
            (row, {}) for row in self._table(self._folder, "frames", number).to_pylist()
        ]
        for name in ("objects", "standing"):
            if f"{name}.parquet" in self.marks:
                rows = self._table(self._folder, name, number)
                begins = np.searchsorted(rows["frame"].to_numpy(), number * ROWS_AT_ONCE + np.arange(1, len(group)))
                arrays = tables.object_arrays(self._scenario.truth, rows, name)
                parts = {field: np.split(values, begins) for field, values in arrays.items()}
                for k, (_, objects) in enumerate(group):
                    objects[name] = {field: of_frames[k] for field, of_frames in parts.items()}
        return group

    def _table(self, folder: str, name: str, row_group: int) -> pa.Table:
        path = f"{folder}/{name}.parquet"
        try:
            with self._files.open(path, "rb") as file:
                return pq.ParquetFile(file).read_row_group(row_group)
        except (ArrowException, OSError, IndexError) as error:
            raise _damaged(path, "table", error) from None

    def _background(self) -> Iterator[Observation]:
        if "background.parquet" in self.background_marks:
            folder, known = self._background_folder, self._request.channels
            pictures = [channel for channel in known if channel in PICTURES]
            for row in self._table(folder, "background", 0).to_pylist():
                yield tables.observation_of(row, self._pixels(folder, "background", row, pictures))

    def _pixels(
        self, folder: str, shards: str, row: dict[str, Any], channels: Iterable[str]
    ) -> dict[str, NDArray[Any]]:
        """Return the values of those of the channels that a row has."""
        present = {channel: row[channel] for channel in channels if row[channel] is not None}
        return {
            channel: self._value(self._shard(folder, shards, place), channel, place)
            for channel, place in present.items()
        }

    def _value(self, path: str, channel: str, place: dict[str, int]) -> NDArray[Any]:
        try:
            return CODINGS[coding_of(channel, self._request.pictures)].decode(self._bytes(path, place))
        except (FileNotFoundError, RuntimeError) as error:
            # blosc2 knows no file.
            raise _damaged(path, "shard", error) from None

    def _bytes(self, path: str, place: dict[str, int]) -> bytes:
        begin = place["offset"]
        found: bytes = self._files.cat_file(path, start=begin, end=begin + place["bytes"])
        check(path, len(found) == place["bytes"], f"{place['bytes']} bytes (see frameout verify)", len(found))
        return found

    def _shard(self, folder: str, shards: str, place: dict[str, int]) -> str:
        return f"{folder}/{shard_name(shards, place['shard'])}"


def _damaged(path: str, what: str, error: Exception) -> ValueError:
    return ValueError(f"{path}: expected a whole {what} (see frameout verify), got {' '.join(str(error).split())}")
