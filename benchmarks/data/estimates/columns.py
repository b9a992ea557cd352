"""Columns of the tables of estimates, and their values: of estimates, tracks and commands, and back.

Numbers are stored as float64, exactly. A tracker may answer with others, e.g. float32, by which a judge's last digits
differ, so a file also notes their types.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args, get_type_hints

import numpy as np
import pyarrow as pa

from benchmarks.data.codec import field_of
from scenarios.truth import Meaning
from trackers.types import Answer, CameraCommand, CommandName, Estimate, Track

Values = dict[str, Any]
"""Column -> value of one row; a column that is missing is null."""
Types = dict[str, list[tuple[int, str]]]
"""Column -> rows from which on its numbers are of another type, and that type; without the columns of float64."""

AT_ONCE, HINDSIGHT, EXTRAPOLATED, INTERPOLATED = "at once", "hindsight", "extrapolated", "interpolated"
OBEYED = "obeyed_"

_WORDS = {
    "suite": Meaning("word"),
    "scenario": Meaning("word"),
    "preset": Meaning("word"),
    "renderer": Meaning("word"),
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
_OF_BRIDGE = ("position_px", "covariance_px")
_COMMANDS = {
    f"{OBEYED}{name}": Meaning(unit, (), "command that the carrier obeyed before this frame; null: none")
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
SCHEMA = pa.schema([field_of(name, _HINTS[name], each) for name, each in (_WORDS | _WHOLE | _NUMBERS).items()])
"""Columns of a file of estimates; lists hold arrays in row-major order."""


def rows_of_answer(answer: Answer) -> list[Values]:
    """Return a row for each track of an answer, copied; one without ``track`` if it has none."""
    if isinstance(answer, Estimate):
        return [{"track": 0, **_copies(answer, _OF_ESTIMATE)}]
    rows = []
    for place, each in enumerate(answer):
        named = {"track": place, "identity": int(each.identity), "kind": each.kind}
        rows.append({**named, **_copies(each.estimate, _OF_ESTIMATE), **_copies(each, _OF_TRACK)})
    return rows or [{}]


def rows_of_bridge(position_px: Any, covariance_px: Any) -> Iterator[Values]:
    """Yield a row for each frame of a ``Bridge``."""
    for k, position in enumerate(position_px):
        values = (position, None if covariance_px is None else covariance_px[k])
        yield {"track": 0} | {name: _copy(each) for name, each in zip(_OF_BRIDGE, values, strict=True)}


def row_of_command(command: CameraCommand | None) -> Values:
    """Return the columns of an obeyed command."""
    return {} if command is None else {name: _copy(getattr(command, name.removeprefix(OBEYED))) for name in _COMMANDS}


def answer_of(rows: Sequence[Values], many: bool) -> Answer:
    """Return the answer of one frame's rows: tracks of ``many`` targets, or the estimate of one."""
    if not many:
        return _estimate(rows[0])
    return tuple(
        Track(row["identity"], _estimate(row), row["kind"], row["size_m"], row["confidence"])
        for row in rows
        if row["track"] is not None
    )


def command_of(row: Values) -> CameraCommand | None:
    """Return the obeyed command of a row; None if there was none."""
    values = {name.removeprefix(OBEYED): row[name] for name in _COMMANDS}
    return None if None in values.values() else CameraCommand(**values)


def table_of(rows: Sequence[Values], constants: Mapping[str, Any]) -> tuple[pa.Table, Types]:
    """Return rows as a table, with columns of one value in all of them, and the types of numbers."""
    columns, types = {}, {}
    for field in SCHEMA:
        values = [row.get(field.name) for row in rows]
        if field.name in _NUMBERS:
            changes = _types(values)
            if changes not in ([], [(0, "<f8")]):
                types[field.name] = changes
            values = [None if value is None else _flat(value) for value in values]
        elif field.name in constants:
            values = [constants[field.name]] * len(rows)
        columns[field.name] = pa.array(values, field.type)
    return pa.table(columns, schema=SCHEMA), types


def values_of(table: pa.Table, types: Types) -> list[Values]:
    """Return the rows of a table, numbers in their own types and shapes."""
    columns = {}
    for name in table.column_names:
        if name in _NUMBERS:
            columns[name] = list(_restored(table[name], _NUMBERS[name], types.get(name, ())))
        else:
            columns[name] = table[name].to_pylist()
    return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]


def _estimate(row: Values) -> Estimate:
    return Estimate(**{name: row[name] for name in _OF_ESTIMATE})


def _copies(source: Estimate | Track, names: Mapping[str, Meaning]) -> Values:
    return {name: _copy(getattr(source, name)) for name in names}


def _copy(value: Any) -> Any:
    """Return numbers as an array of their own, since a tracker may use its arrays again."""
    if value is None:
        return None
    array = np.array(value)
    return array if array.dtype.kind in "fiub" else array.astype(float)


def _flat(value: Any) -> Any:
    array = np.asarray(value, np.float64).ravel()
    return array if np.ndim(value) else float(array[0])


def _types(values: Sequence[Any]) -> list[tuple[int, str]]:
    """Return the rows from which on values are of another type; the first one counts from row 0 on."""
    changes: list[tuple[int, str]] = []
    for k, value in enumerate(values):
        if value is not None and (not changes or changes[-1][1] != np.asarray(value).dtype.str):
            changes.append((k if changes else 0, np.asarray(value).dtype.str))
    return changes


def _restored(column: pa.ChunkedArray, meaning: Meaning, changes: Sequence[tuple[int, str]]) -> Iterator[Any]:
    kinds = iter([*changes, (len(column), "")])
    kind, (until, coming) = np.dtype("<f8"), next(kinds)
    for k, scalar in enumerate(column):
        while k == until:
            kind, (until, coming) = np.dtype(coming), next(kinds)
        if not scalar.is_valid:
            yield None
        elif meaning.shape:
            array = scalar.values.to_numpy(zero_copy_only=False).astype(kind)
            yield array.reshape([-1 if length == "K" else int(length) for length in meaning.shape])
        else:
            number = kind.type(scalar.as_py())
            # With a float32 a judge calculates in float32, with a number of Python's own it does not.
            yield number if kind.kind == "f" and kind.itemsize < 8 else number.item()
