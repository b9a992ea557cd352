"""Damage of data sets: files against their checksums."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.episode_writer import MARK, background_folder, episode_folder, read_marks
from benchmarks.data.sets.manifest import MANIFEST, Entry, files_of
from benchmarks.data.sets.places import size_and_sha256
from benchmarks.run.experiment import Progress

MISSING = "is missing, or was not written to its end"


@dataclass(frozen=True)
class Problem:
    """Something that is wrong with an episode."""

    seed: int
    what: str

    def __str__(self) -> str:
        return f"episode {self.seed}: {self.what}"


def problems(data: DataSet, progress: Progress) -> Iterator[Problem]:
    """Yield all problems of a data set, of each episode the first that is found."""
    yield from (Problem(seed, MISSING) for seed in data.missing())
    yield from damaged(data, progress)


def damaged(data: DataSet, progress: Progress = lambda done, of: None) -> Iterator[Problem]:
    """Yield the episodes whose files are not those that were written; nothing is decoded."""
    backgrounds: dict[int, str | None] = {}
    for done, entry in enumerate(data.entries(), start=1):
        what = _damage(data, entry, backgrounds)
        if what:
            yield Problem(entry.seed, what)
        progress(done, len(data.seeds))


def _damage(data: DataSet, entry: Entry, backgrounds: dict[int, str | None]) -> str | None:
    """Return what is wrong with an episode; before the data set is whole its mark alone says what its files are.

    Args:
        backgrounds: day -> what is wrong with the pictures of it, for those that were looked at.
    """
    folder = episode_folder(data.root, entry.seed)
    try:
        mark: bytes = data.files.cat_file(f"{folder}/{MARK}")
        said = json.loads(mark)
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return MISSING
    if said["seed"] != entry.seed:
        return f"its mark is that of episode {said['seed']}"
    if entry.files[MARK] != (len(mark), hashlib.sha256(mark).digest()):
        return f"it is not the one that {MANIFEST} lists"
    what = _damage_of_files(data, folder, {name: each for name, each in entry.files.items() if name != MARK})
    return what or _damage_of_background(data, said, backgrounds)


def _damage_of_background(data: DataSet, said: dict[str, Any], known: dict[int, str | None]) -> str | None:
    """Return what is wrong with the background pictures of an episode whose mark says so."""
    shared = said.get("background")
    if shared is None:
        return None
    day = shared["day"]
    if day not in known:
        found = _damage_of_files(data, background_folder(data.root, day), files_of(shared))
        known[day] = found and f"its background {day:06d}: {found}"
    return known[day]


def _damage_of_files(data: DataSet, folder: str, files: dict[str, tuple[int, bytes]]) -> str | None:
    for name, (size, sha256) in files.items():
        try:
            found = size_and_sha256(data.files, f"{folder}/{name}")
        except (FileNotFoundError, NotADirectoryError):
            return f"{name} is missing"
        if found[0] != size:
            return f"{name}: expected {size} bytes, got {found[0]}"
        if found[1] != sha256:
            return f"{name}: its contents are not those that were written"
    return None


def discard(data: DataSet, seeds: list[int]) -> None:
    """Remove episodes and damaged backgrounds, so that the command that made the data set makes them again."""
    if seeds and data.is_listed:
        data.files.rm_file(f"{data.root}/{MANIFEST}")
    backgrounds: dict[int, str | None] = {}
    for _, mark in read_marks(data.files, data.root, seeds):
        _damage_of_background(data, json.loads(mark), backgrounds)
    for folder in (background_folder(data.root, day) for day, what in backgrounds.items() if what):
        data.files.rm(folder, recursive=True)
    for folder in (episode_folder(data.root, seed) for seed in seeds):
        if data.files.exists(folder):
            data.files.rm(folder, recursive=True)
