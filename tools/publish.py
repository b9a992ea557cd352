"""``python -m tools publish``: make the published tables, check them, and put them into RESULTS.md and docs/results."""

from __future__ import annotations

import json
import os
import sys
from collections import defaultdict
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import tyro
from rich import box
from rich.table import Table

from benchmarks.cli.arguments import COUNT, FOLDER, WORKERS, Names
from benchmarks.contract.rows import FILE_NAME, read_blocks, read_rows
from benchmarks.run.arithmetic import calculates_like_published
from benchmarks.run.result_folder import make_folder
from benchmarks.run.workers import cores
from benchmarks.show.progress import console_of, progress_bar
from sim.checks import check
from tools.publishing import ledger
from tools.publishing.published import PublishedTable, tables_named
from tools.publishing.results_page import results_pages
from tools.publishing.table_files import begin, differing, read_rows_of, read_table, table_file, write_table
from tools.publishing.table_runs import TableRun, run_of
from trackers.atomic_file import write_atomic


@dataclass(frozen=True)
class Publish:
    """Make the published tables: run what tools/publishing/published.toml lists, and write the files that RESULTS.md is
    made from to tools/publishing/tables. All of them from nothing take at most two and a half hours on two cores; a
    change that needs more cuts episodes or trackers elsewhere.

    A run that was stopped continues with the same command. It needs a checkout without changes to the code, and all
    that the tables' trackers need. Rows of an earlier commit, also the committed ones, stay where they are of the
    present editions and parameters (benchmarks/run/editions.py). Each run on the test split that made rows is recorded
    in tools/publishing/test_split_runs.jsonl. The exit status is 1 if a tracker failed.

    Attributes:
        tables: names of tables (default: all; with --check, all published ones that have rows).
        dry_run: only list the tables, their seeds and commands.
        check: make the tables anew in a temporary folder instead, and compare all figures but times with the published
            ones; exit status 1 if one differs.
        episodes: with --check, make only this number of each table's first seeds.
        render: make RESULTS.md and the pages of docs/results from their templates and the published tables instead.
        out: folder for the rows (default: results/published).
        workers: number of worker processes; 0 = run in this process.
    """

    tables: tyro.conf.Positional[Names] = ()
    dry_run: bool = False
    check: bool = False
    episodes: Annotated[int | None, COUNT] = None
    render: bool = False
    out: Annotated[Path, FOLDER] = Path("results/published")
    workers: Annotated[int | None, WORKERS] = None
    resumes = True

    def run(self) -> int:
        """Do it; return the exit status."""
        chosen = [name for name in ("dry_run", "check", "render") if getattr(self, name)]
        check("publish", len(chosen) <= 1, "one of --dry-run, --check, --render", " ".join(chosen))
        positive = self.episodes is None or (self.check and self.episodes >= 1)
        check("episodes", positive, "a whole number >= 1, with --check alone", self.episodes)
        if self.render:
            for path, text in results_pages().items():
                write_atomic(path, text)
                print(path)
            return 0
        tables = tables_named(self.tables)
        if self.check:
            return self._check_all(tables)
        runs = [run_of(table) for table in tables]
        if self.dry_run:
            console_of().print(_list_of(runs))
            return 0
        commit = ledger.commit()
        return max([self._publish(run, commit) for run in runs])

    def _publish(self, run: TableRun, commit: str) -> int:
        """Make a table and write its files; return 1 if a tracker failed."""
        table, out = run.table, self.out / run.table.name
        make_folder(out)
        begin(run, out)
        before = _rows(out)
        with progress_bar(table.name) as progress:
            run.run(out, cores(self.workers), progress)
        if _rows(out) != before:
            ledger.record(run.command, commit, table.seeds, f"table {table.name}")
        now = ledger.commit()
        check("publish", now == commit, f"the commit {commit} of the start until the end", now)
        failures = write_table(run, out, commit)["failures"]
        print(table_file(table.name))
        for failure in failures:
            print(f"error: {table.name}: {failure['contestant']} failed on seed {failure['seed']}", file=sys.stderr)
        return int(bool(failures))

    def _check_all(self, tables: tuple[PublishedTable, ...]) -> int:
        """Print what differs from published tables; return 1 if anything does."""
        left_out = [
            table.name
            for table in tables
            if not table_file(table.name).is_file() or read_table(table.name)["rows"] is None
        ]
        runs = [run_of(table) for table in tables if table.name not in left_out]
        fine = bool(runs) and not (self.tables and left_out)
        check("tables", fine, "some that were published with rows, as times are never equal", ", ".join(left_out))
        for run in runs:
            command = read_table(run.table.name)["command"]
            check("tables", run.command == command, f"{run.table.name} as published, `{command}`", f"`{run.command}`")
        if left_out:
            print(f"note: without published rows, and not checked: {', '.join(left_out)}", file=sys.stderr)
        if changed := ledger.uncommitted():
            print(f"note: the code is not as committed: changes in {changed}", file=sys.stderr)
        if not calculates_like_published(os.environ):
            why = "the tables were made with other instructions of the processor, see benchmarks/run/arithmetic.py"
            print(f"note: figures may differ: {why}", file=sys.stderr)
        return max([self._check(run) for run in runs])

    def _check(self, run: TableRun) -> int:
        """Print what differs from the published table; return 1 if anything does."""
        name, seeds = run.table.name, run.table.seeds[: self.episodes]
        again = run_of(replace(run.table, seeds=seeds))
        with TemporaryDirectory() as place, progress_bar(f"{name} anew") as progress:
            out = Path(place)
            again.run(out, cores(self.workers), progress)
            made = read_blocks(out)
            # As read from a file: there are no tuples in JSON.
            varied = json.loads(json.dumps(again.figures(out, read_rows(out))["varied"]))
        wanted = {key: rows for key, rows in read_rows_of(name).items() if key.seed in seeds}
        pairs = [(wanted[key][0]["editions"], made[key][0]["editions"]) for key in wanted.keys() & made.keys()]
        if parts := sorted({part for before, now in pairs for part in before if now.get(part) != before[part]}):
            print(f"note: {name} was published with another edition of: {', '.join(parts)}", file=sys.stderr)
        other_seeds: dict[str, list[int]] = defaultdict(list)
        for key in differing(wanted, made):
            other_seeds["+".join(filter(None, (key.controller, key.tracker)))].append(key.seed)
        lines = [
            f"{name}: {which} has other figures on {len(of)} seeds, first on {of[0]}"
            for which, of in other_seeds.items()
        ]
        if self.episodes is None and varied != read_table(name)["varied"]:
            lines.append(f"{name}: the table of what was fitted, varied, has other figures")
        print("\n".join(lines) or f"{name}: the same figures on seeds {again.seeds}")
        return int(bool(lines))


def _list_of(runs: list[TableRun]) -> Table:
    shown = Table("table", "seeds", "command", box=box.SIMPLE_HEAD)
    for run in runs:
        shown.add_row(run.table.name, run.seeds, run.command)
    return shown


def _rows(folder: Path) -> dict[Path, bytes]:
    """Return all rows of a table, also of a paper's with other settings."""
    return {file: file.read_bytes() for file in folder.rglob(FILE_NAME)}
