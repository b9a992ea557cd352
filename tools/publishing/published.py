"""The published tables, read from ``published.toml``. ``python -m tools publish`` makes them, RESULTS.md shows them."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from sim.checks import check


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedTable:
    """One published run.

    Attributes:
        name: of the table and its files.
        kind: the command that it repeats: ``frameout bench``, ``frameout paper`` or ``python -m tools speed``.
        suite: of a bench. scenario: catalogue id with its version, of a bench or a speed. preset: of the scenario.
        trackers, controllers: of a bench, by name. In the file, the trackers of a ``group`` stand before them.
        experiment: of a paper, which sets scenario, preset and methods.
        seeds: of the episodes, in the file [A, B].
        stored: whether a speed is that of data sets.
        frames: timed in each town of a speed.
    """

    name: str
    kind: Literal["bench", "paper", "speed"] = "bench"
    suite: str = ""
    scenario: str = ""
    preset: str = "standard"
    trackers: tuple[str, ...] = ()
    controllers: tuple[str, ...] = ()
    experiment: str = ""
    seeds: range
    stored: bool = False
    frames: int = 60


def _tables() -> tuple[PublishedTable, ...]:
    listed = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))

    def table(fields: dict[str, Any]) -> PublishedTable:
        group = listed["groups"][fields.pop("group")] if "group" in fields else []
        fields["trackers"] = (*group, *fields.get("trackers", ()))
        fields["controllers"] = tuple(fields.get("controllers", ()))
        return PublishedTable(**fields | {"seeds": range(*fields["seeds"])})

    return tuple(map(table, listed["tables"]))


TABLES = _tables()
"""In the order of RESULTS.md."""


def tables_named(names: tuple[str, ...]) -> tuple[PublishedTable, ...]:
    """Return the tables of these names in the order of the list; () = all. Raises ValueError for an unknown name."""
    known = {table.name: table for table in TABLES}
    for name in names:
        check("tables", name in known, f"some of {', '.join(known)}", repr(name))
    return tuple(table for table in TABLES if table.name in (names or known))
