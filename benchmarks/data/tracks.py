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
* idTracker, a ``.txt`` separated by tabs: ``X1 Y1 ProbId1 X2 …``, a row for each frame.
* Tracktor: a number without a name, ``frame pos_x pos_y id``, a row for each animal and frame; of one animal there is
  no ``id``.
* SLEAP and DeepLabCut, see ``benchmarks.data.pose_files``.
* Rows of MOT Challenge, see ``benchmarks.data.mot_text``: the middle of each box that counts; the frame rate is that of
  ``seqinfo.ini`` beside the file or its folder.

Text is separated by tabs where its head is, else by commas, and may be gzipped. A pickled file is refused, since
reading it could run anything.
"""

from __future__ import annotations

import json
import re
import warnings
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.contract.text import printable
from benchmarks.contract.track_table import TrackTable
from benchmarks.data.box_files import numbers_of, read_properties
from benchmarks.data.mot_text import FIRST, rate_told, read_mot
from benchmarks.data.pose_files import read_deeplabcut_csv, read_pose_hdf5, read_sleap_csv
from sim.checks import check

_PICKLED = (".npy", ".pickle", ".pkl")
_CONVERSION = "idtrackerai_format SESSION --formats csv"
_NAME = re.compile(r"(?P<video>.+?)_(?:id|fish|individual)?(?P<animal>\d+)\.(?:npz|csv)(?:\.gz)?$")
_SOURCES = ("#wcentroid", "#centroid", "#pcentroid", "")
_UNIT = re.compile(r"\s*\((cm|px)\)$")
_TIDY = (("pos_x", "pos_y", "id"), ("x", "y", "individual"))
"""Columns of the place and the animal, in files with a row for each animal and frame."""
_WIDE = re.compile(r"[xX](\d+)$")
_KNOWN_HEADS = "columns frame, pos_x, pos_y, id, or these without id, or frame, individual, x, y, or x1, y1, x2, y2 …"
"""Of Tracktor, of idtracker.ai, and of idtracker.ai or idTracker; other programs are known by their first heads."""


@dataclass(frozen=True)
class _File:
    """What one file holds.

    Attributes:
        path: of the file. recording: of the recording: TRex's files of one video have the same.
        name: of the recording.
        rows: ``frame``, ``animal``, ``x`` and ``y``, one for each animal and frame; of TRex there may be none.
        rate_hz: None if the file does not hold it. unit: of places.
    """

    path: Path
    recording: Path
    name: str
    rows: pd.DataFrame
    rate_hz: float | None
    unit: str


def read_tracks(paths: Sequence[Path]) -> list[TrackTable]:
    """Return the recordings in files of the programs above.

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
        ValueError: for a file that is missing or named twice, or whose ending is unknown or that of pickled objects.
    """
    twice = [path.name for path in paths if paths.count(path) > 1]
    check("real", not twice, "different files", f"{', '.join(twice[:1])} twice")
    recordings: dict[Path, list[_File]] = {}
    found: list[tuple[Path, TrackTable]] = []
    unusable = []
    for path in paths:
        check("real", path.is_file(), "files that exist", repr(str(path)))
        if path.suffix in _PICKLED:
            raise ValueError(
                f"{path.name}: expected a file without pickled objects, since reading those can run any program; got "
                f"{path.suffix}; idtracker.ai converts it: {_CONVERSION}"
            )
        check("real", _ending(path) in _READERS, f"files ending in {', '.join(_READERS)}", repr(path.name))
        try:
            file = _read(path)
            recordings.setdefault(file.recording, []).append(file)
        except ValueError as error:
            unusable.append(str(error))
    for path, files in recordings.items():
        try:
            found.append((path, _joined(files)))
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


def _joined(files: Sequence[_File]) -> TrackTable:
    """Return the recording of the files of all its animals. Raises ValueError if they are of no use together."""
    first_file, held = files[0], [file for file in files if len(file.rows)]
    name = first_file.path.name
    check(name, bool(held), "rows of tracks", "none")
    units = sorted({file.unit for file in held})
    check("files", len(units) == 1, "places in one unit", " and ".join(units))
    rows = pd.concat([file.rows for file in held])
    frames = rows["frame"].to_numpy().astype(np.int64)
    first, count = int(frames.min()), int(np.ptp(frames)) + 1
    check(name, count <= 100 * len(rows) + 1000, "frames without endless pauses", f"{count} frames")
    twice = bool(rows.duplicated(["frame", "animal"]).any())
    check(name, not twice, "each animal once on a frame", "one that is there twice")
    animals, names = pd.factorize(rows["animal"], sort=True)
    position = np.full((count, len(names), 2), np.nan)
    position[frames - first, animals] = rows[["x", "y"]]
    rate_hz = next((file.rate_hz for file in held if file.rate_hz is not None), None)
    notes = tuple(f"{file.path.name} has no row: its animal is left out" for file in files if not len(file.rows))
    return TrackTable(first_file.name, position, tuple(map(str, names)), rate_hz, units[0], first, notes)


def _read(path: Path) -> _File:
    """Read a file of any program. Raises ValueError, which names it, if it is broken or of none of them."""
    try:
        table, rate_hz = _READERS[_ending(path)](path)
    except _BROKEN as error:
        reason = (str(error) or type(error).__name__).splitlines()[0]
        if isinstance(error, ModuleNotFoundError):
            reason = f"no package {error.name} (pip install {error.name})"
        raise ValueError(f"{path.name}: expected a whole {_ending(path)} file, got {reason}") from None
    # MOT Challenge has NAME/gt/gt.txt.
    called = path.parent.parent.name if path.parts[-2:] == ("gt", "gt.txt") else path.name.split(".")[0]
    recording, name, unit = path, printable(called), "px"
    heads = {_UNIT.sub("", head): head for head in table}
    # Pandas calls the second head x1 of a text x1.1.
    twice = [head[:-2] for head in table if head.endswith(".1") and head[:-2] in table]
    check(path.name, not twice, "different heads", f"{', '.join(twice)} twice")
    source = next((each for each in _SOURCES if {"frame", f"X{each}", f"Y{each}"} <= heads.keys()), None)
    tidy = next((columns for columns in _TIDY if {"frame", *columns[:2]} <= heads.keys()), None)
    if source is not None:
        match, unit_told = _NAME.match(path.name), _UNIT.search(heads[f"X{source}"])
        name = printable(match["video"]) if match else name
        recording, unit = path.with_name(name), unit_told[1] if unit_told else "cm"
        rows = _rows(path, table, heads[f"X{source}"], heads[f"Y{source}"], match["animal"] if match else "0")
    elif tidy is not None:
        x, y, animal = tidy
        named = animal not in table or bool(table[animal].notna().all())
        check(path.name, named, f"an animal on each row, in column {animal}", "a row without one")
        rows = _rows(path, table, x, y, table[animal].astype(str) if animal in table else "1")
    else:
        table = table.rename(columns=str.lower).assign(frame=range(len(table)))
        animals = [head[1:] for head in table if _WIDE.match(head)]
        known = bool(animals) and {f"y{animal}" for animal in animals} <= set(table)
        check(path.name, known, _KNOWN_HEADS, ", ".join(heads)[:80])
        rows = pd.concat([_rows(path, table, f"x{animal}", f"y{animal}", animal) for animal in animals])
        rows["animal"] = pd.Categorical(rows["animal"], animals)
    return _File(path, recording, name, rows, rate_hz or _rate_of(rows), unit)


def _rows(path: Path, table: pd.DataFrame, x: str, y: str, animal: Any) -> pd.DataFrame:
    """Return frame, animal, x and y of a file's rows; x and y are NaN where the animal is missing."""
    heads = {"x": x, "y": y} | {each: each for each in ("frame", "missing", "time", "seconds") if each in table}
    try:
        rows = pd.DataFrame({name: table[head].astype(float) for name, head in heads.items()})
    except ValueError as error:
        raise ValueError(f"{path.name}: expected numbers in {', '.join(heads.values())}, got others: {error}") from None
    frames = rows["frame"]
    wrong = frames[~(frames.between(0, 2**53) & (frames % 1 == 0))].tolist()
    check(path.name, not wrong, "whole numbers >= 0 in column frame", ", ".join(f"{each:g}" for each in wrong[:1]))
    if "missing" in rows:
        rows.loc[rows["missing"] != 0, ["x", "y"]] = np.nan
    return rows.rename(columns={"seconds": "time"}).assign(animal=animal)


def _rate_of(rows: pd.DataFrame) -> float | None:
    """Return the frames per second of rows, which may leave out frames; None if their times do not tell."""
    if "time" not in rows:
        return None
    times = rows.loc[np.isfinite(rows["time"])].drop_duplicates("frame").sort_values("frame")
    step_s = np.diff(times["time"]) / np.diff(times["frame"])
    step_s = step_s[step_s > 0]
    return float(1.0 / np.median(step_s)) if len(step_s) else None


def _ending(path: Path) -> str:
    return path.with_suffix("").suffix if path.suffix == ".gz" else path.suffix


def _text(path: Path) -> tuple[pd.DataFrame, float | None]:
    heads = list(pd.read_csv(path, nrows=0, skipinitialspace=True).columns)
    if heads[:1] == ["scorer"]:
        return read_deeplabcut_csv(path)
    if {"track", "frame_idx"} <= set(heads):
        return read_sleap_csv(path)
    if path.suffix != ".gz":
        with path.open(encoding="utf-8-sig") as file:
            if numbers_of(next(filter(str.strip, file), "")):
                return _mot(path)
    has_tabs = len(pd.read_csv(path, sep="\t", nrows=0).columns) > 1
    with warnings.catch_warnings():
        # Of rows with more cells than heads, whose last cells would be dropped.
        warnings.simplefilter("error", pd.errors.ParserWarning)
        table = pd.read_csv(
            path,
            sep="\t" if has_tabs else ",",
            skipinitialspace=True,
            # The head of idTracker ends with a tab, its rows do not.
            index_col=False,
            dtype={"id": str, "individual": str},
        )
    name = "attributes_tidy.json" if path.name.startswith("trajectories_tidy.") else "attributes.json"
    attributes = path.with_name(name)
    of_idtracker_ai = not {"x1", "individual"}.isdisjoint(table)
    return table, _rate_told(attributes.read_bytes()) if of_idtracker_ai and attributes.is_file() else None


def _mot(path: Path) -> tuple[pd.DataFrame, float | None]:
    rows = read_mot(path)
    x, y = (0.5 * (rows.box_xyxy[:, :2] + rows.box_xyxy[:, 2:])).T
    table = pd.DataFrame({"frame": rows.frame - FIRST, "individual": rows.identity.astype(str), "x": x, "y": y})
    beside = (folder / "seqinfo.ini" for folder in path.resolve().parents[:2])
    told = read_properties(next(filter(Path.is_file, beside), path.with_name("seqinfo.ini")))
    # Truth has rows that do not count.
    counts = rows.confidence != 0
    return table[counts], _known_rate(rate_told(told))


def _npz(path: Path) -> tuple[pd.DataFrame, float | None]:
    # Opened here, since NumPy leaves a file open that it finds broken.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
        wanted = [name for name in arrays if re.match(r"(frame|missing|time|[XY](#.*)?)$", name)]
        return pd.DataFrame({name: arrays[name] for name in wanted}), None


def _h5(path: Path) -> tuple[pd.DataFrame, float | None]:
    import h5py

    with h5py.File(path) as file:
        if (found := read_pose_hdf5(path, file)) is not None:
            return found
        position = np.asarray(file["trajectories"], dtype=float)
        rate_hz = file.attrs.get("frames_per_second")
    heads = [f"{axis}{number + 1}" for number in range(position.shape[1]) for axis in "xy"]
    return pd.DataFrame(position.reshape(len(position), -1), columns=heads), _known_rate(rate_hz)


def _parquet(path: Path) -> tuple[pd.DataFrame, float | None]:
    from pyarrow import parquet

    table = parquet.read_table(path)
    attributes = (table.schema.metadata or {}).get(b"idtrackerai_attributes", b"{}")
    return table.to_pandas(), _rate_told(attributes)


def _rate_told(attributes: bytes) -> float | None:
    return _known_rate(json.loads(attributes).get("frames_per_second"))


def _known_rate(rate_hz: Any) -> float | None:
    """Return a rate; None for none, or 0 as for a video that the program could not read."""
    return float(rate_hz) if rate_hz and 0 < float(rate_hz) < np.inf else None


_READERS: dict[str, Callable[[Path], tuple[pd.DataFrame, float | None]]] = {
    **dict.fromkeys((".csv", ".txt", ".tsv"), _text),
    **dict.fromkeys((".h5", ".hdf5", ".slp"), _h5),
    ".parquet": _parquet,
    ".npz": _npz,
}
"""Ending, before ``.gz`` → what reads a table and the frame rate that stands beside it."""
_BROKEN = (
    AttributeError, EOFError, ImportError, LookupError, OSError, RuntimeError, TypeError, ValueError,
    zipfile.BadZipFile, zlib.error, pd.errors.ParserWarning,
)  # fmt: skip
"""What the readers raise for files that are broken, or of another kind than their ending says."""
