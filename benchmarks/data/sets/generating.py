"""Generates a data set: episodes in worker processes or on a Dask cluster, each whole or not at all."""

from __future__ import annotations

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
from fsspec import AbstractFileSystem
from fsspec.implementations.local import LocalFileSystem
from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.contract.text import counted, ranges_text
from benchmarks.data.sets.card import CARD, write_card
from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.episode_writer import clear, has_background, read_marks, write_background, write_episode
from benchmarks.data.sets.jobs import check_at_rest, check_disjoint, forget_jobs, hull, job_file, jobs_of, note_job
from benchmarks.data.sets.manifest import MANIFEST, left_out_in, read_manifest, write_manifest
from benchmarks.data.sets.places import clear_unfinished, new_folder, place_of, put, put_new, reached
from benchmarks.data.sets.request import OnError, Request, first_episode, of_seed, part_names, request_of
from benchmarks.run.experiment import Progress
from benchmarks.run.own_modules import load_modules
from benchmarks.run.packages import check_packages
from benchmarks.run.result_folder import PROBE, alone_in
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


def generate(
    request: Request,
    out: str,
    workers: Workers,
    progress: Progress,
    on_error: OnError = "stop",
    seeds: range | None = None,
) -> DataSet:
    """Make the episodes of a request that do not exist yet; return the data set.

    Several runs may make disjoint seeds of one set in one folder at the same time; ``merge`` then makes it whole.

    Args:
        on_error: ``stop`` at an episode that cannot be built, or ``skip`` it: ``DataSet.left_out`` then has it.
        seeds: of the episodes to make now; None = those of the request.

    Raises:
        ValueError: if ``out`` holds something else, cannot be reached, or is written by another process; for an
            episode that cannot be built, with its seed: what was made is kept; for a cluster that does not answer.
        ChildProcessError: if a worker died; what was made is kept.
    """
    files, root = place_of(out)
    is_local = isinstance(files, LocalFileSystem)
    # Workers may be in other folders.
    out = root if is_local else out
    whole = range(*request.seeds) if seeds is None else seeds
    with reached(out, "out"), _connected(workers) as unordered:
        begin(request, out, whole)
        have = {seed for seed, _ in read_marks(files, root, whole)}
        missing = [seed for seed in whole if seed not in have]
        jobs = jobs_of(files, root)
        if missing or jobs or not all(files.exists(f"{root}/{name}") for name in (MANIFEST, CARD)):
            check_at_rest(files, root, whole, jobs)
            note_job(files, root, whole)
            # On a store nothing is held: what two processes write there is the same.
            with alone_in(Path(job_file(root, whole)), root) if is_local else nullcontext():
                before, left_out = len(whole) - len(missing), dict[int, str]()
                progress(before, len(whole))
                make = partial(make_episode, request, out, workers.modules, on_error=on_error)
                for done, (seed, why_not) in enumerate(unordered(make, missing), start=before + 1):
                    if why_not:
                        left_out[seed] = why_not
                    progress(done, len(whole))
                clear(files, root, whole)
                if left_out:
                    note_job(files, root, whole, left_out)
                if whole == asked_of(files, root):
                    finish(out)
        progress(len(whole), len(whole))
    return DataSet(out)


def asked_of(files: AbstractFileSystem, root: str) -> range:
    """Return the seeds that a set and the jobs on it are of."""
    found = request_of(files.cat_file(f"{root}/{REQUEST}"), REQUEST)
    return hull([range(*found.seeds), *jobs_of(files, root)])


def finish(out: str) -> DataSet:
    """Write the list and the card of a set whose episodes are all there or left out.

    Raises:
        ValueError: if episodes are missing, or none could be built.
    """
    files, root = place_of(out)
    jobs, asked = jobs_of(files, root), asked_of(files, root)
    left_out = left_out_in(read_manifest(files, root, ["seed", "left_out"]))
    left_out |= {seed: why for each in jobs.values() for seed, why in each.items()}
    if not any(read_marks(files, root, asked)):
        first = next(iter(left_out.values()), "")
        check("seeds", not left_out, "some whose episodes can be built", f"none; the first one: {first}")
    found = request_of(files.cat_file(f"{root}/{REQUEST}"), REQUEST)
    request = replace(found, seeds=(asked.start, asked.stop))
    gone = write_manifest(files, root, request, left_out)
    wanted = f"all episodes of {asked.start}:{asked.stop}, in a place that all jobs and workers reach"
    check("out", not gone, wanted, f"{out!r} without {counted(len(gone), 'episode')}: seeds {ranges_text(gone)}")
    put(files, f"{root}/{REQUEST}", request.as_json().encode())
    clear(files, root, asked, backgrounds=True)
    # A card of before the set grew would stay if this run were killed before it writes its own.
    if files.exists(f"{root}/{CARD}"):
        files.rm_file(f"{root}/{CARD}")
    forget_jobs(files, root, jobs)
    if isinstance(files, LocalFileSystem):
        clear_unfinished(root)
    write_card(DataSet(out))
    return DataSet(out)


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


def begin(request: Request, out: str, seeds: range) -> None:
    """Make the folder of a data set, or check that it is one of the same request, to which these seeds can be added.

    Raises:
        ValueError: if it is something else, or cannot be written.
    """
    files, root = place_of(out)
    path = f"{root}/{REQUEST}"
    if not files.exists(path):
        new_folder(out)
        names = [each.rpartition("/")[2] for each in files.ls(root, detail=False)] if files.exists(root) else []
        # Another job may be at this very place, or past it.
        foreign = [name for name in names if not name.startswith((REQUEST, f".{REQUEST}.", PROBE))]
        fine = not foreign or files.exists(path)
        check("out", fine, "a new or empty folder, or a data set", f"{out!r} with other files")
        put_new(files, path, request.as_json().encode())
    content = files.cat_file(path)
    check("out", not part_names(content), "a folder for a set of one part", f"{out!r} with a set of several")
    found = request_of(content, f"{out}/{REQUEST}")
    check_same(request, found, out)
    others = [range(*found.seeds), *jobs_of(files, root)]
    check_disjoint(seeds, others)


def check_same(request: Request, found: Request, out: str) -> None:
    """Raise ValueError unless two requests differ in their seeds alone."""
    for name in (field.name for field in fields(request) if field.name != "seeds"):
        wanted, kept = getattr(request, name), getattr(found, name)
        why = "; made by another edition, whose frames may differ" if name == "scene" else ""
        check("out", kept == wanted, f"a data set with {name} {wanted!r}", f"{out!r} with {kept!r}{why}")


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
        bytes: of the whole data set. seconds: CPU time of one worker, for the whole data set.
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
    began = time.process_time()
    live = first_episode(request, on_error, background=request.background)
    episode_s = time.process_time() - began
    root = f"memory://forecast-{id(live)}"
    files, path = place_of(root)
    try:
        began = time.process_time()
        background = write_background(files, path, request, request.seeds[0], live) if request.background else None
        background_s = time.process_time() - began
        first = FramesAlone(live, frames)
        began = time.process_time()
        write_episode(files, path, request, request.seeds[0], cast(Episode, first))
        frame_s = (time.process_time() - began) / first.frame_count
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
        frame_total * frame_s + len(range(*request.seeds)) * episode_s + days * background_s,
    )
