"""A data set: many episodes of one request in one folder, here or on a store that fsspec knows."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.dataset

from benchmarks.data.sets.episode_writer import episode_folder, is_whole, read_mark
from benchmarks.data.sets.places import place_of, reached
from benchmarks.data.sets.request import SPLITS, Request, request_of
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios.scenario import Frame
from sim.checks import check

_KEPT = 4
"""Episodes whose tables are kept for reading in any order."""
_SCANNED = 32
"""Episodes whose tables are read as one Arrow dataset."""
REQUEST, MANIFEST = "dataset.json", "manifest.json"
LEFT_OUT = "left_out"
"""In the manifest: the seeds whose episodes could not be built, and why."""


class DataSet:
    """A sequence of frames, in order of seed and time; a frame is read without the others.

    Attributes:
        request: what it is of.
        seeds: of the episodes that exist.
    """

    def __init__(self, url: str) -> None:
        """Open a data set by its folder or URL. Raises ValueError if there is none, or it is of another version."""
        self.url = str(url)
        self.files, self.root = place_of(self.url)
        with reached(self.url, "directory"):
            if not self.files.exists(f"{self.root}/{REQUEST}"):
                raise ValueError(f"directory: expected a data set with a file {REQUEST}, got none in {self.url}")
            self.request: Request = request_of(self.files.cat_file(f"{self.root}/{REQUEST}"), REQUEST)
            self.seeds = tuple(seed for seed in range(*self.request.seeds) if is_whole(self.files, self.root, seed))
        self._known = frozenset(self.seeds)
        self._episodes: dict[int, StoredEpisode] = {}

    @cached_property
    def left_out(self) -> dict[int, str]:
        """Seed -> why its episode could not be built (``generate --on-error skip``). Raises as ``manifest``."""
        listed = (self.manifest() or {}).get(LEFT_OUT, {})
        return {int(seed): str(why) for seed, why in listed.items() if int(seed) not in self._known}

    def manifest(self) -> dict[str, Any] | None:
        """Return the list of all files, None if there is none yet. Raises ValueError if it is damaged."""
        path = f"{self.root}/{MANIFEST}"
        if not self.files.exists(path):
            return None
        try:
            listed: dict[str, Any] = json.loads(self.files.cat_file(path))
        except ValueError as error:
            raise ValueError(f"{MANIFEST}: expected the list of a data set's files, got {error}") from None
        return listed

    def missing(self) -> list[int]:
        """Return the seeds that were asked for and are neither there nor left out."""
        return [seed for seed in range(*self.request.seeds) if seed not in self._known and seed not in self.left_out]

    def __len__(self) -> int:
        """Return the number of frames."""
        return int(self._episode_ends[-1])

    def __getitem__(self, index: int) -> Frame:
        """Return a frame of the whole set. Raises IndexError."""
        episode, frame = self.locate(index)
        return episode.frame(frame)

    def __iter__(self) -> Iterator[Frame]:
        """Yield all frames."""
        for seed in self.seeds:
            yield from self.episode(seed)

    def episode(self, seed: int) -> StoredEpisode:
        """Return an episode; the last few are kept. Raises ValueError if it does not exist."""
        check("seed", seed in self._known, f"one of the {len(self.seeds)} that exist in {self.url}", seed)
        episode = self._episodes.pop(seed, None)
        if episode is None:
            episode = StoredEpisode(self.files, self.root, episode_folder(self.root, seed), self.request)
        self._episodes[seed] = episode
        # Threads may read at once.
        for old in list(self._episodes)[:-_KEPT]:
            self._episodes.pop(old, None)
        return episode

    def locate(self, index: int) -> tuple[StoredEpisode, int]:
        """Return the episode of a frame of the whole set, and its index in that. Raises IndexError."""
        if not 0 <= index < len(self):
            raise IndexError(f"frame: expected 0 to {len(self) - 1}, got {index}")
        k = int(np.searchsorted(self._episode_ends, index, side="right")) - 1
        return self.episode(self.seeds[k]), index - int(self._episode_ends[k])

    @property
    def splits(self) -> dict[str, tuple[int, ...]]:
        """Split -> seeds of its episodes, in the order ``train``, ``val``, ``test``; see ``Request.split_of``."""
        parts: dict[str, list[int]] = {name: [] for name in SPLITS}
        for seed in self.seeds:
            parts[self.request.split_of(seed)].append(seed)
        return {name: tuple(seeds) for name, seeds in parts.items() if seeds}

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of its tables; sets of format 2 have no ``standing``."""
        return ("frames", "objects") if self.request.format == 2 else ("frames", "objects", "standing")

    def table(self, name: str) -> pa.Table:
        """Return the table ``frames``, ``objects`` or ``standing`` of all episodes; ``.to_pandas()``, or
        ``polars.from_arrow(…)``. Raises ValueError for another name.
        """
        return self.scan(name).to_table()

    def scan(self, name: str, seeds: Sequence[int] | None = None) -> pa.dataset.Dataset:
        """Return the table as an Arrow dataset, which reads chosen columns and rows only.

        Args:
            seeds: of the episodes; None = all.

        Raises:
            ValueError: for an unknown name, or one that a set of an earlier format does not have.
        """
        check("name", name in self.tables, f"one of {', '.join(self.tables)}", repr(name))
        folders = (episode_folder(self.root, seed) for seed in (self.seeds if seeds is None else seeds))
        paths = [f"{folder}/{name}.parquet" for folder in folders]
        return pa.dataset.dataset(paths, filesystem=self.files, format="parquet")

    def batches(self, name: str, columns: dict[str, Any]) -> Iterator[pa.RecordBatch]:
        """Yield the rows of a table in order, as columns of expressions; the number of episodes costs no memory."""
        for first in range(0, len(self.seeds), _SCANNED):
            # Arrow keeps the footer of every file that it has read for as long as the dataset exists.
            yield from self.scan(name, self.seeds[first : first + _SCANNED]).scanner(columns=columns).to_batches()

    def stored_bytes(self) -> dict[str, int]:
        """Return the bytes of each channel in all frames, from its places in the table of frames, and of all tables."""
        total = dict.fromkeys(self.request.channels, 0)
        columns = {name: pa.compute.field(name, "bytes") for name in total}
        for batch in self.batches("frames", columns) if columns else ():
            for name in total:
                total[name] += pa.compute.sum(batch[name]).as_py() or 0
        files = (file for mark in self._marks() for file in mark["files"].items())
        total["tables"] = sum(file["bytes"] for name, file in files if name.endswith(".parquet"))
        return total

    def samples(self, take: Callable[[Frame], Any], channels: tuple[str, ...] | None = None) -> Samples:
        """Return a map-style data set for PyTorch's ``DataLoader``: what ``take`` makes of each frame.

        Args:
            channels: that are read; None = all.
        """
        return Samples(self, take, channels)

    @cached_property
    def _episode_ends(self) -> np.ndarray:
        return np.cumsum([0, *(mark["frame_count"] for mark in self._marks())])

    def _marks(self) -> Iterator[dict[str, Any]]:
        return (read_mark(self.files, episode_folder(self.root, seed)) for seed in self.seeds)


class Samples:
    """Frames of a data set, each passed through a function."""

    def __init__(self, frames: DataSet, take: Callable[[Frame], Any], channels: tuple[str, ...] | None) -> None:
        self._frames, self._take, self._channels = frames, take, channels

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._frames)

    def __getitem__(self, index: int) -> Any:
        """Return what was made of a frame."""
        episode, frame = self._frames.locate(index)
        return self._take(episode.frame(frame, self._channels))


def stored_episode(url: str, seed: int) -> StoredEpisode:
    """Return one episode of a data set, without a look at the others. Raises ValueError if there is none."""
    files, root = place_of(url)
    try:
        request = request_of(files.cat_file(f"{root}/{REQUEST}"), REQUEST)
        return StoredEpisode(files, root, episode_folder(root, seed), request)
    except FileNotFoundError as error:
        raise ValueError(f"seed: expected a whole episode in {url}, got {seed} ({error})") from None
