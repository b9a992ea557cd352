"""Rows as long tables for pandas: a line for each number, and apart from them a line for each entry of a list.

Columns of both: ``suite scenario preset renderer controller link tracker role seed sequence repeat``; then what the row
is about, ``event_kind event_index`` and the event's other attributes, all empty for rows about a whole episode; then
``metric value weight``. ``benchmarks.contract.rows`` defines metrics and events. Values are floats; an undefined value,
null in a row, is NaN. A column that no row has is left out, e.g. ``link`` in most suites, and
``sequence`` in simulated ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from benchmarks.contract.rows import Row, event_of

if TYPE_CHECKING:
    import pandas as pd

_NAMES = (
    *("suite", "scenario", "preset", "renderer", "controller", "link"),
    *("tracker", "tracker_role", "role", "seed", "sequence", "repeat"),
)
_EVENT_FIRST = ("event_kind", "event_index")
_LAST = ("metric", "value", "weight")


def numbers_table(rows: Iterable[Row]) -> pd.DataFrame:
    """Return the rows whose value is a number, a truth value (1 or 0) or null, a line for each."""
    return _table(({**_heading(row), "value": _number(row["value"])} for row in rows if not _is_list(row)), _LAST)


def lists_table(rows: Iterable[Row]) -> pd.DataFrame:
    """Return the rows whose value is a list (a *series*), a line for each entry: ``entry`` is its place from 0 on."""
    return _table(_entries(row for row in rows if _is_list(row)), ("metric", "entry", "value", "weight"))


def _entries(rows: Iterable[Row]) -> Iterator[dict[str, Any]]:
    for row in rows:
        for entry, value in enumerate(row["value"]):
            yield {**_heading(row), "entry": entry, "value": _number(value)}


def _is_list(row: Row) -> bool:
    return isinstance(row["value"], list)


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _heading(row: Row) -> dict[str, Any]:
    about = {f"event_{key}": value for key, value in (event_of(row) or {}).items()}
    return {**{name: row.get(name) for name in _NAMES}, **about, "metric": row["metric"], "weight": row.get("weight")}


def _table(lines: Iterable[dict[str, Any]], last: tuple[str, ...]) -> pd.DataFrame:
    import pandas as pd

    table = pd.DataFrame(list(lines))
    if table.empty:
        return pd.DataFrame(columns=[*_NAMES, *last])
    about = [name for name in table.columns if name not in (*_NAMES, *_EVENT_FIRST, *last)]
    table = table.reindex(columns=[*_NAMES, *_EVENT_FIRST, *about, *last]).dropna(axis="columns", how="all")
    return table.astype({"value": float, "weight": float})
