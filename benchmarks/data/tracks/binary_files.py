"""idtracker.ai's binary files: HDF5 and Parquet; a pickled one is refused, since reading it could run anything."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks.rates import rate_in, rate_of_rows, rate_told
from benchmarks.data.tracks.table import from_columns, reason, stem_of, whole_frames
from sim.checks import check

_CONVERSION = "idtrackerai_format SESSION --formats csv"


def refuse_pickled(path: Path) -> None:
    """Raise ValueError that names the conversion of a pickled file."""
    raise ValueError(
        f"{path.name}: expected a file without pickled objects, since reading those can run any program; got "
        f"{path.suffix}; idtracker.ai converts it: {_CONVERSION}"
    )


def read_h5(path: Path) -> TrackTable:
    """Read ``trajectories.h5``: the data set ``trajectories`` (T, N, 2), with the frame rate among the attributes.

    Raises:
        ValueError: without h5py, or for a file without this data set.
    """
    h5py = _library("h5py")
    try:
        with h5py.File(path) as file:
            check(path.name, "trajectories" in file, "a data set named trajectories", ", ".join(file) or "none")
            position = np.asarray(file["trajectories"], dtype=float)
            rate: Any = file.attrs.get("frames_per_second")
    except OSError as error:
        raise ValueError(f"{path.name}: expected an HDF5 file, got {reason(error)}") from None
    check(path.name, position.ndim == 3 and position.shape[2] == 2, "trajectories (T, N, 2)", position.shape)
    names = tuple(str(number + 1) for number in range(position.shape[1]))
    return TrackTable(stem_of(path), position, names, rate_told(path.name, rate))


def read_parquet(path: Path) -> TrackTable:
    """Read ``trajectories.parquet``: a row for each animal and frame, as in the tidy CSV.

    Raises:
        ValueError: without pyarrow, or for a file without these columns.
    """
    pyarrow, parquet = _library("pyarrow"), _library("pyarrow.parquet")
    try:
        table = parquet.read_table(path)
    except (OSError, pyarrow.ArrowInvalid) as error:
        raise ValueError(f"{path.name}: expected a Parquet file, got {reason(error)}") from None
    wanted = ("frame", "individual", "x", "y")
    check(path.name, set(wanted) <= set(table.column_names), ", ".join(wanted), ", ".join(table.column_names))
    frame, animal, x, y = (np.asarray(table[name].to_numpy()) for name in wanted)
    position = np.stack([x, y], axis=1).astype(float)
    animals = [str(each) for each in animal]
    frames = whole_frames(path.name, frame)
    tracks, names, first = from_columns(path.name, frames, animals, position)
    said = (table.schema.metadata or {}).get(b"idtrackerai_attributes")
    rate_hz = None if said is None else rate_in(path.name, said)
    if rate_hz is None and "time" in table.column_names:
        rate_hz = rate_of_rows(frames, np.asarray(table["time"].to_numpy(), dtype=float))
    return TrackTable(stem_of(path), tracks, names, rate_hz, first_frame=first)


def _library(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        package = name.partition(".")[0]
        raise ValueError(f"file: expected {package} to be installed (pip install {package}), got none") from None
