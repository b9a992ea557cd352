"""Damage of data sets: files against their checksums."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from benchmarks.data.sets.data_set import MANIFEST, DataSet
from benchmarks.data.sets.episode_writer import MARK, background_folder, episode_folder, read_mark
from benchmarks.run.experiment import Progress


@dataclass(frozen=True)
class Problem:
    """Something that is wrong with an episode."""

    seed: int
    what: str

    def __str__(self) -> str:
        return f"episode {self.seed}: {self.what}"


def problems(data: DataSet, progress: Progress) -> Iterator[Problem]:
    """Yield all problems of a data set, of each episode the first that is found."""
    yield from (Problem(seed, "is missing, or was not written to its end") for seed in data.missing())
    yield from damaged(data, progress)


def damaged(data: DataSet, progress: Progress = lambda done, of: None) -> Iterator[Problem]:
    """Yield the episodes whose files are not those that were written; nothing is decoded."""
    manifest = data.manifest()
    expected = {f"{seed:06d}" for seed in range(*data.request.seeds) if seed not in data.left_out}
    # That of before the set grew says nothing.
    known = manifest if manifest is not None and expected <= set(manifest) else None
    backgrounds: dict[int, str | None] = {}
    for done, seed in enumerate(data.seeds, start=1):
        what = _damage(data, seed, known) or _damage_of_background(data, seed, backgrounds)
        if what:
            yield Problem(seed, what)
        progress(done, len(data.seeds))


def _damage(data: DataSet, seed: int, known: dict[str, Any] | None) -> str | None:
    """Return what is wrong with an episode's files; ``known``: the manifest, None before the data set is whole."""
    folder, files = episode_folder(data.root, seed), files_of(data, seed)
    made_as = read_mark(data.files, folder)["seed"]
    if made_as != seed:
        return f"its mark is that of episode {made_as}"
    if known is not None and known.get(f"{seed:06d}") != files:
        return f"it is not the one that {MANIFEST} lists"
    return _damage_of_files(data, folder, files)


def _damage_of_background(data: DataSet, seed: int, known: dict[int, str | None]) -> str | None:
    """Return what is wrong with an episode's background pictures; ``known``: by day, what was wrong with others."""
    shared = read_mark(data.files, episode_folder(data.root, seed)).get("background")
    if shared is None:
        return None
    day = shared["day"]
    if day not in known:
        found = _damage_of_files(data, background_folder(data.root, day), shared["files"])
        known[day] = found and f"its background {day:06d}: {found}"
    return known[day]


def _damage_of_files(data: DataSet, folder: str, files: dict[str, dict[str, Any]]) -> str | None:
    for name, mark in files.items():
        path = f"{folder}/{name}"
        if not data.files.exists(path):
            return f"{name} is missing"
        size = data.files.size(path)
        if size != mark["bytes"]:
            return f"{name}: expected {mark['bytes']} bytes, got {size}"
        with data.files.open(path, "rb") as file:
            if hashlib.file_digest(file, "sha256").hexdigest() != mark["sha256"]:
                return f"{name}: its contents are not those that were written"
    return None


def discard(data: DataSet, seeds: list[int]) -> None:
    """Remove episodes and damaged backgrounds, so that the command that made the data set makes them again."""
    backgrounds: dict[int, str | None] = {}
    for seed in seeds:
        if seed in data.seeds:
            _damage_of_background(data, seed, backgrounds)
    for folder in (background_folder(data.root, day) for day, what in backgrounds.items() if what):
        data.files.rm(folder, recursive=True)
    for folder in (episode_folder(data.root, seed) for seed in seeds):
        if data.files.exists(folder):
            data.files.rm(folder, recursive=True)


def files_of(data: DataSet, seed: int) -> dict[str, dict[str, Any]]:
    """Return size and SHA-256 of an episode's files: those that its mark says, and of the mark itself."""
    folder = episode_folder(data.root, seed)
    content = data.files.cat_file(f"{folder}/{MARK}")
    own = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    return read_mark(data.files, folder)["files"] | {MARK: own}
