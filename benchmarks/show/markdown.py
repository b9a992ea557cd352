"""Tables as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from benchmarks.show.tables import REFERENCES, Cell, Column, Line, Table


def markdown_table(heads: Sequence[str], lines: Iterable[Sequence[str]], words: int) -> str:
    """Return a table; the first ``words`` columns are text, the others numbers, which stand at the right.

    A bar in a cell is written so that it ends none.
    """
    ruler = ["---"] * words + ["---:"] * (len(heads) - words)
    rows = ([cell.replace("|", r"\|") for cell in cells] for cells in (heads, ruler, *lines))
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows)


def names_and_cells(line: Line) -> list[str]:
    """Return the cells of a contestant's line: its names, its role, its numbers."""
    return [*(f"`{name}`" for name in line.names), line.role, *map(number_and_interval, line.cells)]


def lines_in_parts(table: Table) -> list[list[str]]:
    """Return the cells of all lines; those of references have a heading if there are others too."""
    competitors, references = (list(map(names_and_cells, some)) for some in (table.competitors, table.references))
    between = [[f"*{REFERENCES}*", *[""] * (len(references[0]) - 1)]] if competitors and references else []
    return [*competitors, *between, *references]


def number_and_interval(cell: Cell) -> str:
    """Return a number with its interval, as ``94.2 (89.3–98.3)``."""
    return f"{cell.text} ({short(cell.interval)})" if cell.interval else cell.text


def head(column: Column) -> str:
    """Return a metric's name in words with its unit and an arrow for the better direction."""
    return " ".join(filter(None, (column.title, f"({column.unit})" if column.unit else "", column.goal)))


def short(interval: str) -> str:
    """Return an interval as ``89.3–98.3``."""
    return interval.replace(" … ", "–")
