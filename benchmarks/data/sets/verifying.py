"""Damage of data sets: files against their checksums, tables against their counts, truth against its pictures."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pyarrow import ArrowException

from benchmarks.data.sets.data_set import MANIFEST, DataSet
from benchmarks.data.sets.episode_writer import MARK, episode_folder, read_mark
from benchmarks.data.sets.tables import visible_boxes
from benchmarks.run.experiment import Progress
from scenarios.truth import Truth, check_truth

_SLACK_PX = 2.5
"""Pixels by which a visible box may exceed the amodal one. That ends at the outline, this at whole pixels: up to 0.5.
Seen through ripples, or where it dips into moving water, an object exceeded its box by up to 1.7 (all presets, 150
frames of two seeds each)."""


@dataclass(frozen=True)
class Problem:
    """Something that is wrong with an episode."""

    seed: int
    what: str

    def __str__(self) -> str:
        return f"episode {self.seed}: {self.what}"


def problems(data: DataSet, progress: Progress, every: int = 1) -> Iterator[Problem]:
    """Yield all problems of a data set, of each episode the first that is found.

    Args:
        every: of how many frames one is decoded and compared with its truth.
    """
    seeds, missing, known = range(*data.request.seeds), set(data.missing()), _manifest(data)
    for done, seed in enumerate(seeds, start=1):
        found = None
        if seed in missing:
            found = "is missing, or was not written to its end"
        elif seed not in data.left_out:
            try:
                found = _of_files(data, seed, known) or _of_frames(data, seed, every)
            except (ValueError, KeyError, IndexError, ArrowException) as error:
                # An OSError is no damage: the store may be out of reach.
                found = f"cannot be read: {' '.join(str(error).split())}"
        if found:
            yield Problem(seed, found)
        progress(done, len(seeds))


def damaged(data: DataSet) -> Iterator[Problem]:
    """Yield the episodes whose files are not those that were written; nothing is decoded."""
    known = _manifest(data)
    found = ((seed, _of_files(data, seed, known)) for seed in data.seeds)
    return (Problem(seed, what) for seed, what in found if what)


def discard(data: DataSet, seeds: list[int]) -> None:
    """Remove episodes, so that the command that made the data set makes them again."""
    for seed in seeds:
        folder = episode_folder(data.root, seed)
        if data.files.exists(folder):
            data.files.rm(folder, recursive=True)


def files_of(data: DataSet, seed: int) -> dict[str, dict[str, Any]]:
    """Return size and SHA-256 of an episode's files: those that its mark says, and of the mark itself."""
    folder = episode_folder(data.root, seed)
    content = data.files.cat_file(f"{folder}/{MARK}")
    own = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    return read_mark(data.files, folder)["files"] | {MARK: own}


def _manifest(data: DataSet) -> dict[str, Any] | None:
    """Return the list of all files; None if there is none yet, or one from before the set grew."""
    listed = data.manifest()
    seeds = (seed for seed in range(*data.request.seeds) if seed not in data.left_out)
    return listed if listed is not None and all(f"{seed:06d}" in listed for seed in seeds) else None


def _of_files(data: DataSet, seed: int, known: dict[str, Any] | None) -> str | None:
    """Return what is wrong with an episode's files.

    Args:
        known: the manifest; None before the data set is whole.
    """
    folder, files = episode_folder(data.root, seed), files_of(data, seed)
    made_as = read_mark(data.files, folder)["seed"]
    if made_as != seed:
        return f"its mark is that of episode {made_as}"
    if known is not None and known.get(f"{seed:06d}") != files:
        return f"it is not the one that {MANIFEST} lists"
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


def _of_frames(data: DataSet, seed: int, every: int) -> str | None:
    """Return what is wrong with an episode's tables and frames."""
    episode = data.episode(seed)
    for index in range(0, episode.frame_count, every):
        truth = episode.frame(index).truth
        check_truth(truth)
        if truth.frame != index:
            return f"frames.parquet: expected frame {index}, got {truth.frame}"
        found = _of_pixels(truth, episode.visible_boxes_of(index), episode.visible_boxes_of(index, "standing"))
        if found:
            return f"frame {index}: {found}"
    return None


def _of_pixels(truth: Truth, boxes: np.ndarray, standing_boxes: np.ndarray) -> str | None:
    """Return how truth differs from its instance map, if that is stored."""
    if truth.instance_map.size == 0:
        return None
    for ids, stored in ((truth.instance_id, boxes), (truth.standing_id, standing_boxes)):
        if not np.array_equal(visible_boxes(truth.instance_map, ids), stored, equal_nan=True):
            return "visible boxes are not those of the instance map"
    is_seen = np.isfinite(boxes).all(axis=1)
    with np.errstate(invalid="ignore"):
        beyond = np.concatenate([truth.box_xyxy[:, :2] - boxes[:, :2], boxes[:, 2:] - truth.box_xyxy[:, 2:]], axis=1)
        is_beyond = (beyond > _SLACK_PX).any(axis=1)
    is_said_gone = np.isin(truth.state, ("out", "absent"))
    is_said_seen = (truth.state == "in") & (truth.visible_fraction >= 0.5)
    for which, what in (
        (is_seen & is_said_gone, "is seen, and said to be out or absent"),
        (~is_seen & is_said_seen, "is said to be in the picture, and has no pixel"),
        (is_beyond, "is seen outside of its amodal box"),
    ):
        if which.any():
            return f"{truth.names[int(np.argmax(which))]} {what}"
    return None
