"""The leaderboard as text: for the terminal, and as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

from benchmarks.contract.rows import REAL, Row
from benchmarks.contract.suite import suite
from benchmarks.contract.text import counted, time_in_words
from benchmarks.show import tables
from benchmarks.show.progress import console_of
from benchmarks.show.provenance import events_in
from benchmarks.statistics.summary import Groups, by_condition, condition_of, grouped, steering_words

_WIDTH = 132
_ROLE_STYLES = {
    "ours": "bold green",
    "external": "bold magenta",
    "oracle": "italic",
    "blind": "italic",
    "variant": "dim",
}


def print_leaderboard(
    summary: Sequence[dict[str, Any]],
    metrics: Sequence[str] = (),
    *,
    rows: Iterable[Row] = (),
    markdown: bool = False,
) -> None:
    """Print a table for each suite, scenario, preset, renderer and controller or link, the best first.

    On a narrow terminal the last columns are left out and named below; numbers keep their intervals.

    Args:
        summary: as ``write_summary`` returns it.
        metrics: names of those to show, the first one ranks; () = the suite's headline.
        rows: those of the summary; the titles tell how many events they are about where all trackers share them.
        markdown: print Markdown tables.
    """
    groups, conditions = grouped(rows), by_condition(summary)
    console, several = console_of(_WIDTH), len({condition[0] for condition in conditions}) > 1
    for condition, entries in conditions.items():
        episodes = max(entry["n"] for entry in entries)
        scores = suite(condition[0]).showing(metrics)
        recorded = ("block of time", "blocks of time") if scores.on_sequences is None else ("sequence", "sequences")
        units = recorded if condition[1] == REAL else ("episode", "episodes")
        over = "95 % intervals over them" if episodes > 1 else "too few for intervals"
        measured = {entry["metric"] for entry in entries}
        without = [name for name in scores.headline if name in metrics and name not in measured]
        gap = f"; no row gives {', '.join(without)}" if without else ""
        held = f"{counted(episodes, *units)}{_events(groups.get(condition, {}))}"
        where = [*condition[not several : 4], *_how(entries[0])]
        title = f"{', '.join(where)}: {held}, {over}{gap}"
        board = tables.leaderboard(scores, entries, sorted({entry["role"] for entry in entries}))
        if markdown:
            print(f"{title}\n")
            heads = [*scores.key_columns, "role", *(column.head for column in board.columns)]
            competitors, references = board.parts
            between = [[f"*{tables.REFERENCES}*", *[""] * (len(heads) - 1)]] if competitors and references else []
            lines = [*(line.words for line in competitors), *between, *(line.words for line in references)]
            print(tables.markdown_table(heads, lines, words=len(scores.key_columns) + 1), end="\n\n")
        else:
            console.print(_that_fits(console, title, board, scores.key_columns))


def _events(by_tracker: Mapping[str, Sequence[Row]]) -> str:
    """Return the number of the events of a condition in brackets; "" without any, or where each tracker has its own."""
    rows = [row for each in by_tracker.values() for row in each]
    events = [] if any(row["controller"] for row in rows) else events_in(rows)
    return f" ({suite(rows[0]['suite']).events.name}: {len(events)})" if events else ""


def print_by_episode(groups: Groups, metrics: Sequence[str] = ()) -> None:
    """Print a Markdown table for each condition: the metric that ranks, of each episode or real sequence.

    ``metrics``: see ``print_leaderboard``.
    """
    for condition, trackers in groups.items():
        judging = suite(condition[0]).showing(metrics)
        metric = judging.metric(judging.headline_in(condition[1])[0])
        table = tables.by_episode(metric, trackers, list(trackers))
        if table.lines:
            unit = "sequence" if any("sequence" in row for rows in trackers.values() for row in rows[:1]) else "seed"
            heads = [unit, *(column.name for column in table.columns)]
            print(f"{' '.join(filter(None, condition[1:]))}: {tables.column_of(metric).head}\n")
            lines = ([*line.names, *map(str, line.cells)] for line in table.lines)
            print(tables.markdown_table(heads, lines, words=1), end="\n\n")


def _how(entry: Mapping[str, Any]) -> Iterator[str]:
    """Yield how the camera was steered and how trackers had time, in words, where it is not as usual."""
    if "controller" in entry:
        yield steering_words(condition_of(entry))
    if "real_time_hz" in entry:
        yield time_in_words(entry["real_time_hz"])


def _that_fits(console: Console, title: str, board: tables.Table, names: Sequence[str]) -> Table:
    """Return the table with as many columns as fit, of whole words; at least one."""
    for count in range(len(board.columns), 1, -1):
        table = _for_terminal(title, board, names, count)
        if Measurement.get(console, console.options, table).minimum < console.width:
            return table
    return _for_terminal(title, board, names, 1)


def _for_terminal(title: str, board: tables.Table, names: Sequence[str], count: int) -> Table:
    """Return the table with the first ``count`` columns, each as wide as its longest word."""
    left_out = [column.title for column in board.columns[count:]]
    words = f"not shown, as the table would be too wide: {', '.join(left_out)} (see --metric, or widen the terminal)"
    table = Table(title=title, caption=words if left_out else None, box=box.SIMPLE_HEAD)
    for place, name in enumerate((*names, "role")):
        table.add_column(name, width=max(len(name), *(len((*line.names, line.role)[place]) for line in board.lines)))
    for place, column in enumerate(board.columns[:count]):
        parts = (part for line in board.lines for part in _number_above_interval(line.cells[place]))
        table.add_column(column.head, justify="right", width=max(map(len, (*column.head.split(), *parts))))
    for part in board.parts:
        for line in part:
            cells = ("\n".join(_number_above_interval(cell)) for cell in line.cells[:count])
            # Names may hold brackets, which are marks of style to rich.
            table.add_row(*map(escape, line.names), line.role, *cells, style=_ROLE_STYLES.get(line.role, ""))
        table.add_section()
    return table


def _number_above_interval(cell: tables.Cell) -> list[str]:
    return [cell.text, cell.short_interval] if cell.interval else [cell.text]
