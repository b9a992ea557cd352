"""Makes one whole data set of what several jobs have made, in one folder or in several."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from fsspec.implementations.local import LocalFileSystem

from benchmarks.contract.text import ranges_text
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.episode_writer import episode_folder
from benchmarks.data.sets.generating import begin, check_same, finish
from benchmarks.data.sets.jobs import hull, note_job
from benchmarks.data.sets.places import place_of
from benchmarks.run.experiment import Progress
from sim.checks import check


def merge(folders: Sequence[str], out: str | None, progress: Progress) -> DataSet:
    """Make a data set whole: write the list and the card, once all jobs on it are done.

    Args:
        folders: of the set; several of one request, with different seeds, become one.
        out: its folder, new or of the same request; None = the only one of ``folders``. Several folders and ``out`` are
            of this machine; where they are on one disk, files get a second name and take no room.

    Raises:
        ValueError: for folders of different requests, or with the same episodes; if episodes are missing.
    """
    if out is None:
        check("out", len(folders) == 1, "a folder for the merged set (--out)", "none")
        return finish(folders[0])
    for each in (*folders, out):
        check("out", isinstance(place_of(each)[0], LocalFileSystem), "folders of this machine", repr(each))
    parts = sorted((DataSet(each) for each in folders), key=lambda data: data.request.seeds)
    for one, other in pairwise(parts):
        check_same(one.request, other.request, other.url)
    owners: dict[int, str] = {}
    for data in parts:
        both = [seed for seed in data.seeds if seed in owners]
        got = f"the seeds {ranges_text(both)} in {data.url} and {owners[both[0]]}" if both else ""
        check("directory", not both, "folders without a common episode", got)
        owners |= dict.fromkeys(data.seeds, data.url)
    whole = hull(range(*data.request.seeds) for data in parts)
    left_out = {seed: why for data in parts for seed, why in data.left_out.items()}
    gone = [seed for seed in whole if seed not in owners and seed not in left_out]
    check(
        "directory",
        not gone,
        f"folders with all episodes of {whole.start}:{whole.stop}",
        f"none with {ranges_text(gone)}",
    )
    root = place_of(out)[1]
    begin(replace(parts[0].request, seeds=(whole.start, whole.stop)), root, whole)
    note_job(place_of(out)[0], root, whole, left_out)
    for data in parts:
        for folder in sorted(Path(data.root, "backgrounds").glob("[0-9]*")):
            _add(folder, Path(root, "backgrounds", folder.name))
    for done, (seed, url) in enumerate(sorted(owners.items()), start=1):
        _add(Path(episode_folder(place_of(url)[1], seed)), Path(episode_folder(root, seed)))
        progress(done, len(owners))
    return finish(root)


def _add(source: Path, target: Path) -> None:
    """Add a folder, whole or not at all; one that is there already is kept."""
    if source == target or target.exists():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    beside = target.with_name(f".unfinished-{target.name}-merged")
    shutil.rmtree(beside, ignore_errors=True)
    shutil.copytree(source, beside, copy_function=_linked)
    beside.rename(target)


def _linked(source: str, target: str) -> None:
    """Give a file a second name; copy it to another disk, or where files have no two names."""
    with suppress(OSError):
        os.link(source, target)
        return
    shutil.copyfile(source, target)
