"""The report's table of facts about the episodes themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import Row
from benchmarks.contract.text import interval_text, number_text
from benchmarks.show.tables import Cell, Line, Table, column_of
from benchmarks.statistics.bootstrap import interval_of


@dataclass(frozen=True, slots=True)
class Facts:
    """A table of the report about the episodes themselves, independent of contestants.

    Attributes:
        title, words: of the table, note below it. lines: name of a line -> suffix after ``_`` in the names of its rows.
        columns: metrics, with rows named without the suffix. beside: name of what was measured elsewhere -> its rows.
    """

    title: str
    words: str
    lines: Mapping[str, str]
    columns: tuple[Metric, ...]
    beside: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def facts_table(facts: Facts, trackers: Mapping[str, Sequence[Row]]) -> Table:
    """Return the means over the episodes of one condition, each episode counted once; empty lines are left out.

    On a set path the rows of all trackers are equal; in closed loop each tracker has its own episode.
    """
    once = {
        (row["seed"], name if row["controller"] else "", row["metric"]): row
        for name, rows in trackers.items()
        for row in rows
    }
    rows = list(once.values())
    lines = []
    for words, suffix in facts.lines.items():
        cells = tuple(_cell(rows, metric, suffix) for metric in facts.columns)
        if any(cell is not None for cell in cells):
            lines.append(Line((words,), "", tuple(cell or Cell("–") for cell in cells)))
            for other, values in facts.beside.items():
                there = tuple(_beside(values, metric, suffix) for metric in facts.columns)
                lines.append(Line((f"{words}, {other}",), "", there))
    return Table(tuple(column_of(metric) for metric in facts.columns), tuple(lines))


def _beside(values: Mapping[str, float], metric: Metric, suffix: str) -> Cell:
    (quantity,) = metric.statistic.of
    value = values.get(f"{quantity.name}_{suffix}")
    return Cell("–" if value is None else number_text(value, metric.unit))


def _cell(rows: Sequence[Row], metric: Metric, suffix: str) -> Cell | None:
    found = interval_of(metric.statistic.of_line(suffix), rows)
    if found is None:
        return None
    return Cell(number_text(found.mean, metric.unit), interval_text(found.low, found.high, metric.unit))
