"""The leaderboard as text: for the terminal, and as Markdown."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table

from benchmarks.contract.rows import REAL
from benchmarks.contract.suite import suite
from benchmarks.contract.text import counted
from benchmarks.show import tables
from benchmarks.show.console import console_of
from benchmarks.show.markdown import head, lines_in_parts, markdown_table, short
from benchmarks.statistics.summary import condition_of, steering_words

_WIDTH = 132
_HEAD_LINES = (2, 3, 4, 8)
"""Lines of a table's head that are tried, so that more columns fit."""
_ROLE_STYLES = {
    "ours": "bold green",
    "external": "bold magenta",
    "oracle": "italic",
    "blind": "italic",
    "variant": "dim",
}


def print_leaderboard(
    summary: Sequence[dict[str, Any]], metrics: Sequence[str] = (), *, markdown: bool = False
) -> None:
    """Print a table for each scenario, preset, renderer and controller or link, the best first.

    On a narrow terminal the last columns are left out and named below; numbers keep their intervals.

    Args:
        summary: as ``write_summary`` returns it.
        metrics: names of those to show, the first one ranks; () = the suite's headline.
        markdown: print Markdown tables.
    """
    console = console_of(_WIDTH)
    for condition, entries in _conditions(summary):
        episodes = max(entry["n"] for entry in entries)
        scores = suite(entries[0]["suite"]).showing(metrics)
        recorded = ("block of time", "blocks of time") if scores.on_sequences is None else ("sequence", "sequences")
        units = recorded if entries[0]["scenario"] == REAL else ("episode", "episodes")
        over = "95 % intervals over them" if episodes > 1 else "too few for intervals"
        measured = {entry["metric"] for entry in entries}
        without = [name for name in scores.headline if name in metrics and name not in measured]
        gap = f"; no row gives {', '.join(without)}" if without else ""
        title = f"{condition}: {counted(episodes, *units)}, {over}{gap}"
        board = tables.leaderboard(scores, entries, sorted({entry["role"] for entry in entries}))
        if markdown:
            print(f"{title}\n")
            heads = [*scores.contestants, "role", *map(head, board.columns)]
            print(markdown_table(heads, lines_in_parts(board), words=len(scores.contestants) + 1), end="\n\n")
        else:
            console.print(_that_fits(console, title, board, scores.contestants))


def _conditions(summary: Sequence[dict[str, Any]]) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    groups: dict[str, list[dict[str, Any]]] = {}
    for entry in summary:
        steered = f", {steering_words(condition_of(entry))}" if "controller" in entry else ""
        title = f"{entry['scenario']}, {entry['preset']}, {entry['renderer']}{steered}"
        groups.setdefault(title, []).append(entry)
    yield from groups.items()


def _that_fits(console: Console, title: str, board: tables.Table, names: Sequence[str]) -> Table:
    """Return the table with as many columns as fit, of whole words; at least one."""
    for count in range(len(board.columns), 0, -1):
        for head_lines in _HEAD_LINES:
            table = _for_terminal(title, board, names, count, head_lines)
            if Measurement.get(console, console.options, table).minimum < console.width or count == 1:
                return table
    return _for_terminal(title, board, names, 0, 1)


def _for_terminal(title: str, board: tables.Table, names: Sequence[str], count: int, head_lines: int) -> Table:
    """Return the table with the first ``count`` columns, whose heads have at most ``head_lines`` lines."""
    left_out = [column.title for column in board.columns[count:]]
    words = f"not shown, as the table would be too wide: {', '.join(left_out)} (choose with --metric)"
    table = Table(title=title, caption=words if left_out else None, box=box.SIMPLE_HEAD)
    for place, name in enumerate(names):
        table.add_column(name, width=max(len(name), *(len(line.names[place]) for line in board.lines)))
    table.add_column("role", width=max(len("role"), *(len(line.role) for line in board.lines)))
    for place, column in enumerate(board.columns[:count]):
        cells = [part for line in board.lines for part in _lines_of(line.cells[place])]
        table.add_column(head(column), justify="right", width=_width(head(column), cells, head_lines))
    for part in (board.competitors, board.references):
        for line in part:
            shown = ("\n".join(_lines_of(cell)) for cell in line.cells[:count])
            table.add_row(*line.names, line.role, *shown, style=_ROLE_STYLES.get(line.role, ""))
        table.add_section()
    return table


def _lines_of(cell: tables.Cell) -> list[str]:
    """Return a number and, below it, its interval."""
    return [cell.text, *filter(None, [short(cell.interval)])]


def _width(title: str, cells: Sequence[str], head_lines: int) -> int:
    """Return the least width of a column that cuts no word and gives its head at most so many lines, if it can."""
    least = max(map(len, (*title.split(), *cells)))
    widths = range(least, max(least, len(title)) + 1)
    return next((width for width in widths if len(textwrap.wrap(title, width)) <= head_lines), least)
