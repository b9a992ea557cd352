"""TRex's tracks: one NPZ or CSV file for each animal, ``VIDEO_id0.npz`` or ``VIDEO_fish0.csv`` (older).

Arrays or columns ``frame``, ``time`` (s), ``missing`` (1 where the animal is not tracked; its place is then
interpolated or infinite) and places ``X`` and ``Y`` of several sources: ``#wcentroid`` (weighted centre of the body),
``#centroid``, ``#pcentroid`` (middle of the posture), and the head without ending. They are in cm, and heads of columns
say so: ``X#wcentroid (cm)``. Files may begin and end on any frame. From TRex's documentation, "File formats".
"""

from __future__ import annotations

import io
import re
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.printable import printable
from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks.rates import rate_of_rows
from benchmarks.data.tracks.table import check_pauses, from_columns, reason, stem_of, whole_frames
from benchmarks.data.tracks.text_files import check_different, csv_text, numbers, read_table
from sim.checks import check
from trackers.atomic_file import write_atomic

_NAME = re.compile(r"(?P<video>.+?)_(?:id|fish|individual)?(?P<animal>\d+)\.(?:npz|csv)(?:\.gz)?$")
_SOURCES = ("#wcentroid", "#centroid", "#pcentroid", "")
_UNIT = re.compile(r"\s*\((cm|px)\)$")


def recording_of(path: Path) -> str:
    """Return the name of the recording that a file of one animal belongs to."""
    match = _NAME.match(path.name)
    return stem_of(path) if match is None else printable(match["video"])


def has_trex_columns(heads: Sequence[str]) -> bool:
    """Return whether a table has TRex's columns."""
    plain = {_UNIT.sub("", head) for head in heads}
    return "frame" in plain and _source(plain) is not None


def read_trex(paths: Sequence[Path]) -> TrackTable:
    """Read the files of all animals of one recording. Raises ValueError for files that are none of TRex's."""
    frames, animals, places, rates, units, notes = [], list[str](), [], [], set(), list[str]()
    for number, path in enumerate(paths):
        columns, told = _columns(path)
        source = _source(columns)
        good = source is not None and "frame" in columns
        check(path.name, good, "frame, X and Y of TRex", ", ".join(columns) or "none")
        at, place, time_s = _animal(path, columns, f"X{source}", f"Y{source}")
        if len(at) == 0:
            notes.append(f"{path.name} has no row: its animal is left out")
            continue
        match = _NAME.match(path.name)
        frames.append(at)
        animals += [str(number) if match is None else match["animal"]] * len(at)
        places.append(place)
        # Of the heads that are used: others may be in another unit.
        units |= {told.get(f"{axis}{source}", "cm") for axis in "XY"}
        if time_s is not None:
            rates.append(rate_of_rows(at, time_s))
    check(paths[0].name, bool(frames), "rows of tracks", "none")
    check("files", len(units) == 1, "places in one unit", " and ".join(sorted(units)))
    name = recording_of(paths[0])
    tracks, names, first = from_columns(name, np.concatenate(frames), animals, np.concatenate(places))
    rate_hz = next((rate for rate in rates if rate is not None), None)
    return TrackTable(name, tracks, names, rate_hz, units.pop(), first, tuple(notes))


def write_trex(table: TrackTable, folder: Path) -> list[Path]:
    """Write ``NAME_idK.npz`` for each animal, from its first to its last tracked frame; return their paths.

    Without a frame rate there is no ``time``.
    """
    paths = []
    for number, arrays in _by_animal(table):
        path = folder / f"{table.name}_id{number}.npz"
        packed = io.BytesIO()
        np.savez(packed, **arrays)  # type: ignore[arg-type]
        write_atomic(path, packed.getvalue())
        paths.append(path)
    return paths


def write_trex_csv(table: TrackTable, folder: Path) -> list[Path]:
    """Write ``NAME_idK.csv`` with the same columns; their heads name the table's unit."""
    paths = []
    for number, arrays in _by_animal(table):
        path = folder / f"{table.name}_id{number}.csv"
        write_atomic(path, csv_text({_head(name, table.unit): column for name, column in arrays.items()}))
        paths.append(path)
    return paths


def _head(name: str, unit: str) -> str:
    return f"{name} ({unit})" if "#" in name else name


def _by_animal(table: TrackTable) -> Iterator[tuple[int, dict[str, NDArray[np.float64]]]]:
    for number in range(len(table.names)):
        tracked = np.flatnonzero(np.isfinite(table.position[:, number, 0]))
        if len(tracked) == 0:
            continue
        position = table.position[tracked[0] : tracked[-1] + 1, number]
        frame = np.arange(tracked[0], tracked[-1] + 1.0) + table.first_frame
        missing = ~np.isfinite(position[:, 0])
        x, y = np.where(missing[:, None], np.inf, position).T
        arrays = {"frame": frame, "missing": missing.astype(float), "X#wcentroid": x, "Y#wcentroid": y}
        yield number, arrays if table.rate_hz is None else arrays | {"time": frame / table.rate_hz}


def _columns(path: Path) -> tuple[Mapping[str, NDArray[np.float64]], Mapping[str, str]]:
    """Return arrays and the units that heads tell, both by name without unit."""
    if path.suffix == ".npz":
        return _arrays(path), {}
    table = read_table(path)
    heads = {head: _UNIT.sub("", head) for head in table if _wanted(head)}
    check_different(path.name, list(heads.values()))
    units = {plain: match[1] for head, plain in heads.items() if (match := _UNIT.search(head))}
    return {plain: numbers(path, table, head) for head, plain in heads.items()}, units


def _wanted(head: str) -> bool:
    plain = _UNIT.sub("", head)
    return plain in ("frame", "time", "missing") or plain.partition("#")[0] in ("X", "Y")


def _arrays(path: Path) -> Mapping[str, NDArray[np.float64]]:
    check(path.name, zipfile.is_zipfile(path), "an NPZ archive of arrays of numbers", "something else")
    try:
        # Opened here, since NumPy leaves a file open that it finds broken.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name], dtype=float) for name in arrays.files if _wanted(name)}
    except (ValueError, OSError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"{path.name}: expected arrays of numbers, got {reason(error)}") from None


def _animal(
    path: Path, columns: Mapping[str, NDArray[np.float64]], x: str, y: str
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64] | None]:
    """Return frames (T,), places (T, 2) in columns ``x`` and ``y``, and times (T,) or None of one file; T may be 0."""
    names = ["frame", x, y, *(name for name in ("missing", "time") if name in columns)]
    lengths = {name: np.shape(columns[name]) for name in names}
    alike = len(set(lengths.values())) == 1 and len(lengths["frame"]) == 1
    check(path.name, alike, "arrays of one length", ", ".join(f"{name} {shape}" for name, shape in lengths.items()))
    frame = whole_frames(path.name, columns["frame"])
    if len(frame):
        check_pauses(path.name, frame)
    place = np.stack([columns[x], columns[y]], axis=1)
    lost = ~np.isfinite(place).all(axis=1)
    if "missing" in columns:
        lost |= columns["missing"] != 0
    place[lost] = np.nan
    return frame, place, columns.get("time")


def _source(names: Any) -> str | None:
    return next((source for source in _SOURCES if f"X{source}" in names and f"Y{source}" in names), None)
