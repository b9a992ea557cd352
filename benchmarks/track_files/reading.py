"""Reads the files of tracking programs, told apart by their endings and heads."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.track_files.binary_files import read_h5, read_parquet, refuse_pickled
from benchmarks.track_files.table import TrackTable
from benchmarks.track_files.text_files import read_table, read_text
from benchmarks.track_files.trex_files import has_trex_columns, read_trex, recording_of
from sim.checks import check

_TEXT = (".csv", ".txt", ".tsv")
_BINARY = {".h5": read_h5, ".hdf5": read_h5, ".parquet": read_parquet}
_PICKLED = (".npy", ".pickle", ".pkl")
ENDINGS = (*_TEXT, *(f"{ending}.gz" for ending in _TEXT), *_BINARY, ".npz")
"""Of files that can be read."""


def read_tracks(paths: Sequence[Path]) -> list[TrackTable]:
    """Return the recordings in files of TRex (NPZ, CSV), idtracker.ai (CSV, HDF5, Parquet), idTracker and Tracktor.

    TRex writes a file for each animal: those of one video become one recording. Every other file is a recording.

    Raises:
        ValueError: for a file that is missing, pickled, unknown or broken.
    """
    by_video: dict[Path, list[Path]] = {}
    tables = []
    for path in paths:
        check("real", path.is_file(), "files that exist", repr(str(path)))
        ending = path.suffixes[-2] if path.suffix == ".gz" and len(path.suffixes) > 1 else path.suffix
        if ending in _PICKLED:
            refuse_pickled(path)
        elif ending == ".npz" or (ending in _TEXT and has_trex_columns(list(read_table(path)))):
            by_video.setdefault(path.with_name(recording_of(path)), []).append(path)
        elif ending in _TEXT:
            tables.append(read_text(path))
        elif ending in _BINARY:
            tables.append(_BINARY[ending](path))
        else:
            check("real", False, f"files ending in {', '.join(ENDINGS)}", repr(path.name))
    return [*tables, *(read_trex(each) for each in by_video.values())]
