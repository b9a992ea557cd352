"""A data set: many episodes of one request in one folder, here or on a store that fsspec knows."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.dataset
from fsspec import AbstractFileSystem

from benchmarks.data.sets.episode_writer import episode_folder
from benchmarks.data.sets.jobs import hull, jobs_of
from benchmarks.data.sets.manifest import (
    Entry,
    entries_of_manifest,
    entries_of_marks,
    left_out_before,
    left_out_in,
    read_manifest,
)
from benchmarks.data.sets.places import place_of, reached
from benchmarks.data.sets.request import FORMAT, SPLITS, Request, part_names, request_of
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios.scenario import Frame
from sim.checks import check

_KEPT = 4
"""Episodes whose tables are kept for reading in any order."""
_SCANNED = 32
"""Episodes whose tables are read as one Arrow dataset."""
REQUEST = "dataset.json"


class DataSet:
    """A sequence of frames, in order of seed and time; a frame is read without the others.

    Attributes:
        request: what it is of.
        seeds: of the episodes that exist. left_out: seed -> why its episode could not be built (``--on-error skip``).
        is_listed: whether the set is whole, with a list of its files; otherwise it is still being made.
    """

    def __init__(self, url: str) -> None:
        """Open a data set by its folder or URL. Raises ValueError if there is none, or it is of another version."""
        self.url = str(url)
        self.files, self.root = place_of(self.url)
        with reached(self.url, "directory"):
            self.request = _request_in(self.files, self.root, self.url)
            jobs = jobs_of(self.files, self.root)
            if jobs:
                # What they add is not listed yet.
                asked = hull([range(*self.request.seeds), *jobs])
                self.request = replace(self.request, seeds=(asked.start, asked.stop))
            columns = ["seed", "frame_count", "left_out"]
            listed = None if jobs else read_manifest(self.files, self.root, columns)
            # A list of before the set grew says nothing.
            if listed is not None and listed.num_rows != len(range(*self.request.seeds)):
                listed = None
            self.is_listed = listed is not None
            if listed is None:
                self.left_out = {seed: why for each in jobs.values() for seed, why in each.items()}
                found = entries_of_marks(self.files, self.root, range(*self.request.seeds))
                counts = [(each.seed, each.frame_count) for each in found]
                self.seeds = tuple(seed for seed, _ in counts)
                frame_counts = np.array([count for _, count in counts], np.int64)
                if self.request.format < FORMAT:
                    self.left_out = left_out_before(self.files, self.root)
            else:
                made = listed.filter(pa.compute.is_null(listed["left_out"]))
                self.left_out = left_out_in(listed)
                self.seeds = tuple(made["seed"].to_pylist())
                frame_counts = made["frame_count"].to_numpy().astype(np.int64)
        self._episode_ends = np.cumsum([0, *frame_counts])
        self._known = frozenset(self.seeds)
        self._episodes: dict[int, StoredEpisode] = {}

    def entries(self) -> Iterator[Entry]:
        """Yield what is known of the files of each episode, in order of seeds."""
        if self.is_listed:
            return entries_of_manifest(self.files, self.root)
        return entries_of_marks(self.files, self.root, self.seeds)

    def size_bytes(self) -> int:
        """Return the size of all files of its episodes and their backgrounds."""
        shared = f"{self.root}/backgrounds"
        backgrounds = self.files.du(shared) if self.files.exists(shared) else 0
        return backgrounds + sum(size for entry in self.entries() for size, _ in entry.files.values())

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

    def batches(
        self, name: str, columns: dict[str, Any], seeds: Sequence[int] | None = None
    ) -> Iterator[pa.RecordBatch]:
        """Yield the rows of a table in order, as columns of expressions; the number of episodes costs no memory.

        Args:
            seeds: of the episodes; None = all.
        """
        chosen = self.seeds if seeds is None else seeds
        for first in range(0, len(chosen), _SCANNED):
            # Arrow keeps the footer of every file that it has read for as long as the dataset exists.
            yield from self.scan(name, chosen[first : first + _SCANNED]).scanner(columns=columns).to_batches()

    def stored_bytes(self, seeds: Sequence[int] | None = None) -> dict[str, int]:
        """Return the bytes of each channel in all frames, from its places in the table of frames, and of all tables.

        Args:
            seeds: of the episodes; None = all.
        """
        total = dict.fromkeys(self.request.channels, 0)
        columns = {name: pa.compute.field(name, "bytes") for name in total}
        for batch in self.batches("frames", columns, seeds) if columns else ():
            for name in total:
                total[name] += pa.compute.sum(batch[name]).as_py() or 0
        chosen = entries_of_marks(self.files, self.root, self.seeds if seeds is None else seeds)
        files = (file for entry in chosen for file in entry.files.items())
        total["tables"] = sum(size for name, (size, _) in files if name.endswith(".parquet"))
        return total

    def samples(self, take: Callable[[Frame], Any], channels: tuple[str, ...] | None = None) -> Samples:
        """Return a map-style data set for PyTorch's ``DataLoader``: what ``take`` makes of each frame.

        Args:
            channels: that are read; None = all.
        """
        return Samples(self, take, channels)


def _request_in(files: AbstractFileSystem, root: str, url: str) -> Request:
    """Return the request of a folder. Raises ValueError if there is none, or it is a set of several parts."""
    if not files.exists(f"{root}/{REQUEST}"):
        raise ValueError(f"directory: expected a data set with a file {REQUEST}, got none in {url}")
    content = files.cat_file(f"{root}/{REQUEST}")
    parts = part_names(content)
    which = " or ".join(f"{url}/{name}" for name in parts)
    check("directory", not parts, f"one part of a set, {which}", f"the set of all of them, {url}")
    return request_of(content, REQUEST)


def data_sets(url: str) -> tuple[DataSet, ...]:
    """Open a data set, or all parts of a set of several, in order. Raises as ``DataSet``."""
    # On a store two slashes are a name between them.
    url = str(url).rstrip("/") or "/"
    files, root = place_of(url)
    with reached(url, "directory"):
        described = files.exists(f"{root}/{REQUEST}")
        names = part_names(files.cat_file(f"{root}/{REQUEST}")) if described else ()
    return tuple(DataSet(f"{url}/{name}") for name in names) if names else (DataSet(url),)


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
