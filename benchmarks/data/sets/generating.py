"""Generates a data set: episodes in worker processes or on a cluster, each whole or not at all."""

from __future__ import annotations

import json
import time
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import cv2
import numba
from fsspec.implementations.local import LocalFileSystem

from benchmarks.data.sets.backends import Unordered, working
from benchmarks.data.sets.card import CARD, write_card
from benchmarks.data.sets.data_set import LEFT_OUT, MANIFEST, REQUEST, DataSet
from benchmarks.data.sets.episode_writer import clear, write_background, write_episode
from benchmarks.data.sets.places import lasting, new_folder, place_of, put, reached
from benchmarks.data.sets.request import OnError, Request, first_episode, of_seed, request_of
from benchmarks.data.sets.verifying import damage_told, files_of
from benchmarks.run.experiment import Progress
from benchmarks.run.own_modules import load_modules
from benchmarks.run.result_folder import alone_in
from scenarios.scenario import Episode
from sim.checks import check


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


@dataclass(frozen=True)
class Made:
    """What became of an episode: its seed, and why there is none ('' if there is)."""

    seed: int
    why_not: str = ""


def generate(request: Request, out: str, workers: Workers, progress: Progress, on_error: OnError = "stop") -> DataSet:
    """Make the episodes of a request that do not exist yet; return the data set.

    Args:
        on_error: ``stop`` at an episode that cannot be built, or ``skip`` it: ``DataSet.left_out`` then has it.

    Raises:
        ValueError: if ``out`` holds something else, cannot be reached, or is written by another process; for an
            episode that cannot be built, with its seed: what was made is kept.
        ChildProcessError: if a worker died; what was made is kept.
    """
    check("on_error", on_error in ("stop", "skip"), "stop or skip", repr(on_error))
    here = workers.backend == "loky"
    check("workers", here or workers.count >= 1, f"at least 1 on a cluster of {workers.backend}", workers.count)
    out = lasting(out)
    with reached(out, "out"), working(workers.backend, workers.address, workers.count) as unordered:
        begin(request, out)
        data = DataSet(out)
        whole = range(*request.seeds)
        missing = sorted(set(whole) - set(data.seeds))
        if missing or not _is_told(data):
            # On a store nothing is held: what two processes write there is the same.
            with alone_in(Path(data.root)) if isinstance(data.files, LocalFileSystem) else nullcontext():
                _fill(request, out, missing, workers, unordered, progress, on_error)
        progress(len(whole), len(whole))
    return DataSet(out)


def _is_told(data: DataSet) -> bool:
    """Return whether a data set has its manifest, which can be read, and its card."""
    try:
        return data.manifest() is not None and data.files.exists(f"{data.root}/{CARD}")
    except ValueError:
        return False


def _fill(
    request: Request,
    out: str,
    missing: list[int],
    workers: Workers,
    unordered: Unordered,
    progress: Progress,
    on_error: OnError,
) -> None:
    """Make the missing episodes, and the manifest and the card of all."""
    files, root = place_of(out)
    whole = range(*request.seeds)
    before = len(whole) - len(missing)
    progress(before, len(whole))
    left_out: dict[int, str] = {}
    make = partial(make_episode, request, out, workers.modules, on_error=on_error)
    result: Made
    for done, result in enumerate(unordered(make, missing), start=before + 1):
        if result.why_not:
            left_out[result.seed] = result.why_not
        progress(done, len(whole))
    clear(files, root)
    data = DataSet(out)
    gone = len(whole) - len(data.seeds) - len(left_out)
    check("out", gone == 0, "a place that all workers reach", f"{out!r}, where {gone} episodes are missing")
    first = next(iter(left_out.values()), "")
    check("seeds", bool(data.seeds), "some whose episodes can be built", f"none; the first one: {first}")
    with damage_told(root, "out"):
        _write_manifest(data, dict(sorted(left_out.items())))
        write_card(DataSet(out))


def begin(request: Request, out: str) -> None:
    """Make the folder of a data set, or check that it is one of the same request.

    Raises:
        ValueError: if it is something else, or cannot be written.
    """
    files, root = place_of(out)
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
            # Of the smaller set; a run that is killed just before it writes its own would leave them for ever.
            for name in (MANIFEST, CARD):
                if files.exists(f"{root}/{name}"):
                    files.rm_file(f"{root}/{name}")
            put(files, path, found.as_json().encode())
        return
    new_folder(out)
    foreign = files.exists(root) and bool(files.ls(root))
    check("out", not foreign, "a new or empty folder, or a data set", f"{out!r} with other files")
    put(files, path, request.as_json().encode())


def make_episode(request: Request, out: str, modules: tuple[str, ...], seed: int, on_error: OnError = "stop") -> Made:
    """Make one episode in this process."""
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    load_modules(modules)
    files, root = place_of(out)
    try:
        live = request.episode(seed)
        try:
            with of_seed(seed):
                write_episode(files, root, request, seed, live)
        finally:
            live.close()
    except OSError:
        # Of the disk, not of the episode.
        raise
    except Exception as error:
        if on_error == "stop":
            raise
        return Made(seed, " ".join(f"{type(error).__name__}: {error}".split()))
    return Made(seed)


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


def forecast(request: Request, frames: int = 30, on_error: OnError = "stop") -> Forecast:
    """Measure the first frames of the ``first_episode``, which are written to memory alone."""
    live = first_episode(request, on_error)
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


def _write_manifest(data: DataSet, left_out: dict[int, str]) -> None:
    """Write the list of all files with their checksums, and of the episodes that could not be built."""
    content: dict[str, Any] = {f"{seed:06d}": files_of(data, seed) for seed in data.seeds}
    if left_out:
        content[LEFT_OUT] = {f"{seed:06d}": why for seed, why in left_out.items()}
    put(data.files, f"{data.root}/{MANIFEST}", (json.dumps(content, indent=1) + "\n").encode())
