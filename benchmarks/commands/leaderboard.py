"""The leaderboard as text: for the terminal, and as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rich import box
from rich.table import Table

from benchmarks.commands.console import console_of
from benchmarks.report import tables
from benchmarks.report.markdown import head, markdown_table, names_and_cells, short
from benchmarks.run.records import REAL
from benchmarks.scores.summary import condition_of, steering_words
from benchmarks.suites.registry import suite

_WIDTH = 132
_WIDE_ENOUGH_FOR_INTERVALS = 120
_ROLE_STYLES = {"ours": "bold green", "oracle": "italic", "blind": "italic", "variant": "dim"}


def print_leaderboard(summary: Sequence[dict[str, Any]], *, markdown: bool = False) -> None:
    """Print a table for each scenario, preset, renderer and controller or link: the suite's headline, the best first.

    Args:
        summary: as ``write_summary`` returns it.
        markdown: print Markdown tables.
    """
    console = console_of(_WIDTH)
    intervals = markdown or console.width >= _WIDE_ENOUGH_FOR_INTERVALS
    for condition, entries in _conditions(summary):
        episodes = max(entry["n"] for entry in entries)
        scores = suite(entries[0]["suite"])
        recorded = "blocks of time" if scores.on_sequences is None else "sequences"
        units = recorded if entries[0]["scenario"] == REAL else "episodes"
        title = f"{condition}: {episodes} {units}{', 95 % intervals over them' if intervals else ''}"
        board = tables.leaderboard(scores, entries, sorted({entry["role"] for entry in entries}))
        if markdown:
            print(f"{title}\n")
            heads = [*scores.contestants, "role", *map(head, board.columns)]
            lines = map(names_and_cells, board.lines)
            print(markdown_table(heads, lines, words=len(scores.contestants) + 1), end="\n\n")
        else:
            console.print(_for_terminal(title, board, scores.contestants, intervals))


def _conditions(summary: Sequence[dict[str, Any]]) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    groups: dict[str, list[dict[str, Any]]] = {}
    for entry in summary:
        steered = f", {steering_words(condition_of(entry))}" if "controller" in entry else ""
        title = f"{entry['scenario']}, {entry['preset']}, {entry['renderer']}{steered}"
        groups.setdefault(title, []).append(entry)
    yield from groups.items()


def _for_terminal(title: str, board: tables.Table, names: Sequence[str], intervals: bool) -> Table:
    table = Table(title=title, box=box.SIMPLE_HEAD)
    for place, name in enumerate(names):
        table.add_column(name, no_wrap=True, min_width=max(len(line.names[place]) for line in board.lines))
    table.add_column("role", no_wrap=True, min_width=len("as-written"))
    for column in board.columns:
        table.add_column(head(column), justify="right", min_width=9 if intervals else 5)
    for line in board.lines:
        cells = [f"{cell.text}\n{short(cell.interval)}".rstrip() if intervals else cell.text for cell in line.cells]
        table.add_row(*line.names, line.role, *cells, style=_ROLE_STYLES.get(line.role, ""))
    return table
