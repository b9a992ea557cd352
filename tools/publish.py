"""``python -m tools publish``: make the published tables, check them, and put them into RESULTS.md and docs/results."""

from __future__ import annotations

import json
import os
import sys
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import tyro

from benchmarks.cli.arguments import COUNT, FOLDER, WORKERS, Names, seeds_text
from benchmarks.contract.rows import FILE_NAME, read_blocks, read_rows
from benchmarks.run.arithmetic import calculates_like_published
from benchmarks.run.result_folder import make_folder
from benchmarks.run.workers import cores
from benchmarks.show.progress import progress_bar
from sim.checks import check
from tools.publishing import ledger
from tools.publishing.results_page import results_pages
from tools.publishing.table_files import begin, differing, label, read_rows_of, read_table, table_file, write_table
from tools.publishing.tables import PublishedTable, tables_named
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
        if self.dry_run:
            print("\n".join(f"{table.name:24} {seeds_text(table.seeds):12} {table.command}" for table in tables))
            return 0
        commit = ledger.commit()
        return max([self._publish(table, commit) for table in tables])

    def _publish(self, table: PublishedTable, commit: str) -> int:
        """Make a table and write its files; return 1 if a tracker failed."""
        out = self.out / table.name
        make_folder(out)
        begin(table, out)
        before = _rows(out)
        with progress_bar(table.name) as progress:
            table.make(out, cores(self.workers), progress)
        if _rows(out) != before:
            ledger.record(table.command, commit, table.seeds, f"table {table.name}")
        now = ledger.commit()
        check("publish", now == commit, f"the commit {commit} of the start until the end", now)
        failures = write_table(table, out, commit)["failures"]
        print(table_file(table.name))
        for failure in failures:
            print(f"error: {table.name}: {failure['contestant']} failed on seed {failure['seed']}", file=sys.stderr)
        return int(bool(failures))

    def _check_all(self, tables: Sequence[PublishedTable]) -> int:
        """Print what differs from published tables; return 1 if anything does."""
        published = {table.name: read_table(table.name) for table in tables if table_file(table.name).is_file()}
        checked = [table for table in tables if published.get(table.name, {}).get("rows") is not None]
        left_out = ", ".join(table.name for table in tables if table not in checked)
        fine = bool(checked) and not (self.tables and left_out)
        check("tables", fine, "some that were published with rows, as times are never equal", left_out)
        for table in checked:
            command = published[table.name]["command"]
            check("tables", table.command == command, f"{table.name} as published, `{command}`", f"`{table.command}`")
        if left_out:
            print(f"note: without published rows, and not checked: {left_out}", file=sys.stderr)
        if changed := ledger.uncommitted():
            print(f"note: the code is not as committed: changes in {changed}", file=sys.stderr)
        if not calculates_like_published(os.environ):
            why = "the tables were made with other instructions of the processor, see benchmarks/run/arithmetic.py"
            print(f"note: figures may differ: {why}", file=sys.stderr)
        return max([self._check(table, published[table.name]["varied"]) for table in checked])

    def _check(self, table: PublishedTable, varied: dict[str, Any] | None) -> int:
        """Print what differs from the published table; return 1 if anything does."""
        name, again = table.name, replace(table, seeds=table.seeds[: self.episodes])
        with TemporaryDirectory() as place, progress_bar(f"{name} anew") as progress:
            out = Path(place)
            again.make(out, cores(self.workers), progress)
            made = read_blocks(out)
            # As read from a file: there are no tuples in JSON.
            varied_now = json.loads(json.dumps(again.figures(out, read_rows(out))["varied"]))
        wanted = {key: rows for key, rows in read_rows_of(name).items() if key.seed in again.seeds}
        pairs = [(wanted[key][0]["editions"], made[key][0]["editions"]) for key in wanted.keys() & made.keys()]
        if parts := sorted({part for before, now in pairs for part in before if now.get(part) != before[part]}):
            print(f"note: {name} was published with another edition of: {', '.join(parts)}", file=sys.stderr)
        other_seeds: dict[str, list[int]] = defaultdict(list)
        for key in differing(wanted, made):
            other_seeds[label((wanted.get(key) or made[key])[0])].append(key.seed)
        lines = [
            f"{name}: {which} has other figures on {len(of)} seeds, first on {of[0]}"
            for which, of in other_seeds.items()
        ]
        if self.episodes is None and varied_now != varied:
            lines.append(f"{name}: the table of what was fitted, varied, has other figures")
        print("\n".join(lines) or f"{name}: the same figures on seeds {seeds_text(again.seeds)}")
        return int(bool(lines))


def _rows(folder: Path) -> dict[Path, bytes]:
    """Return all rows of a table, also of a paper's with other settings."""
    return {file: file.read_bytes() for file in folder.rglob(FILE_NAME)}
