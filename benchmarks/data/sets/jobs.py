"""Jobs: runs that add disjoint seeds to one set at the same time, on one disk, and know nothing of one another.

Each leaves a file ``jobs/FIRST-END.json`` while the set is not whole with what it makes. No job touches another's file,
and none writes the list or the card of a set of which it makes only a part: ``frameout merge`` does.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path

from fsspec import AbstractFileSystem
from fsspec.implementations.local import LocalFileSystem

from benchmarks.data.sets.places import clear_unfinished, put, put_new
from benchmarks.run.result_folder import alone_in
from sim.checks import check

FOLDER = "jobs"
_NAME = re.compile(r"(\d+)-(\d+)\.json")


def job_file(root: str, seeds: range) -> str:
    """Return the path of a job's file."""
    return f"{root}/{FOLDER}/{seeds.start:06d}-{seeds.stop:06d}.json"


def jobs_of(files: AbstractFileSystem, root: str) -> dict[range, dict[int, str]]:
    """Return the seeds of all jobs of a set, and why some of these could not be built."""
    found: dict[range, dict[int, str]] = {}
    files.invalidate_cache(f"{root}/{FOLDER}")
    try:
        paths = files.ls(f"{root}/{FOLDER}", detail=False)
    except FileNotFoundError:
        return {}
    for path in sorted(paths):
        if match := _NAME.fullmatch(path.rpartition("/")[2]):
            with suppress(FileNotFoundError):
                said = json.loads(files.cat_file(path) or b"{}")
                found[range(int(match[1]), int(match[2]))] = {int(seed): why for seed, why in said.items()}
    return found


def note_job(files: AbstractFileSystem, root: str, seeds: range, left_out: Mapping[int, str] | None = None) -> None:
    """Write a job's file, with the seeds that could not be built; without these only if there is none yet."""
    if isinstance(files, LocalFileSystem):
        files.makedirs(f"{root}/{FOLDER}", exist_ok=True)
    said = {str(seed): why for seed, why in sorted((left_out or {}).items())}
    # Its owner holds the file: another one in its place would be held by nobody.
    (put_new if left_out is None else put)(files, job_file(root, seeds), (json.dumps(said) + "\n").encode())


def forget_jobs(files: AbstractFileSystem, root: str, jobs: Iterable[range]) -> None:
    """Remove the files of jobs, and their folder if it is empty then."""
    for seeds in jobs:
        with suppress(FileNotFoundError):
            files.rm_file(job_file(root, seeds))
    if isinstance(files, LocalFileSystem):
        clear_unfinished(f"{root}/{FOLDER}")
        with suppress(OSError):
            files.rmdir(f"{root}/{FOLDER}")


def check_at_rest(files: AbstractFileSystem, root: str, seeds: range, jobs: Iterable[range]) -> None:
    """Raise ValueError if another job on some of the seeds runs now, as ``alone_in`` tells: the one that ends first
    would clear away what the other is writing.
    """
    for each in jobs if isinstance(files, LocalFileSystem) else ():
        if each != seeds and max(each.start, seeds.start) < min(each.stop, seeds.stop):
            # Shared, since others may be looking, too.
            with suppress(FileNotFoundError), alone_in(Path(job_file(root, each)), root, shared=True):
                pass


def hull(ranges: Iterable[range]) -> range:
    """Return the smallest range that holds all of several."""
    some = list(ranges)
    return range(min(each.start for each in some), max(each.stop for each in some))


def check_disjoint(seeds: range, others: Iterable[range]) -> None:
    """Raise ValueError unless each of ``others`` is apart from ``seeds``, holds them or lies within them."""
    for each in others:
        first, end = max(seeds.start, each.start), min(seeds.stop, each.stop)
        apart_or_within = first >= end or range(first, end) in (seeds, each)
        got = f"{seeds.start}:{seeds.stop}, of which it makes {first}:{end}"
        check("seeds", apart_or_within, f"none of those of another job, {each.start}:{each.stop}, or all", got)
