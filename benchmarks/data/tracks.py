"""Reads the files of tracking programs, told apart by their endings and heads: tracks without pictures.

* TRex: a file for each animal, ``VIDEO_id0.npz`` or ``VIDEO_fish0.csv`` (older), with arrays or columns ``frame``,
  ``time`` (s), ``missing`` (1 where the animal is not tracked; its place is then interpolated or infinite) and places
  ``X`` and ``Y`` of several sources: ``#wcentroid`` (weighted centre of the body), ``#centroid``, ``#pcentroid``
  (middle of the posture), and the head without ending. They are in cm, and heads of columns say so:
  ``X#wcentroid (cm)``. Files may begin and end on any frame. From TRex's documentation, "File formats".
* idtracker.ai, ``trajectories.csv``: ``time x1 y1 x2 …`` (older: ``seconds``), a row for each frame; the frame rate is
  in ``attributes.json`` beside it. ``trajectories_tidy.csv``: ``frame time individual x y probability``, a row for each
  animal and frame, with ``attributes_tidy.json``. ``trajectories.h5``: the data set ``trajectories`` (T, N, 2), with
  the frame rate among the attributes. ``trajectories.parquet``: as the tidy CSV.
* idTracker, tab separated: ``X1 Y1 ProbId1 X2 …``, a row for each frame.
* Tracktor: a number without a name, ``frame pos_x pos_y id``, a row for each animal and frame; of one animal there is
  no ``id``.

Text may be gzipped. A pickled file is refused, since reading it could run anything.
"""

from __future__ import annotations

import csv
import gzip
import importlib
import json
import re
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.text import printable
from benchmarks.contract.track_table import TrackTable
from sim.checks import check

_TEXT = (".csv", ".txt", ".tsv")
_BINARY = (".h5", ".hdf5", ".parquet", ".npz")
_PICKLED = (".npy", ".pickle", ".pkl")
ENDINGS = (*_TEXT, *(f"{ending}.gz" for ending in _TEXT), *_BINARY)
"""Of files that can be read."""
_CONVERSION = "idtrackerai_format SESSION --formats csv"
_NAME = re.compile(r"(?P<video>.+?)_(?:id|fish|individual)?(?P<animal>\d+)\.(?:npz|csv)(?:\.gz)?$")
_SOURCES = ("#wcentroid", "#centroid", "#pcentroid", "")
_UNIT = re.compile(r"\s*\((cm|px)\)$")
_WIDE = re.compile(r"(?:x|X)(\d+)$")
_TIMES = ("time", "seconds")
_KNOWN_HEADS = "columns frame, pos_x, pos_y, id, or these without id, or frame, individual, x, y, or x1, y1, x2, y2 …"
"""Of Tracktor, of idtracker.ai, and of idtracker.ai or idTracker."""
_TIDY = {("frame", "pos_x", "pos_y"): "id", ("frame", "x", "y", "individual"): "individual"}
"""Columns of a file with a row for each animal and frame: the frame, the place, and others → that of the animal."""
_ATTRIBUTES = {"trajectories_tidy.csv": "attributes_tidy.json"}
"""File → its attributes; else ``attributes.json``."""
Table = Mapping[str, Sequence[Any]]
"""Columns of a file, by name: text, or numbers."""


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
            raise ValueError(
                f"{path.name}: expected a file without pickled objects, since reading those can run any program; got "
                f"{path.suffix}; idtracker.ai converts it: {_CONVERSION}"
            )
        check("real", ending in (*_TEXT, *_BINARY), f"files ending in {', '.join(ENDINGS)}", repr(path.name))
        try:
            of_trex = ending == ".npz" or (ending in _TEXT and _is_of_trex(read_table(path)))
        except ValueError as error:
            unusable.append(str(error))
            continue
        if of_trex:
            by_video.setdefault(path.with_name(_recording_of(path)), []).append(path)
        else:
            read.append((path, partial(_READERS.get(ending, _read_text), path)))
    read += [(video, partial(_read_trex, files)) for video, files in by_video.items()]
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
        alike, own = by_name[table.name], path.resolve().parent.parts[::-1]
        count = next((n for n in range(len(own) + 1) if len({each[:n] for each in alike}) == len(alike)), 0)
        differing = [own[k] for k in range(count) if len({each[k : k + 1] for each in alike}) > 1]
        tables.append(replace(table, name="-".join([*map(printable, differing[::-1]), table.name])))
    return tables


def _read_text(path: Path) -> TrackTable:
    """Read a text file of idTracker, idtracker.ai or Tracktor. Raises ValueError for any other."""
    table = read_table(path)
    for wanted, animal in _TIDY.items():
        if set(wanted) <= set(table):
            return _tidy(path, table, wanted, animal, _rate_beside(path) if animal in wanted else None)
    animals = [match[1] for head in table if (match := _WIDE.match(head))]
    check(path.name, bool(animals), _KNOWN_HEADS, ", ".join(table)[:80])
    _check_different(path.name, [head.lower() for head in table])
    lower = {head.lower(): head for head in table}
    for animal in animals:
        check(path.name, f"y{animal}" in lower, f"a column y{animal} beside x{animal}", "none")
    columns = [[_numbers(path, table, lower[f"{axis}{animal}"]) for axis in "xy"] for animal in animals]
    time = next((lower[each] for each in _TIMES if each in lower), None)
    rate_hz = None
    if time is not None:
        rate_hz = _rate_beside(path) or _rate_of(_numbers(path, table, time))
    return TrackTable(_stem_of(path), np.moveaxis(np.array(columns), -1, 0), tuple(animals), rate_hz)


def _read_h5(path: Path) -> TrackTable:
    h5py = _library("h5py")
    try:
        with h5py.File(path) as file:
            check(path.name, "trajectories" in file, "a data set named trajectories", ", ".join(file) or "none")
            position = np.asarray(file["trajectories"], dtype=float)
            rate: Any = file.attrs.get("frames_per_second")
    except OSError as error:
        raise ValueError(f"{path.name}: expected an HDF5 file, got {_reason(error)}") from None
    check(path.name, position.ndim == 3 and position.shape[2] == 2, "trajectories (T, N, 2)", position.shape)
    names = tuple(str(number + 1) for number in range(position.shape[1]))
    return TrackTable(_stem_of(path), position, names, _rate_told(path.name, rate))


def _read_parquet(path: Path) -> TrackTable:
    pyarrow, parquet = _library("pyarrow"), _library("pyarrow.parquet")
    try:
        table = parquet.read_table(path)
    except (OSError, pyarrow.ArrowInvalid) as error:
        raise ValueError(f"{path.name}: expected a Parquet file, got {_reason(error)}") from None
    wanted = ("frame", "x", "y", "individual")
    check(path.name, set(wanted) <= set(table.column_names), ", ".join(wanted), ", ".join(table.column_names))
    described = (table.schema.metadata or {}).get(b"idtrackerai_attributes")
    columns = {name: table[name].to_numpy() for name in (*wanted, *_TIMES) if name in table.column_names}
    return _tidy(path, columns, wanted, "individual", None if described is None else _rate_in(path.name, described))


_READERS = {".h5": _read_h5, ".hdf5": _read_h5, ".parquet": _read_parquet}
"""Ending of a file with all animals → its reader; of others ``_read_text``."""


def _tidy(path: Path, table: Table, wanted: Sequence[str], animal: str, rate_hz: float | None) -> TrackTable:
    """Return the tracks of a row for each animal and frame; ``rate_hz`` as told, else that of the times follows."""
    frame, x, y = wanted[:3]
    position = np.stack([_numbers(path, table, x), _numbers(path, table, y)], axis=1)
    frames = _whole_frames(path.name, _numbers(path, table, frame))
    animals = [str(each) for each in table.get(animal, ["1"] * len(frames))]
    tracks, names, first = _from_rows(path.name, frames, animals, position)
    time = next((each for each in _TIMES if each in table), None)
    if rate_hz is None and time is not None:
        rate_hz = _rate_of_rows(frames, _numbers(path, table, time))
    return TrackTable(_stem_of(path), tracks, names, rate_hz, first_frame=first)


def _is_of_trex(heads: Sequence[str] | Table) -> bool:
    plain = {_UNIT.sub("", head) for head in heads}
    return "frame" in plain and _source(plain) is not None


def _source(names: Any) -> str | None:
    return next((source for source in _SOURCES if f"X{source}" in names and f"Y{source}" in names), None)


def _recording_of(path: Path) -> str:
    """Return the name of the recording that a file of one animal belongs to."""
    match = _NAME.match(path.name)
    return _stem_of(path) if match is None else printable(match["video"])


@dataclass(frozen=True)
class _Animal:
    """One of TRex's files: frames (T,), places (T, 2), times (T,) if there are any, units of places; T may be 0."""

    frames: NDArray[np.int64]
    position: NDArray[np.float64]
    time_s: NDArray[np.float64] | None
    units: frozenset[str]


def _read_trex(paths: Sequence[Path]) -> TrackTable:
    """Read the files of all animals of one recording. Raises ValueError for files that are none of TRex's."""
    read = {path: _animal(path) for path in paths}
    held = {path: each for path, each in read.items() if len(each.frames)}
    check(paths[0].name, bool(held), "rows of tracks", "none")
    units = {unit for each in held.values() for unit in each.units}
    check("files", len(units) == 1, "places in one unit", " and ".join(sorted(units)))
    animals = []
    for number, (path, each) in enumerate(read.items()):
        match = _NAME.match(path.name)
        animals += [str(number) if match is None else match["animal"]] * len(each.frames)
    name = _recording_of(paths[0])
    frames, position = (
        np.concatenate([getattr(each, field) for each in held.values()]) for field in ("frames", "position")
    )
    tracks, names, first = _from_rows(name, frames, animals, position)
    rates = (_rate_of_rows(each.frames, each.time_s) for each in held.values() if each.time_s is not None)
    notes = tuple(f"{path.name} has no row: its animal is left out" for path in paths if path not in held)
    rate_hz = next((rate for rate in rates if rate is not None), None)
    return TrackTable(name, tracks, names, rate_hz, units.pop(), first, notes)


def _animal(path: Path) -> _Animal:
    columns, told = _trex_columns(path)
    source = _source(columns)
    good = source is not None and "frame" in columns
    check(path.name, good, "frame, X and Y of TRex", ", ".join(columns) or "none")
    x, y = f"X{source}", f"Y{source}"
    lengths = {name: np.shape(columns[name]) for name in ("frame", x, y, "missing", "time") if name in columns}
    alike = len(set(lengths.values())) == 1 and len(lengths["frame"]) == 1
    check(path.name, alike, "arrays of one length", ", ".join(f"{name} {shape}" for name, shape in lengths.items()))
    frames = _whole_frames(path.name, columns["frame"])
    if len(frames):
        _check_pauses(path.name, frames)
    position = np.stack([columns[x], columns[y]], axis=1)
    missing = columns.get("missing", np.zeros(len(frames)))
    position[~np.isfinite(position).all(axis=1) | (missing != 0)] = np.nan
    # Of the heads that are used: others may be in another unit.
    units = frozenset(told.get(head, "cm") for head in (x, y))
    return _Animal(frames, position, columns.get("time"), units)


def _trex_columns(path: Path) -> tuple[Mapping[str, NDArray[np.float64]], Mapping[str, str]]:
    """Return arrays and the units that heads tell, both by name without unit."""
    if path.suffix == ".npz":
        return _arrays(path), {}
    table = read_table(path)
    heads = {head: _UNIT.sub("", head) for head in table if _is_wanted(head)}
    _check_different(path.name, list(heads.values()))
    units = {plain: match[1] for head, plain in heads.items() if (match := _UNIT.search(head))}
    return {plain: _numbers(path, table, head) for head, plain in heads.items()}, units


def _is_wanted(head: str) -> bool:
    plain = _UNIT.sub("", head)
    return plain in ("frame", "time", "missing") or plain.partition("#")[0] in ("X", "Y")


def _arrays(path: Path) -> Mapping[str, NDArray[np.float64]]:
    check(path.name, zipfile.is_zipfile(path), "an NPZ archive of arrays of numbers", "something else")
    try:
        # Opened here, since NumPy leaves a file open that it finds broken.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name], dtype=float) for name in arrays.files if _is_wanted(name)}
    except (ValueError, OSError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"{path.name}: expected arrays of numbers, got {_reason(error)}") from None


def read_table(path: Path) -> Table:
    """Return a text file's columns by name. Raises ValueError if it is no table."""
    try:
        opened = gzip.open if path.suffix == ".gz" else open
        # Spreadsheets put a byte-order mark before the first head.
        with opened(path, "rt", newline="", encoding="utf-8-sig") as file:
            lines = file.read().splitlines()
        # Only idTracker separates by tabs; its head and its rows end with a tab or do not.
        tabs = "\t" in "".join(lines[:1])
        rows = list(csv.reader(lines, delimiter="\t" if tabs else ","))
    except (OSError, EOFError, UnicodeDecodeError, zlib.error, csv.Error) as error:
        raise ValueError(f"{path.name}: expected a table as text, got {_reason(error)}") from None
    check(path.name, len(rows) > 0, "a head and rows", "0 lines")
    heads = [head.strip() for head in rows[0]]
    if tabs and heads[-1:] == [""]:
        heads.pop()
    _check_different(path.name, heads)
    columns: list[list[str]] = [[] for _ in heads]
    for number, row in enumerate(rows[1:], start=2):
        if not row:
            continue
        cells = row[:-1] if tabs and len(row) == len(heads) + 1 and row[-1] == "" else row
        check(path.name, len(cells) == len(heads), f"{len(heads)} cells in line {number}", len(cells))
        for column, cell in zip(columns, cells, strict=True):
            column.append(cell)
    return dict(zip(heads, columns, strict=True))


def _check_different(name: str, heads: Sequence[str]) -> None:
    """Raise ValueError for a head that is there twice."""
    twice = sorted({head for head in heads if head and heads.count(head) > 1})
    check(name, not twice, "different heads", f"{', '.join(twice)} twice")


def _numbers(path: Path, table: Table, column: str) -> NDArray[np.float64]:
    """Return a column (R,) of numbers; empty cells are NaN. Raises ValueError for what is no number."""
    values = table[column]
    try:
        return np.array([cell.strip() or "nan" if isinstance(cell, str) else cell for cell in values], dtype=float)
    except ValueError as error:
        raise ValueError(f"{path.name}: expected numbers in column {column}, got others: {error}") from None


def _from_rows(
    name: str, frames: NDArray[np.int64], animals: Sequence[str], position: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[str, ...], int]:
    """Return (T, N, 2) positions, names and first frame from one row for each animal and frame, in any order.

    Args:
        name: of the file. frames: (R,) of each row. animals: (R,) names. position: (R, 2).

    Raises:
        ValueError: if an animal has two rows of one frame, or if there is no row.
    """
    check(name, len(frames) > 0, "rows of tracks", "none")
    names, columns = np.unique(np.asarray(animals), return_inverse=True)
    first = int(frames.min())
    count = int(frames.max()) - first + 1
    _check_pauses(name, frames)
    pairs = np.stack([frames, columns], axis=1)
    check(name, len(np.unique(pairs, axis=0)) == len(pairs), "each animal once on a frame", "one that is there twice")
    table = np.full((count, len(names), 2), np.nan)
    table[frames - first, columns] = position
    return table, tuple(str(each) for each in names), first


def _check_pauses(name: str, frames: NDArray[np.int64]) -> None:
    """Raise ValueError if there are far more frames from the first to the last than rows (R,); no table holds those."""
    count = int(frames.max()) - int(frames.min()) + 1
    check(name, count <= 100 * len(frames) + 1000, "frames without endless pauses", f"{count} frames")


def _whole_frames(name: str, frames: NDArray[Any]) -> NDArray[np.int64]:
    """Return the numbers of frames (R,) as integers. Raises ValueError for what is no whole number >= 0."""
    whole = np.isfinite(frames) & (frames == np.round(frames)) & (frames >= 0) & (frames < 2**53)
    got = ", ".join(f"{each:g}" for each in frames[~whole][:1])
    check(name, bool(whole.all()), "whole numbers >= 0 in column frame", got)
    return frames.astype(np.int64)


def _reason(error: Exception) -> str:
    """Return the first line of an error's message, its kind if it has none."""
    return (str(error) or type(error).__name__).splitlines()[0]


def _stem_of(path: Path) -> str:
    """Return the name of a file without its endings."""
    return printable(path.name.split(".")[0])


def _rate_of(time_s: NDArray[np.float64]) -> float | None:
    """Return the frames per second of times (T,) of successive frames; None if they do not tell."""
    step_s = np.diff(time_s)
    step_s = step_s[np.isfinite(step_s) & (step_s > 0)]
    return float(1.0 / np.median(step_s)) if len(step_s) else None


def _rate_of_rows(frames: NDArray[np.int64], time_s: NDArray[np.float64]) -> float | None:
    """Return the frames per second of the rows (R,) of a file, which may leave out frames or name them several times.

    None if the times do not tell.
    """
    known = np.isfinite(time_s)
    at, first = np.unique(frames[known], return_index=True)
    if len(at) == 0:
        return None
    return _rate_of(np.interp(np.arange(at[0], at[-1] + 1), at, time_s[known][first]))


def _rate_told(name: str, rate_hz: Any) -> float | None:
    """Return the rate that a file tells; None if it tells none, or 0 as for a video that the program could not read.

    Raises:
        ValueError: for what is no number; it names the file ``name``.
    """
    if rate_hz is None:
        return None
    number = isinstance(rate_hz, (int, float, np.number)) and not isinstance(rate_hz, bool)
    check(name, number, "a number of frames_per_second", repr(rate_hz))
    return float(rate_hz) if 0 < rate_hz < np.inf else None


def _rate_in(name: str, attributes: bytes) -> float | None:
    """Return the rate in idtracker.ai's attributes, an object in JSON. Raises ValueError as ``_rate_told`` does."""
    try:
        told: Any = json.loads(attributes)
    except ValueError as error:
        raise ValueError(f"{name}: expected an object in JSON, got something else: {error}") from None
    check(name, isinstance(told, dict), "an object in JSON", f"a {type(told).__name__}")
    return _rate_told(name, told.get("frames_per_second"))


def _rate_beside(path: Path) -> float | None:
    """Return the frame rate of idtracker.ai's file of attributes, if there is one."""
    name = _ATTRIBUTES.get(path.name.removesuffix(".gz"), "attributes.json")
    beside = path.with_name(name)
    return _rate_in(name, beside.read_bytes()) if beside.is_file() else None


def _library(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        package = name.partition(".")[0]
        raise ValueError(f"file: expected {package} to be installed (pip install {package}), got none") from None
