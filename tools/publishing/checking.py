"""Makes a published table again and compares its figures with the committed ones."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.contract.rows import BlockKey, read_blocks, read_rows
from benchmarks.run.experiment import Progress
from sim.checks import check
from tools.publishing.figures_hash import differing, hash_of_figures
from tools.publishing.published import tables_named
from tools.publishing.table_files import read_rows_of, read_table, table_file
from tools.publishing.table_runs import TableRun, run_of


def runs_to_check(names: tuple[str, ...]) -> list[TableRun]:
    """Return the runs that make tables again, with the trackers that they were published with.

    Args:
        names: of tables; () = all published ones with rows.

    Raises:
        ValueError: for a table that is not published, was published with other data, or has no rows; for trackers that
            need what is not installed.
    """
    unpublished = [table.name for table in tables_named(names) if not table_file(table.name).is_file()]
    check("tables", not (names and unpublished), "some that were published", ", ".join(unpublished))
    tables = [table for table in tables_named(names) if table.name not in unpublished]
    chosen = [table for table in tables if names or read_table(table.name)["rows"] is not None]
    check("tables", bool(chosen), "some that were published with rows", "none")
    runs = [run_of(replace(table, trackers=tuple(read_table(table.name)["trackers"]))) for table in chosen]
    for run in runs:
        _check_can_be_compared(run)
    return runs


def _check_can_be_compared(run: TableRun) -> None:
    name = run.table.name
    kept = read_table(name)
    check("tables", kept["rows"] is not None, "some with rows, as times are never equal", repr(name))
    check("tables", run.command == kept["command"], f"{name} as published, `{kept['command']}`", f"`{run.command}`")
    run.check_installed()


def differences(run: TableRun, out: Path, episodes: int | None, workers: int, progress: Progress) -> list[str]:
    """Make a table anew in ``out``; return lines about figures that are not the committed ones, none if all are.

    Args:
        run: one of ``runs_to_check``. out: empty folder. episodes: number of first seeds to make; None = all.
    """
    name = run.table.name
    kept, kept_rows = read_table(name), read_rows_of(name)
    left_out = kept["rows"]["unrepeatable"]
    if hash_of_figures(kept_rows, left_out) != kept["rows"]["sha256"]:
        return [f"{name}: its committed rows are not those of its hash"]
    seeds = run.table.seeds[:episodes]
    run_of(replace(run.table, seeds=seeds)).run(out, workers, progress)
    made = read_blocks(out)
    # As read from a file: there are no tuples in JSON.
    if episodes is None and json.loads(json.dumps(run.varied(out, read_rows(out)))) != kept["varied"]:
        return [f"{name}: the table of what was fitted, varied, has other figures"]
    wanted = {key: rows for key, rows in kept_rows.items() if key.seed in seeds}
    return _lines(name, differing(wanted, made, left_out))


def other_editions(run: TableRun, out: Path) -> list[str]:
    """Return the parts that made the rows in ``out`` in another edition than the published ones."""
    published, made = read_rows_of(run.table.name), read_blocks(out)
    pairs = [(published[key][0]["editions"], made[key][0]["editions"]) for key in published.keys() & made.keys()]
    return sorted({part for before, now in pairs for part in before if now.get(part) != before[part]})


def _lines(name: str, keys: Sequence[BlockKey]) -> list[str]:
    seeds: dict[str, list[int]] = defaultdict(list)
    for key in keys:
        seeds["+".join(filter(None, (key.controller, key.tracker)))].append(key.seed)
    return [f"{name}: {label} has other figures on {len(of)} seeds, first on {of[0]}" for label, of in seeds.items()]
