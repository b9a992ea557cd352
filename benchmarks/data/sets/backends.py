"""Where the work is done: processes of this machine, or a cluster of Dask or Ray."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import Any

from joblib.externals.loky.process_executor import BrokenProcessPool

from benchmarks.run.packages import check_packages
from benchmarks.run.workers import in_processes
from sim.checks import check

BACKENDS = ("loky", "dask", "ray")
_LOST = "a worker ended (killed, or out of memory); what was made is kept, the same command continues"

PATIENCE_S = 10.0
"""How long a scheduler may take to answer."""
Unordered = Callable[[Callable[[int], Any], Sequence[int]], Iterator[Any]]
"""Calls a function on each of several numbers, and yields the results as they come."""


@contextmanager
def working(backend: str, address: str | None, workers: int) -> Iterator[Unordered]:
    """Connect to the worker processes while the context lasts; yield the function that gives them work.

    Args:
        workers: processes; 0 = this process.
        address: of a cluster's scheduler or head; None starts one of ``workers`` processes on this machine.

    Raises:
        ValueError: for an unknown backend, a missing package, or an address that does not answer.
        ChildProcessError: from the work, if a worker ended.
    """
    check("backend", backend in BACKENDS, f"one of {', '.join(BACKENDS)}", repr(backend))
    check("address", address is None or backend != "loky", "none for processes of this machine", repr(address))
    check_packages({"loky": (), "dask": ("distributed",), "ray": ("ray",)}[backend], backend)
    if workers == 0:
        yield map
        return
    with {"loky": _loky, "dask": _dask, "ray": _ray}[backend](address, workers) as unordered:
        yield unordered


@contextmanager
def _loky(address: str | None, workers: int) -> Iterator[Unordered]:
    def unordered(function: Callable[[int], Any], numbers: Sequence[int]) -> Iterator[Any]:
        try:
            yield from in_processes(function, numbers, workers)
        except BrokenProcessPool:
            raise ChildProcessError(_LOST) from None

    yield unordered


@contextmanager
def _dask(address: str | None, workers: int) -> Iterator[Unordered]:
    from distributed import Client, KilledWorker, LocalCluster, as_completed

    def unordered(function: Callable[[int], Any], numbers: Sequence[int]) -> Iterator[Any]:
        def begun(count: int) -> list[Any]:
            # The same numbers may have to be made again: their results are not known from before.
            return [client.submit(function, number, pure=False) for number in islice(coming, count)]

        coming = iter(numbers)
        running = as_completed(begun(2 * workers))
        try:
            for future in running:
                yield future.result()
                running.update(begun(1))
        except KilledWorker:
            raise ChildProcessError(_LOST) from None

    if address is None:
        cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
        with cluster, Client(cluster) as client:
            yield unordered
        return
    try:
        client = Client(address, timeout=PATIENCE_S)
    except OSError as error:
        raise ValueError(f"address: expected a Dask scheduler that answers, got {address!r} ({error})") from None
    with client:
        yield unordered


@contextmanager
def _ray(address: str | None, workers: int) -> Iterator[Unordered]:
    import ray
    from ray.util.multiprocessing import Pool

    def unordered(function: Callable[[int], Any], numbers: Sequence[int]) -> Iterator[Any]:
        with Pool(processes=workers) as pool:
            try:
                yield from pool.imap_unordered(function, numbers)
            except ray.exceptions.RayActorError:
                raise ChildProcessError(_LOST) from None

    try:
        ray.init(address=address, num_cpus=None if address else workers, log_to_driver=False, include_dashboard=False)
    except ConnectionError as error:
        raise ValueError(f"address: expected a Ray cluster that answers, got {address!r} ({error})") from None
    try:
        yield unordered
    finally:
        ray.shutdown()
