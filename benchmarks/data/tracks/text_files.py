"""Tracks as text: idTracker's, Tracktor's, and the wide and tidy CSV files of idtracker.ai; gzipped ones too.

Layouts, one line a row, after a head:

* idTracker, tab separated: ``X1 Y1 ProbId1 X2 …``, a row for each frame.
* Tracktor: a number without a name, ``frame pos_x pos_y id``, a row for each animal and frame; of one animal there is
  no ``id``.
* idtracker.ai, ``trajectories.csv``: ``time x1 y1 x2 …`` (older: ``seconds``), a row for each frame; the frame rate is
  in ``attributes.json`` beside it. ``trajectories_tidy.csv``: ``frame time individual x y probability``, a row for each
  animal and frame, with ``attributes_tidy.json``.
"""

from __future__ import annotations

import csv
import gzip
import json
import re
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks.rates import rate_in, rate_of, rate_of_rows
from benchmarks.data.tracks.table import from_columns, reason, stem_of, whole_frames
from sim.checks import check
from trackers.atomic_file import write_atomic

_WIDE = re.compile(r"(?:x|X)(\d+)$")
_TIMES = ("time", "seconds")
_KNOWN_HEADS = "columns frame, pos_x, pos_y, id, or these without id, or frame, individual, x, y, or x1, y1, x2, y2 …"
"""Of Tracktor, of idtracker.ai, and of idtracker.ai or idTracker."""
Table = Mapping[str, Sequence[str]]
"""Columns of a text file, by name."""
ATTRIBUTES = {"trajectories_tidy.csv": "attributes_tidy.json"}
"""File → its attributes; else ``attributes.json``."""


def read_text(path: Path) -> TrackTable:
    """Read one of these files, told apart by its head. Raises ValueError for any other."""
    table = read_table(path)
    heads = set(table)
    if {"frame", "pos_x", "pos_y"} <= heads:
        return _rows(path, table, "id", ("pos_x", "pos_y"), None)
    if {"frame", "individual", "x", "y"} <= heads:
        return _rows(path, table, "individual", ("x", "y"), _rate_beside(path))
    animals = [match[1] for head in table if (match := _WIDE.match(head))]
    check(path.name, bool(animals), _KNOWN_HEADS, ", ".join(table)[:80])
    return _wide(path, table, animals)


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
        raise ValueError(f"{path.name}: expected a table as text, got {reason(error)}") from None
    check(path.name, len(rows) > 0, "a head and rows", "0 lines")
    heads = [head.strip() for head in rows[0]]
    if tabs and heads[-1:] == [""]:
        heads.pop()
    check_different(path.name, heads)
    columns: list[list[str]] = [[] for _ in heads]
    for number, row in enumerate(rows[1:], start=2):
        if not row:
            continue
        cells = row[:-1] if tabs and len(row) == len(heads) + 1 and row[-1] == "" else row
        check(path.name, len(cells) == len(heads), f"{len(heads)} cells in line {number}", len(cells))
        for column, cell in zip(columns, cells, strict=True):
            column.append(cell)
    return dict(zip(heads, columns, strict=True))


def check_different(name: str, heads: Sequence[str]) -> None:
    """Raise ValueError for a head that is there twice."""
    twice = sorted({head for head in heads if head and heads.count(head) > 1})
    check(name, not twice, "different heads", f"{', '.join(twice)} twice")


def numbers(path: Path, table: Table, column: str) -> NDArray[np.float64]:
    """Return a column (R,) of numbers; empty cells are NaN. Raises ValueError for what is no number."""
    try:
        return np.array([cell.strip() or "nan" for cell in table[column]], dtype=float)
    except ValueError as error:
        raise ValueError(f"{path.name}: expected numbers in column {column}, got others: {error}") from None


def _rows(path: Path, table: Table, animal: str, places: tuple[str, str], rate_hz: float | None) -> TrackTable:
    position = np.stack([numbers(path, table, column) for column in places], axis=1)
    animals = [str(each) for each in table.get(animal, ["1"] * len(position))]
    frames = whole_frames(path.name, numbers(path, table, "frame"))
    tracks, names, first = from_columns(path.name, frames, animals, position)
    time = next((each for each in _TIMES if each in table), None)
    if rate_hz is None and time is not None:
        rate_hz = rate_of_rows(frames, numbers(path, table, time))
    return TrackTable(stem_of(path), tracks, names, rate_hz, first_frame=first)


def _wide(path: Path, table: Table, animals: list[str]) -> TrackTable:
    check_different(path.name, [head.lower() for head in table])
    lower = {head.lower(): head for head in table}
    for animal in animals:
        check(path.name, f"y{animal}" in lower, f"a column y{animal} beside x{animal}", "none")
    columns = [[numbers(path, table, lower[f"{axis}{animal}"]) for axis in "xy"] for animal in animals]
    position = np.moveaxis(np.array(columns), -1, 0)
    time = next((lower[each] for each in _TIMES if each in lower), None)
    rate_hz = _rate_beside(path) if time is not None else None
    if rate_hz is None and time is not None:
        rate_hz = rate_of(numbers(path, table, time))
    return TrackTable(stem_of(path), position, tuple(animals), rate_hz)


def _rate_beside(path: Path) -> float | None:
    """Return the frame rate of idtracker.ai's file of attributes, if there is one."""
    name = ATTRIBUTES.get(path.name.removesuffix(".gz"), "attributes.json")
    beside = path.with_name(name)
    return rate_in(name, beside.read_bytes()) if beside.is_file() else None


def write_idtracker_ai(table: TrackTable, folder: Path) -> list[Path]:
    """Write ``trajectories.csv`` and ``attributes.json`` as idtracker.ai does; return their paths.

    Frames before the first one are empty rows. Without a frame rate there is no column of times.
    """
    count = table.first_frame + len(table.position)
    columns: dict[str, NDArray[np.float64]] = {}
    if table.rate_hz is not None:
        columns["time"] = np.arange(count) / table.rate_hz
    for place in range(len(table.names)):
        for axis, letter in enumerate("xy"):
            whole = np.full(count, np.nan)
            whole[table.first_frame :] = table.position[:, place, axis]
            columns[f"{letter}{place + 1}"] = whole
    attributes = {"frames_per_second": table.rate_hz, "identities_labels": list(table.names)}
    paths = [folder / "trajectories.csv", folder / "attributes.json"]
    write_atomic(paths[0], csv_text(columns))
    write_atomic(paths[1], json.dumps(attributes, indent=1) + "\n")
    return paths


def write_idtracker(table: TrackTable, folder: Path) -> list[Path]:
    """Write ``NAME.txt`` as idTracker does; return its path.

    Frames before the first one are empty rows, and no probability is known.
    """
    path = folder / f"{table.name}.txt"
    columns: dict[str, NDArray[np.float64]] = {}
    empty = np.full((table.first_frame, 2), np.nan)
    for place in range(len(table.names)):
        whole = np.concatenate([empty, table.position[:, place]])
        columns[f"X{place + 1}"], columns[f"Y{place + 1}"] = whole.T
        columns[f"ProbId{place + 1}"] = np.full(len(whole), np.nan)
    write_atomic(path, csv_text(columns, "\t"))
    return [path]


def csv_text(columns: Mapping[str, NDArray[np.float64]], separator: str = ",") -> str:
    """Return columns of numbers as text with a head."""
    lines = (separator.join(f"{cell:.8g}" for cell in row) for row in np.array(list(columns.values())).T)
    return "\n".join([separator.join(columns), *lines, ""])
