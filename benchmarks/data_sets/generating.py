"""Generates a data set: episodes in worker processes or on a cluster, each whole or not at all."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, cast

import cv2
import numba
from fsspec import AbstractFileSystem

from benchmarks.data_sets.backends import working
from benchmarks.data_sets.card import write_card
from benchmarks.data_sets.damage import damage_told
from benchmarks.data_sets.data_set import MANIFEST, REQUEST, DataSet, is_whole
from benchmarks.data_sets.episode_writer import MARK, clear, episode_folder, read_mark, write_background, write_episode
from benchmarks.data_sets.places import lasting, place_of, put
from benchmarks.data_sets.request import Request, request_of
from benchmarks.run.own_modules import load_modules
from scenarios.scenario import Episode
from sim.checks import check

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Workers:
    """Who makes the episodes.

    Attributes:
        count: processes; 0 = this process. With a cluster: how many episodes are under way at once.
        backend: ``loky`` for processes of this machine, ``dask`` or ``ray`` for a cluster.
        address: of the cluster; None = a new one on this machine.
        modules: users' own modules to import first.
    """

    count: int
    backend: str = "loky"
    address: str | None = None
    modules: tuple[str, ...] = ()


def generate(request: Request, out: str, workers: Workers, progress: Progress) -> DataSet:
    """Make the episodes of a request that do not exist yet; return the data set.

    Raises:
        ValueError: if ``out`` holds something else, or cannot be reached.
        ChildProcessError: if a worker died; what was made is kept.
    """
    here = workers.backend == "loky"
    check("workers", here or workers.count >= 1, f"at least 1 on a cluster of {workers.backend}", workers.count)
    out = lasting(out)
    files, root = place_of(out)
    begin(files, root, request, out)
    missing = [seed for seed in range(*request.seeds) if not is_whole(files, root, seed)]
    whole = range(*request.seeds)
    progress(len(whole) - len(missing), len(whole))
    for done, _ in enumerate(_made(request, out, missing, workers), start=len(whole) - len(missing) + 1):
        progress(done, len(whole))
    clear(files, root)
    data = DataSet(out)
    gone = len(whole) - len(data.seeds)
    check("out", gone == 0, "a place that all workers reach", f"{out!r}, where {gone} episodes are missing")
    with damage_told(root, "out"):
        _write_manifest(data)
        write_card(data)
    return data


def begin(files: AbstractFileSystem, root: str, request: Request, out: str) -> None:
    """Make the folder of a data set, or check that it is one of the same request. Raises ValueError."""
    path = f"{root}/{REQUEST}"
    if files.exists(path):
        kept_request = request_of(files.cat_file(path), f"{out}/{REQUEST}")
        grows = kept_request.seeds[0] == request.seeds[0] and kept_request.seeds[1] < request.seeds[1]
        found = replace(kept_request, seeds=request.seeds) if grows else kept_request
        for name in (field.name for field in fields(request)):
            wanted, kept = getattr(request, name), getattr(found, name)
            why = "; made by another edition, whose frames may differ" if name == "scene" else ""
            check("out", kept == wanted, f"a data set with {name} {wanted!r}", f"{out!r} with {kept!r}{why}")
        if grows:
            put(files, path, found.as_json().encode())
        return
    try:
        foreign = files.exists(root) and bool(files.ls(root))
        check("out", not foreign, "a new or empty folder, or a data set", f"{out!r} with other files")
        files.makedirs(root, exist_ok=True)
        put(files, path, request.as_json().encode())
    except (NotADirectoryError, FileExistsError, PermissionError, FileNotFoundError) as error:
        raise ValueError(f"out: expected a folder that can be written, got {out!r} ({error})") from None


def make_episode(request: Request, out: str, modules: tuple[str, ...], seed: int) -> int:
    """Make one episode in this process; return its seed."""
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    load_modules(modules)
    files, root = place_of(out)
    live = request.episode(seed)
    try:
        write_episode(files, root, request, seed, live)
    finally:
        live.close()
    return seed


@dataclass(frozen=True)
class Forecast:
    """What a data set will take.

    Attributes:
        frames: number. bytes_a_frame: by channel, and of ``tables``. seconds_a_frame: of one worker.
        background_bytes, background_s: of all pictures that trackers learn from.
    """

    frames: int
    bytes_a_frame: dict[str, float]
    seconds_a_frame: float
    background_bytes: float
    background_s: float

    @property
    def bytes(self) -> float:
        """Of the whole data set."""
        return self.frames * sum(self.bytes_a_frame.values()) + self.background_bytes

    @property
    def seconds(self) -> float:
        """Of one worker, for the whole data set."""
        return self.frames * self.seconds_a_frame + self.background_s


class FramesAlone:
    """An episode for timing: its first frames, without the pictures that trackers learn from."""

    def __init__(self, episode: Episode, frames: int) -> None:
        self._episode = episode
        self.start = replace(episode.start, background=())
        self.frame_count = min(frames, episode.frame_count)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._episode, name)


def forecast(request: Request, frames: int = 30) -> Forecast:
    """Measure the first frames of the first episode, which are written to memory alone."""
    live = request.episode(request.seeds[0])
    root = f"memory://forecast-{id(live)}"
    files, path = place_of(root)
    try:
        began = time.perf_counter()
        with ExitStack() as stack:
            marks = write_background(stack, files, f"{path}/background", request, live.start.background)
        background_s = time.perf_counter() - began
        first = FramesAlone(live, frames)
        began = time.perf_counter()
        write_episode(files, path, request, request.seeds[0], cast(Episode, first))
        seconds = (time.perf_counter() - began) / first.frame_count
        files.pipe_file(f"{path}/{REQUEST}", request.as_json().encode())
        each = {name: size / first.frame_count for name, size in DataSet(root).stored_bytes().items()}
    finally:
        live.close()
        if files.exists(path):
            files.rm(path, recursive=True)
    episodes = len(range(*request.seeds))
    background = sum(mark.bytes for mark in marks.values())
    return Forecast(live.frame_count * episodes, each, seconds, background * episodes, background_s * episodes)


def _made(request: Request, out: str, seeds: list[int], workers: Workers) -> Iterator[int]:
    if workers.count == 0:
        yield from (make_episode(request, out, workers.modules, seed) for seed in seeds)
        return
    make = partial(make_episode, request, out, workers.modules)
    with working(workers.backend, workers.address, workers.count) as unordered:
        yield from unordered(make, seeds)


def _write_manifest(data: DataSet) -> None:
    """Write the list of all files with their checksums."""
    content = {f"{seed:06d}": files_of(data, seed) for seed in data.seeds}
    put(data.files, f"{data.root}/{MANIFEST}", (json.dumps(content, indent=1) + "\n").encode())


def files_of(data: DataSet, seed: int) -> dict[str, dict[str, Any]]:
    """Return size and SHA-256 of an episode's files: those that its mark says, and of the mark itself."""
    folder = episode_folder(data.root, seed)
    content = data.files.cat_file(f"{folder}/{MARK}")
    own = {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    return read_mark(data.files, folder)["files"] | {MARK: own}
