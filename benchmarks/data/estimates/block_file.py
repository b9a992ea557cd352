"""One file of estimates: all answers of one tracker in one episode, with what a judge has to know beside that.

A file exists whole or not at all. Its bytes are the same for every run of the same code, but for the columns
``cpu_s`` and ``wall_s``. Numbers are stored as float64, exactly. A tracker may answer with others, e.g. float32, by
which a judge's last digits differ, so a file also notes their types.

For metrics of one's own, ``frameout bench --keep-estimates`` leaves a row for each track that a tracker answered on
each frame; the columns and their units are those of ``SCHEMA``. The truth of the same
frames is in the tables of a data set of the same scenario, preset and seeds, and nothing has to be run::

    from benchmarks.data.sets.data_set import DataSet
    from benchmarks.data.estimates.block_file import scan

    found = scan("results/mine").to_table(columns=["tracker", "seed", "frame", "repeat", "answer", "position_px"])
    found = found.to_pandas().query("answer == 'at once'")
    true = DataSet("sets/town").table("objects").to_pandas().query("names == 'target'")
    both = found.merge(true, on=["seed", "frame"], suffixes=("", "_true"))
    away_px = np.stack(both["position_px"]) - np.stack(both["position_px_true"])
    both["error_px"] = np.hypot(away_px[:, 0], away_px[:, 1])
    print(both.groupby("tracker")["error_px"].median())
"""

from __future__ import annotations

import hashlib
import json
from bisect import bisect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any, get_args, get_type_hints
from urllib.parse import quote

import numpy as np
import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet as pq

from benchmarks.contract.rows import ESTIMATES, BlockKey, Row, block_key
from benchmarks.data import codec
from benchmarks.data.codec import field_of, plain
from benchmarks.run.time_limit import Taken
from scenarios.truth import Meaning
from sim.checks import check
from trackers.atomic_file import atomic_file
from trackers.gaps import Bridge
from trackers.types import Answer, CameraCommand, CommandName, Estimate, Track

FORMAT = 2
"""Number of the layout of a file; increment it with every change."""
_FACTS = b"frameout_estimates"
_ENDING = ".parquet"

Values = dict[str, Any]
"""Column -> value of one row; a column that is missing is null."""
Types = dict[str, list[tuple[int, str]]]
"""Column -> rows from which on its numbers are of another type, and that type; without the columns of float64."""

AT_ONCE, HINDSIGHT, EXTRAPOLATED, INTERPOLATED = "at once", "hindsight", "extrapolated", "interpolated"
_OBEYED = "obeyed_"

_WORDS = {
    **dict.fromkeys(("suite", "scenario", "preset", "renderer"), Meaning("word")),
    "controller": Meaning("word", coding="steered the camera by the answers; null: a set path"),
    "link": Meaning("word", coding="how commands reached the carrier; null in suites without links"),
    "tracker": Meaning("word"),
    "answer": Meaning(
        "word",
        coding="on the latest picture (at once), or after the last one (hindsight); or about a gap that the judge cut "
        "into a target's track (extrapolated from before it, interpolated from both sides)",
    ),
    "kind": Meaning("word", coding="class of the target; null: not said"),
}
_WHOLE = {
    "seed": Meaning("id", coding="the episode"),
    "repeat": Meaning("id", coding="run of a tracker whose random numbers no seed reaches"),
    "frame": Meaning("frames", coding="from 0 on"),
    "track": Meaning("id", coding="place in the answer; null: an answer without any track, or no bridge of the gap"),
    "gap": Meaning("id", coding="number of the judge's question, in its order; null: no gap"),
    "identity": Meaning("id", coding="of the track; null from a tracker of one target"),
}
_OF_ESTIMATE = {
    "position_px": Meaning("px", (2,), "centre, x right, y down from the top left corner; NaN: no estimate"),
    "box_xyxy": Meaning("px", (4,), "x_min, y_min, x_max, y_max"),
    "heading_rad": Meaning("rad", (), "in the picture, from +x towards +y"),
    "in_view_probability": Meaning("fraction", (), "that the centre is in the picture and not hidden"),
    "depth_m": Meaning("m", (), "along the camera's axis"),
    "covariance_px": Meaning("px^2", (2, 2), "of a Gaussian about the position; row-major"),
    "centre_line_px": Meaning("px", ("K", 2), "from head to tail; x, y, x, y …"),
    "particles_px": Meaning("px", ("K", 2), "of the posterior of the position; x, y, x, y …"),
    "weights": Meaning("fraction", ("K",), "of the particles; null: equal"),
}
_OF_TRACK = {
    "size_m": Meaning("m", (3,), "length, width, height"),
    "confidence": Meaning("fraction", (), "that the target exists and is the one of this identity"),
}
_COMMANDS = {
    f"{_OBEYED}{name}": Meaning(unit, (), "command that the carrier obeyed before this frame; null: none")
    for name, unit in zip(get_args(CommandName), ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s", "1/s"), strict=True)
}
TIMES = ("cpu_s", "wall_s")
"""The only columns that differ from run to run, see ``time_limit.Taken``."""
_TIMES = {
    name: Meaning("s", (), f"{words} time of the answer; with hindsight: of all frames together; null: not measured")
    for name, words in zip(TIMES, ("CPU", "wall"), strict=True)
}
_NUMBERS = {**_OF_ESTIMATE, **_OF_TRACK, **_COMMANDS, **_TIMES}
_HINTS = {
    **get_type_hints(Estimate),
    **get_type_hints(Track),
    **dict.fromkeys((*_COMMANDS, *_TIMES), float),
    **dict.fromkeys(_WORDS, str),
    **dict.fromkeys(_WHOLE, int),
}
_COLUMNS = [field_of(name, _HINTS[name], each) for name, each in (_WORDS | _WHOLE | _NUMBERS).items()]
SCHEMA = pa.schema([*_COLUMNS, codec.MASK])
"""Columns of a file of estimates; lists hold arrays in row-major order."""


@dataclass(frozen=True)
class Run:
    """How one run of a tracker in an episode went.

    Attributes:
        failed_at_frame: when its answers were judged, see ``Ending``. failed_in_the_end: or on a gap after that.
        reason: of the failure.
        decides_at: see ``Ending``.
        revises, bridges: whether it decided with hindsight, and whether it had a method to bridge gaps.
    """

    failed_at_frame: int | None
    failed_in_the_end: int | None
    reason: str | None
    decides_at: float
    revises: bool
    bridges: bool


@dataclass(frozen=True)
class Facts:
    """What a file holds of its whole block.

    Attributes:
        heading: columns of its rows that name it. editions: of its rows.
        many: whether answers are tracks of many targets.
        frame_count: of the episode.
        controller_failed_at: frame, None without a failure.
        runs: by repeat.
        types: of numbers that are not float64.
        format: number of the layout.
    """

    heading: Row
    editions: dict[str, str]
    many: bool
    frame_count: int
    controller_failed_at: int | None
    runs: list[Run]
    types: Types = field(default_factory=dict)
    format: int = FORMAT

    @property
    def key(self) -> BlockKey:
        """Identity of the block."""
        return block_key(self.heading)


@dataclass(frozen=True)
class Answered:
    """All that one run of a tracker answered.

    Attributes:
        answers: on each frame. revised: with hindsight; None if it does not revise.
        gaps: the rows of each of the judge's questions about gaps.
        taken: times of its updates, in order. revision: of the revision.
    """

    answers: list[Answer]
    revised: list[Sequence[Any]] | None
    gaps: list[list[Values]]
    taken: list[Taken]
    revision: Taken


@dataclass(frozen=True)
class Block:
    """A file read whole.

    Attributes:
        facts: of the block. commands: obeyed before each frame. answered: by repeat.
    """

    facts: Facts
    commands: list[CameraCommand | None]
    answered: list[Answered]


def rows_of_answer(answer: Answer) -> list[Values]:
    """Return a row for each track of an answer, copied; one without ``track`` if it has none."""
    if isinstance(answer, Estimate):
        return [{"track": 0, **_copies_of(answer)}]
    rows = []
    for place, each in enumerate(answer):
        named = {"track": place, "identity": int(each.identity), "kind": each.kind}
        rows.append({**named, **_copies_of(each.estimate), **_copies(each, _OF_TRACK)})
    return rows or [{}]


def rows_of_bridge(bridge: Bridge | None) -> list[Values]:
    """Return a row for each frame of a bridge; one without ``track`` if there is none."""
    if bridge is None:
        return [{}]
    covariances = [None] * len(bridge.position_px) if bridge.covariance_px is None else bridge.covariance_px
    both = zip(bridge.position_px, covariances, strict=True)
    return [{"track": 0, "position_px": _copy(place), "covariance_px": _copy(covariance)} for place, covariance in both]


def row_of_command(command: CameraCommand | None) -> Values:
    """Return the columns of an obeyed command."""
    return {} if command is None else {name: _copy(getattr(command, name.removeprefix(_OBEYED))) for name in _COMMANDS}


def row_of_time(taken: Taken | None) -> Values:
    """Return the columns of a time; None = not measured."""
    return dict(zip(TIMES, taken or (None, None), strict=True))


def answer_of(rows: Sequence[Values], many: bool) -> Answer:
    """Return the answer of one frame's rows: tracks of ``many`` targets, or the estimate of one."""
    tracks = [row for row in rows if row["track"] is not None]
    masks = [None if row["mask"] is None else codec.mask_of(row["mask"]) for row in tracks]
    estimates = [
        Estimate(**{name: row[name] for name in _OF_ESTIMATE}, mask=mask)
        for row, mask in zip(tracks, masks, strict=True)
    ]
    if not many:
        return estimates[0]
    return tuple(
        Track(row["identity"], estimate, row["kind"], row["size_m"], row["confidence"])
        for row, estimate in zip(tracks, estimates, strict=True)
    )


def command_of(row: Values) -> CameraCommand | None:
    """Return the obeyed command of a row; None if there was none."""
    values = {name.removeprefix(_OBEYED): row[name] for name in _COMMANDS}
    return None if None in values.values() else CameraCommand(**values)


def _time_of(row: Values) -> Taken | None:
    return None if row["cpu_s"] is None else Taken(row["cpu_s"], row["wall_s"])


def table_of(rows: Sequence[Values], constants: Mapping[str, Any]) -> tuple[pa.Table, Types]:
    """Return rows as a table, with columns of one value in all of them, and the types of numbers."""
    columns, types = [], {}
    for column in SCHEMA:
        values = [row.get(column.name) for row in rows]
        if column.name in _NUMBERS:
            changes = _types(values)
            if changes not in ([], [(0, "<f8")]):
                types[column.name] = changes
            values = [None if value is None else plain(np.asarray(value, np.float64)[()]) for value in values]
        elif column.name in constants:
            values = [constants[column.name]] * len(rows)
        columns.append(pa.array(values, column.type))
    return pa.table(columns, schema=SCHEMA), types


def values_of(table: pa.Table, types: Types) -> list[Values]:
    """Return the rows of a table, numbers in their own types and shapes."""
    columns = {
        name: list(_restored(table[name], _NUMBERS[name], types.get(name) or [(0, "<f8")]))
        if name in _NUMBERS
        else table[name].to_pylist()
        for name in table.column_names
    }
    return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]


def _copies_of(estimate: Estimate) -> Values:
    return _copies(estimate, _OF_ESTIMATE) | {"mask": None if estimate.mask is None else codec.runs_of(estimate.mask)}


def _copies(source: Estimate | Track, names: Mapping[str, Meaning]) -> Values:
    return {name: _copy(getattr(source, name)) for name in names}


def _copy(value: Any) -> Any:
    """Return numbers as an array of their own, since a tracker may use its arrays again."""
    if value is None:
        return None
    array = np.array(value)
    return array if array.dtype.kind in "fiub" else array.astype(float)


def _types(values: Sequence[Any]) -> list[tuple[int, str]]:
    """Return the rows from which on values are of another type; the first one counts from row 0 on."""
    changes: list[tuple[int, str]] = []
    for k, value in enumerate(values):
        if value is not None and (not changes or changes[-1][1] != np.asarray(value).dtype.str):
            changes.append((k if changes else 0, np.asarray(value).dtype.str))
    return changes


def _restored(column: pa.ChunkedArray, meaning: Meaning, changes: Sequence[tuple[int, str]]) -> Iterator[Any]:
    firsts, kinds = [first for first, _ in changes], [np.dtype(kind) for _, kind in changes]
    shape = [-1 if length == "K" else int(length) for length in meaning.shape]
    for k, scalar in enumerate(column):
        kind = kinds[bisect(firsts, k) - 1]
        if not scalar.is_valid:
            yield None
        elif shape:
            yield scalar.values.to_numpy(zero_copy_only=False).astype(kind).reshape(shape)
        else:
            number = kind.type(scalar.as_py())
            # With a float32 a judge calculates in float32, with a number of Python's own it does not.
            yield number if kind.kind == "f" and kind.itemsize < 8 else number.item()


def path_of(folder: Path, key: BlockKey) -> Path:
    """Return the path of a block's file; the seed and the tracker are for people."""
    digest = hashlib.sha256("/".join(map(str, astuple(key))).encode()).hexdigest()[:12]
    return folder / f"{key.seed:06d}-{quote(key.tracker, safe='')[:80]}-{digest}{_ENDING}"


def write_block(folder: Path, rows: Sequence[Values], facts: Facts) -> None:
    """Write a block's rows."""
    table, types = table_of(rows, facts.heading)
    content = json.dumps(asdict(facts) | {"types": types})
    folder.mkdir(parents=True, exist_ok=True)
    with atomic_file(path_of(folder, facts.key)) as file:
        pq.write_table(table.replace_schema_metadata({_FACTS: content}), file, compression="zstd")


def is_kept(folder: Path, key: BlockKey, editions: dict[str, str] | None) -> bool:
    """Return whether a block has a whole file, of these ``editions``; what judged it does not matter."""
    try:
        kept = facts_of(path_of(folder, key)).editions
    except (FileNotFoundError, ValueError):
        return False
    return editions is not None and kept | {"judge": ""} == editions | {"judge": ""}


def scan(directory: Path | str) -> pyarrow.dataset.Dataset:
    """Return all estimates of a result folder as an Arrow dataset, which reads chosen columns and rows only.

    Raises:
        ValueError: if there are none, or a file is cut off.
    """
    return pyarrow.dataset.dataset(list(map(str, facts_in(directory))), schema=SCHEMA, format="parquet")


def facts_in(directory: Path | str) -> dict[Path, Facts]:
    """Return the files of a result folder's estimates and what each holds of its block, e.g. where the tracker failed.

    Raises:
        ValueError: if there are none, or a file is cut off.
    """
    folder = Path(directory) / ESTIMATES
    paths = sorted(folder.glob(f"[!.]*{_ENDING}"))
    check("estimates", bool(paths), "files of `frameout bench --keep-estimates`", f"none in {str(folder)!r}")
    return {path: facts_of(path) for path in paths}


def facts_of(path: Path) -> Facts:
    """Return what a file holds of its block.

    Raises:
        ValueError: if it is cut off, no file of estimates, or one of another layout.
        FileNotFoundError: if it does not exist.
    """
    try:
        schema = pq.read_schema(path)
        values = json.loads((schema.metadata or {})[_FACTS])
        version = values["format"]
        check(str(path), version == FORMAT, f"estimates of format {FORMAT}", f"format {version}")
        check(str(path), schema.equals(SCHEMA), "the columns of estimates", f"{', '.join(schema.names)}")
        return Facts(**values | {"runs": [Run(**each) for each in values["runs"]]})
    except FileNotFoundError:
        raise
    except (pa.ArrowException, OSError, json.JSONDecodeError, KeyError, TypeError) as error:
        why = " ".join(f"{type(error).__name__}: {error}".split())
        raise ValueError(f"{path}: expected a whole file of estimates, got {why}") from None


def read_block(path: Path) -> Block:
    """Return all of a file. Raises ValueError, see ``facts_of``."""
    facts = facts_of(path)
    # Rows of one answer, or of one gap, lie together.
    together = groupby(
        values_of(pq.read_table(path), facts.types),
        lambda row: (row["repeat"], row["answer"], row["frame"] if row["gap"] is None else row["gap"]),
    )
    groups = [(repeat, answer, list(rows)) for (repeat, answer, _), rows in together]
    answered = []
    for repeat, run in enumerate(facts.runs):
        own = [(answer, rows) for each, answer, rows in groups if each == repeat]
        at_once, hindsight = ([rows for answer, rows in own if answer == wanted] for wanted in (AT_ONCE, HINDSIGHT))
        times, revision = ([_time_of(rows[0]) for rows in some] for some in (at_once, hindsight))
        answered.append(
            Answered(
                [answer_of(rows, facts.many) for rows in at_once],
                [answer_of(rows, many=True) for rows in hindsight] if run.revises else None,  # type: ignore[misc]
                [rows for answer, rows in own if answer in (EXTRAPOLATED, INTERPOLATED)],
                [taken for taken in times if taken is not None],
                next((taken for taken in revision if taken is not None), Taken(0.0, 0.0)),
            )
        )
    commands = [command_of(rows[0]) for repeat, answer, rows in groups if (repeat, answer) == (0, AT_ONCE)]
    return Block(facts, commands, answered)
