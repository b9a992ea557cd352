"""Reads the files of tracking programs, told apart by their endings and heads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.contract.printable import printable
from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks.binary_files import read_h5, read_parquet, refuse_pickled
from benchmarks.data.tracks.text_files import read_table, read_text
from benchmarks.data.tracks.trex_files import has_trex_columns, read_trex, recording_of
from sim.checks import check

_TEXT = (".csv", ".txt", ".tsv")
_BINARY = {".h5": read_h5, ".hdf5": read_h5, ".parquet": read_parquet}
_PICKLED = (".npy", ".pickle", ".pkl")
ENDINGS = (*_TEXT, *(f"{ending}.gz" for ending in _TEXT), *_BINARY, ".npz")
"""Of files that can be read."""


def read_tracks(paths: Sequence[Path]) -> list[TrackTable]:
    """Return the recordings in files of TRex (NPZ, CSV), idtracker.ai (CSV, HDF5, Parquet), idTracker and Tracktor.

    TRex writes a file for each animal: those of one video become one recording. Every other file is a recording. Those
    of one name, such as idtracker.ai's ``trajectories.csv``, are also called by the folders that tell them apart.

    Raises:
        ValueError: for a file that is missing, pickled, unknown or broken.
    """
    tables, unusable = read_each(paths)
    if unusable:
        raise ValueError(unusable[0])
    return tables


def read_each(paths: Sequence[Path]) -> tuple[list[TrackTable], list[str]]:
    """Return the recordings of ``read_tracks`` that can be read, and what is wrong with the other files, a line each.

    Raises:
        ValueError: for a file that is missing, or whose ending is unknown or that of pickled objects.
    """
    by_video: dict[Path, list[Path]] = {}
    read: list[tuple[Path, Callable[[], TrackTable]]] = []
    unusable = []
    for path in paths:
        check("real", path.is_file(), "files that exist", repr(str(path)))
        ending = path.suffixes[-2] if path.suffix == ".gz" and len(path.suffixes) > 1 else path.suffix
        if ending in _PICKLED:
            refuse_pickled(path)
        check("real", ending in (*_TEXT, *_BINARY, ".npz"), f"files ending in {', '.join(ENDINGS)}", repr(path.name))
        try:
            of_trex = ending == ".npz" or (ending in _TEXT and has_trex_columns(list(read_table(path))))
        except ValueError as error:
            unusable.append(str(error))
            continue
        if of_trex:
            by_video.setdefault(path.with_name(recording_of(path)), []).append(path)
        else:
            read.append((path, partial(_BINARY.get(ending, read_text), path)))
    read += [(video, partial(read_trex, files)) for video, files in by_video.items()]
    found = []
    for path, reader in read:
        try:
            found.append((path, reader()))
        except ValueError as error:
            unusable.append(str(error))
    return _called_apart(found), unusable


def _called_apart(found: Sequence[tuple[Path, TrackTable]]) -> list[TrackTable]:
    """Return recordings, those of one name with the names of the nearest folders in which their paths differ."""
    by_name: dict[str, list[tuple[str, ...]]] = {}
    for path, table in found:
        by_name.setdefault(table.name, []).append(path.resolve().parent.parts[::-1])
    tables = []
    for path, table in found:
        alike, mine = by_name[table.name], path.resolve().parent.parts[::-1]
        count = next((n for n in range(len(mine) + 1) if len({each[:n] for each in alike}) == len(alike)), 0)
        differing = [mine[k] for k in range(count) if len({each[k : k + 1] for each in alike}) > 1]
        tables.append(replace(table, name="-".join([*map(printable, differing[::-1]), table.name])))
    return tables
