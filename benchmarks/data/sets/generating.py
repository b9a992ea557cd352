"""Generates a data set: episodes in worker processes or on a Dask cluster, each whole or not at all."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, cast

import cv2
import numba
from fsspec.implementations.local import LocalFileSystem
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.data.sets.card import CARD, write_card
from benchmarks.data.sets.data_set import LEFT_OUT, MANIFEST, REQUEST, DataSet
from benchmarks.data.sets.episode_writer import clear, has_background, write_background, write_episode
from benchmarks.data.sets.places import new_folder, place_of, put, reached
from benchmarks.data.sets.request import OnError, Request, first_episode, of_seed, request_of
from benchmarks.data.sets.verifying import files_of
from benchmarks.run.experiment import Progress
from benchmarks.run.own_modules import load_modules
from benchmarks.run.packages import check_packages
from benchmarks.run.result_folder import alone_in
from benchmarks.run.workers import in_processes
from scenarios.scenario import Episode
from sim.checks import check

_LOST = "a worker ended (killed, or out of memory); what was made is kept, the same command continues"
_PATIENCE_S = 10.0
"""How long a scheduler may take to answer."""
Made = tuple[int, str]
"""Seed of an episode, and why it could not be built; "" if it was."""
Unordered = Callable[[Callable[[int], Made], Iterable[int]], Iterator[Made]]
"""Calls a function on each of several seeds, and yields the results as they come."""


@dataclass(frozen=True)
class Workers:
    """Who makes the episodes.

    Attributes:
        count: processes; 0 = this process. With a cluster: half as many as the episodes that are under way at once.
        address: of the scheduler of a Dask cluster; None = processes of this machine.
        modules: users' own modules to import first.
    """

    count: int
    address: str | None = None
    modules: tuple[str, ...] = ()


def generate(request: Request, out: str, workers: Workers, progress: Progress, on_error: OnError = "stop") -> DataSet:
    """Make the episodes of a request that do not exist yet; return the data set.

    Args:
        on_error: ``stop`` at an episode that cannot be built, or ``skip`` it: ``DataSet.left_out`` then has it.

    Raises:
        ValueError: if ``out`` holds something else, cannot be reached, or is written by another process; for an
            episode that cannot be built, with its seed: what was made is kept; for a cluster that does not answer.
        ChildProcessError: if a worker died; what was made is kept.
    """
    files, root = place_of(out)
    is_local = isinstance(files, LocalFileSystem)
    # Workers may be in other folders.
    out = root if is_local else out
    whole = range(*request.seeds)
    with reached(out, "out"), _connected(workers) as unordered:
        begin(request, out)
        missing = sorted(set(whole) - set(DataSet(out).seeds))
        if missing or not all(files.exists(f"{root}/{name}") for name in (MANIFEST, CARD)):
            # On a store nothing is held: what two processes write there is the same.
            with alone_in(Path(root)) if is_local else nullcontext():
                before, left_out = len(whole) - len(missing), {}
                progress(before, len(whole))
                make = partial(make_episode, request, out, workers.modules, on_error=on_error)
                for done, (seed, why_not) in enumerate(unordered(make, missing), start=before + 1):
                    if why_not:
                        left_out[seed] = why_not
                    progress(done, len(whole))
                clear(files, root)
                _finish(DataSet(out), left_out)
        progress(len(whole), len(whole))
    return DataSet(out)


def _finish(data: DataSet, left_out: dict[int, str]) -> None:
    """Write the manifest and the card; the former lists all files with checksums, and what could not be built."""
    gone = len(range(*data.request.seeds)) - len(data.seeds) - len(left_out)
    check("out", gone == 0, "a place that all workers reach", f"{data.url!r}, where {gone} episodes are missing")
    first = next(iter(left_out.values()), "")
    check("seeds", bool(data.seeds), "some whose episodes can be built", f"none; the first one: {first}")
    content: dict[str, Any] = {f"{seed:06d}": files_of(data, seed) for seed in data.seeds}
    if left_out:
        content[LEFT_OUT] = {f"{seed:06d}": left_out[seed] for seed in sorted(left_out)}
    put(data.files, f"{data.root}/{MANIFEST}", (json.dumps(content, indent=1) + "\n").encode())
    write_card(DataSet(data.url))


@contextmanager
def _connected(workers: Workers) -> Iterator[Unordered]:
    """Yield what gives the workers something to make, while the context lasts."""
    if workers.address is None:
        try:
            yield partial(in_processes, workers=workers.count)
        except BrokenProcessPool:
            raise ChildProcessError(_LOST) from None
        return
    check("workers", workers.count >= 1, "at least 1 on a cluster", workers.count)
    check_packages(("distributed",), "dask")
    from distributed import Client, KilledWorker

    try:
        client = Client(workers.address, timeout=_PATIENCE_S)
    except OSError as error:
        got = f"{workers.address!r} ({error})"
        raise ValueError(f"address: expected a Dask scheduler that answers, got {got}") from None
    with client:
        try:
            yield partial(_on_cluster, client, 2 * workers.count)
        except KilledWorker:
            raise ChildProcessError(_LOST) from None


def _on_cluster(client: Any, under_way: int, make: Callable[[int], Made], seeds: Iterable[int]) -> Iterator[Made]:
    from distributed import as_completed

    # The same seeds may have to be made again: their results are not known from before.
    calls = (client.submit(make, seed, pure=False) for seed in seeds)
    running = as_completed(list(islice(calls, under_way)))
    for future in running:
        yield future.result()
        running.update(list(islice(calls, 1)))


def begin(request: Request, out: str) -> None:
    """Make the folder of a data set, or check that it is one of the same request.

    Raises:
        ValueError: if it is something else, or cannot be written.
    """
    files, root = place_of(out)
    path = f"{root}/{REQUEST}"
    if not files.exists(path):
        new_folder(out)
        foreign = files.exists(root) and bool(files.ls(root))
        check("out", not foreign, "a new or empty folder, or a data set", f"{out!r} with other files")
        put(files, path, request.as_json().encode())
        return
    found = request_of(files.cat_file(path), f"{out}/{REQUEST}")
    grows = found.seeds[0] == request.seeds[0] and found.seeds[1] < request.seeds[1]
    for name in (field.name for field in fields(request) if not (field.name == "seeds" and grows)):
        wanted, kept = getattr(request, name), getattr(found, name)
        why = "; made by another edition, whose frames may differ" if name == "scene" else ""
        check("out", kept == wanted, f"a data set with {name} {wanted!r}", f"{out!r} with {kept!r}{why}")
    if grows:
        # Of the smaller set; a run that is killed just before it writes its own would leave them for ever.
        for name in (MANIFEST, CARD):
            if files.exists(f"{root}/{name}"):
                files.rm_file(f"{root}/{name}")
        put(files, path, request.as_json().encode())


def make_episode(request: Request, out: str, modules: tuple[str, ...], seed: int, on_error: OnError = "stop") -> Made:
    """Make one episode in this process."""
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    load_modules(modules)
    files, root = place_of(out)
    try:
        with of_seed(seed):
            draws = request.background and not has_background(files, root, request.day_of(seed))
        live = request.episode(seed, background=draws)
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
        return seed, " ".join(f"{type(error).__name__}: {error}".split())
    return seed, ""


@dataclass(frozen=True)
class Forecast:
    """What a data set will take.

    Attributes:
        frames: number. bytes_a_frame: by channel, and of ``tables``.
        bytes: of the whole data set. seconds: of one worker, for the whole data set.
    """

    frames: int
    bytes_a_frame: dict[str, float]
    bytes: float
    seconds: float


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
    live = first_episode(request, on_error, background=request.background)
    root = f"memory://forecast-{id(live)}"
    files, path = place_of(root)
    try:
        began = time.perf_counter()
        background = write_background(files, path, request, request.seeds[0], live) if request.background else None
        background_s = time.perf_counter() - began
        first = FramesAlone(live, frames)
        began = time.perf_counter()
        write_episode(files, path, request, request.seeds[0], cast(Episode, first))
        frame_s = (time.perf_counter() - began) / first.frame_count
        files.pipe_file(f"{path}/{REQUEST}", request.as_json().encode())
        each = {name: size / first.frame_count for name, size in DataSet(root).stored_bytes().items()}
    finally:
        live.close()
        if files.exists(path):
            files.rm(path, recursive=True)
    frame_total = len(range(*request.seeds)) * live.frame_count
    days = 0 if background is None else len({request.day_of(seed) for seed in range(*request.seeds)})
    background_bytes = sum(mark["bytes"] for mark in background["files"].values()) if background else 0
    return Forecast(
        frame_total,
        each,
        frame_total * sum(each.values()) + days * background_bytes,
        frame_total * frame_s + days * background_s,
    )
