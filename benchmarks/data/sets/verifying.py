"""Damage of data sets: files against their checksums, tables against their counts, truth against its pictures; and
errors of damaged files in one line.
"""

from __future__ import annotations

import errno
import hashlib
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from pyarrow import ArrowException

from benchmarks.data.sets.data_set import MANIFEST, DataSet
from benchmarks.data.sets.episode_writer import MARK, episode_folder, read_mark
from benchmarks.data.sets.stored_episode import StoredEpisode
from benchmarks.data.sets.visible_boxes import visible_boxes
from benchmarks.run.experiment import Progress
from scenarios.truth import Truth, check_truth

_CHUNK = 2**22
_OF_WRITING = (errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EACCES, errno.EPERM)
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
        if seed in missing:
            yield Problem(seed, "is missing, or was not written to its end")
        elif seed not in data.left_out:
            with closing(StoredEpisode(data.files, episode_folder(data.root, seed), data.request)) as episode:
                found = _of_episode(data, seed, episode, every, known)
            if found:
                yield Problem(seed, found)
        progress(done, len(seeds))


def damaged(data: DataSet) -> Iterator[Problem]:
    """Yield the episodes whose files are not those that were written; nothing is decoded."""
    known = _manifest(data)
    for seed in data.seeds:
        with closing(StoredEpisode(data.files, episode_folder(data.root, seed), data.request)) as episode:
            found = _of_marks(data, seed, episode, known) or _of_files(data, seed, episode)
        if found:
            yield Problem(seed, found)


def _of_episode(
    data: DataSet, seed: int, episode: StoredEpisode, every: int, known: dict[str, Any] | None
) -> str | None:
    """Return what is wrong with an episode. An OSError is not: the store may be out of reach.

    Args:
        known: the manifest; None before the data set is whole.
    """
    try:
        return _of_marks(data, seed, episode, known) or _of_files(data, seed, episode) or _of_frames(episode, every)
    except (ValueError, KeyError, IndexError, RuntimeError, ArrowException) as error:
        return f"cannot be read: {' '.join(str(error).split())}"


def _of_marks(data: DataSet, seed: int, episode: StoredEpisode, known: dict[str, Any] | None) -> str | None:
    """Return how an episode's mark differs from the manifest."""
    if episode.seed != seed:
        return f"its mark is that of episode {episode.seed}"
    if known is not None and known.get(f"{seed:06d}") != files_of(data, seed):
        return f"it is not the one that {MANIFEST} lists"
    return None


def _manifest(data: DataSet) -> dict[str, Any] | None:
    """Return the list of all files; None if there is none yet, or one from before the set grew."""
    listed = data.manifest()
    seeds = (seed for seed in range(*data.request.seeds) if seed not in data.left_out)
    return listed if listed is not None and all(f"{seed:06d}" in listed for seed in seeds) else None


def discard(data: DataSet, seeds: list[int]) -> None:
    """Remove episodes, so that the command that made the data set makes them again."""
    for seed in seeds:
        folder = episode_folder(data.root, seed)
        if data.files.exists(folder):
            data.files.rm(folder, recursive=True)


def _of_files(data: DataSet, seed: int, episode: StoredEpisode) -> str | None:
    """Return what is wrong with an episode's files."""
    for name, mark in episode.marks.items():
        path = f"{episode_folder(data.root, seed)}/{name}"
        if not data.files.exists(path):
            return f"{name} is missing"
        size = data.files.size(path)
        if size != mark["bytes"]:
            return f"{name}: expected {mark['bytes']} bytes, got {size}"
        digest = hashlib.sha256()
        with data.files.open(path, "rb") as file:
            while block := file.read(_CHUNK):
                digest.update(block)
        if digest.hexdigest() != mark["sha256"]:
            return f"{name}: its contents are not those that were written"
    return None


def _of_frames(episode: StoredEpisode, every: int) -> str | None:
    """Return what is wrong with an episode's tables and frames."""
    rows = episode.rows()
    expected = list(range(episode.frame_count))
    if rows != expected:
        return f"frames.parquet: expected the frames 0 to {expected[-1]}, got {len(rows)} rows"
    for index in range(0, episode.frame_count, every):
        truth = episode.frame(index).truth
        check_truth(truth)
        found = _of_pixels(truth, episode.visible_boxes_of(index), episode.visible_boxes_of(index, "standing"))
        if found:
            return f"frame {index}: {found}"
    return None


def _of_pixels(truth: Truth, boxes: np.ndarray, standing_boxes: np.ndarray) -> str | None:
    """Return how truth differs from its instance map, if that is stored."""
    if truth.instance_map.size == 0:
        return None
    for ids, held in ((truth.instance_id, boxes), (truth.standing_id, standing_boxes)):
        if not np.array_equal(visible_boxes(truth.instance_map, ids), held, equal_nan=True):
            return "visible boxes are not those of the instance map"
    seen = np.isfinite(boxes).all(axis=1)
    gone = seen & np.isin(truth.state, ("out", "absent"))
    if gone.any():
        return f"{_first(truth, gone)} is seen, and said to be {truth.state[gone][0]}"
    lost = ~seen & (truth.state == "in") & (truth.visible_fraction >= 0.5)
    if lost.any():
        return f"{_first(truth, lost)} is said to be in the picture, and has no pixel"
    with np.errstate(invalid="ignore"):
        beyond = np.concatenate([truth.box_xyxy[:, :2] - boxes[:, :2], boxes[:, 2:] - truth.box_xyxy[:, 2:]], axis=1)
        outside = (beyond > _SLACK_PX).any(axis=1)
    if outside.any():
        return f"{_first(truth, outside)} is seen outside of its amodal box"
    return None


def _first(truth: Truth, which: Any) -> str:
    """Return the name of the first object of a mask (N,)."""
    return truth.names[int(np.flatnonzero(which)[0])]


def files_of(data: DataSet, seed: int) -> dict[str, dict[str, Any]]:
    """Return size and SHA-256 of an episode's files: those that its mark says, and of the mark itself."""
    folder = episode_folder(data.root, seed)
    content = data.files.cat_file(f"{folder}/{MARK}")
    own = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    return read_mark(data.files, folder)["files"] | {MARK: own}


@contextmanager
def damage_told(root: str, parameter: str = "directory") -> Iterator[None]:
    """Raise ValueError in place of what reading a file of a data set raises that is missing or damaged.

    Args:
        root: place of the data set, which stands in messages about its files. parameter: that named it.
    """
    try:
        yield
    except FileNotFoundError as error:
        # Arrow's names the file alone.
        place = str(error.filename or error)
        if f"{root}/" not in place:
            raise
        raise _damaged(parameter, f"no file {place}") from None
    except (ArrowException, OSError) as error:
        if f"{root}/" not in str(error) or getattr(error, "errno", None) in _OF_WRITING:
            raise
        raise _damaged(parameter, str(error)) from None
    except ValueError as error:
        # The readers begin with the file's path.
        if not str(error).startswith(f"{root}/"):
            raise
        raise _damaged(parameter, str(error)) from None
    except RuntimeError as error:
        # Of blosc2, which does not know the file.
        if "cframe" not in str(error):
            raise
        raise _damaged(parameter, f"pixels that cannot be decoded: {error}") from None


def _damaged(parameter: str, found: str) -> ValueError:
    found = " ".join(found.split())
    return ValueError(f"{parameter}: expected a whole data set (see frameout verify), got {found}")
