"""``python -m tools publish``: make the published tables, check them, and put them into RESULTS.md and docs/results."""

from __future__ import annotations

import hashlib
import json
import math
import os
import sys
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import tyro
from rich import box
from rich.table import Table

from benchmarks.cli.arguments import COUNT, FOLDER, NAMES, WORKERS, names
from benchmarks.contract.rows import FILE_NAME
from benchmarks.run.arithmetic import calculates_like_published
from benchmarks.run.result_folder import make_folder
from benchmarks.run.workers import cores
from benchmarks.show.progress import console_of, progress_bar
from benchmarks.statistics.summary import SUMMARY_FILE_NAME
from sim.checks import check
from tools.publishing import ledger
from tools.publishing.checking import differences, other_editions, runs_to_check
from tools.publishing.durations import Duration, duration_of
from tools.publishing.published import PublishedTable, tables_named
from tools.publishing.results_page import results_pages
from tools.publishing.table_files import committed_rows, read_table, table_file, write_table
from tools.publishing.table_runs import TableRun, run_of
from trackers.atomic_file import write_atomic

_COMMIT = "commit.json"
"""In the folder of a table's rows: where they were made."""


@dataclass(frozen=True)
class Publish:
    """Make the published tables: run what tools/publishing/published.py lists, and write the files that RESULTS.md is
    made from to tools/publishing/tables. All of them from nothing take at most two and a half hours on two cores; a
    change that needs more cuts episodes or contestants elsewhere.

    A run that was stopped continues with the same command. It starts with an estimate of its time. It needs a
    checkout without changes to the code, and all that the tables' trackers need. Rows of an earlier commit, also the
    committed ones, stay where they are of the present editions and parameters (benchmarks/run/editions.py). Each run on
    the test split that made rows is recorded in tools/publishing/test_split_runs.jsonl. The exit status is 1 if a
    tracker failed.

    Attributes:
        tables: names of tables (default: all; with --check, all published ones that have rows).
        dry_run: only list the tables, their seeds and the hours that they take.
        check: make the tables anew in a temporary folder instead, and compare all figures but times with the published
            ones; exit status 1 if one differs.
        episodes: with --check, make only this number of each table's first seeds.
        render: make RESULTS.md and the pages of docs/results from their templates and the published tables instead.
        out: folder for the rows (default: results/published).
        workers: number of worker processes; 0 = run in this process.
    """

    tables: Annotated[tuple[str, ...], tyro.conf.Positional, NAMES] = ()
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
            return _render()
        if self.check:
            return self._check_all()
        runs = [run_of(table) for table in tables_named(names(self.tables))]
        for run in runs:
            _ = run.command  # Unknown names are refused before anything runs.
            if not self.dry_run:
                run.check_installed()
        commit = "" if self.dry_run else ledger.commit()
        make_folder(self.out)
        for run in () if self.dry_run else runs:
            _claim(self.out / run.table.name, run.table, commit)
        durations = self._plan(runs)
        return 0 if self.dry_run else self._publish(runs, durations, commit)

    def _plan(self, runs: list[TableRun]) -> list[Duration]:
        """Print the tables with their times, and return these."""
        shown = Table(box=box.SIMPLE_HEAD)
        for head in ("table", "seeds", "left to make", "hours left", "by the time of"):
            shown.add_column(head, justify="right" if head in ("left to make", "hours left") else "left")
        durations = []
        for run in runs:
            seeds = f"{run.table.seeds.start}:{run.table.seeds.stop}"
            if missing := run.missing():
                durations.append(Duration(math.nan, len(run.table.seeds), ""))
                shown.add_row(run.table.name, seeds, "?", "?", f"not installed: {', '.join(missing)}")
                continue
            with progress_bar(f"measuring {run.table.name}") as progress:
                duration = duration_of(run, self.out, self.out / run.table.name, progress)
            durations.append(duration)
            hours_left = _hours(duration.hours(self._cores))
            shown.add_row(run.table.name, seeds, f"{duration.missing:.0f}", hours_left, duration.source)
        console_of().print(shown)
        unknown = " and those not known (?)" if any(math.isnan(each.seed_s) for each in durations) else ""
        in_all = _hours(_sum_of_hours(durations, self._cores))
        print(f"in all about {in_all} h{unknown} on {self._cores} cores that do nothing else", flush=True)
        return durations

    @property
    def _cores(self) -> int:
        """How many run at a time: one for each worker, and no more than this process may use."""
        return max(1, min(cores(self.workers), cores(None)))

    def _publish(self, runs: list[TableRun], durations: list[Duration], commit: str) -> int:
        status, started = 0, time.monotonic()
        for number, run in enumerate(runs, start=1):
            table, folder = run.table, self.out / run.table.name
            why = f"table {table.name}" if table.seeds.stop > ledger.TEST_SPLIT.start else ""
            title = f"{table.name}, {number} of {len(runs)} tables"
            ran = partial(_has_other_rows, folder, _digest(folder))
            with ledger.recorded(run.command, table.seeds, why, ran), progress_bar(title) as progress:
                run.run(folder, cores(self.workers), progress)
            now = ledger.commit()
            check("publish", now == commit, f"the commit {commit} of the start until the end", now)
            print(write_table(run, folder, commit))
            failures = read_table(table.name)["failures"]
            for failure in failures:
                print(f"error: {table.name}: {failure['contestant']} failed on seed {failure['seed']}", file=sys.stderr)
            status = max(status, int(bool(failures)))
            print(_left(durations, number, time.monotonic() - started, self._cores), flush=True)
        print("RESULTS.md and docs/results are made by: python -m tools publish --render")
        return status

    def _check_all(self) -> int:
        """Print what differs from published tables; return 1 if anything does."""
        runs = runs_to_check(names(self.tables))
        left_out = [
            table.name for table in tables_named(()) if not self.tables and not table_file(table.name).is_file()
        ]
        if left_out:
            print(f"note: not published, and not checked: {', '.join(left_out)}", file=sys.stderr)
        changed = ledger.uncommitted()
        if changed:
            print(f"note: the code is not as committed: changes in {changed}", file=sys.stderr)
        if not calculates_like_published(os.environ):
            told = "the tables were made with other instructions of the processor, see benchmarks/run/arithmetic.py"
            print(f"note: figures may differ: {told}", file=sys.stderr)
        return max([self._check(run) for run in runs])

    def _check(self, run: TableRun) -> int:
        """Print what differs from the published table; return 1 if anything does."""
        name = run.table.name
        with TemporaryDirectory() as place, progress_bar(f"{name} anew") as progress:
            lines = differences(run, Path(place), self.episodes, cores(self.workers), progress)
            parts = other_editions(run, Path(place)) if any(Path(place).iterdir()) else []
        if parts:
            print(f"note: {name} was published with another edition of: {', '.join(parts)}", file=sys.stderr)
        seeds = run.table.seeds[: self.episodes]
        print("\n".join(lines) or f"{name}: the same figures on seeds {seeds.start}:{seeds.stop}")
        return int(bool(lines))


def _claim(folder: Path, table: PublishedTable, commit: str) -> None:
    """Mark a table's folder as made at ``commit``.

    Of another commit only rows stay: a run keeps those of the present editions and parameters, and makes the
    others anew. A new folder begins with the committed rows, whose times may be another machine's. What has no rows, a
    speed, is measured anew.

    Raises:
        ValueError: if this command did not make the folder.
    """
    make_folder(folder)
    mark, told = folder / _COMMIT, json.dumps({"commit": commit}) + "\n"
    if not mark.is_file():
        others = sorted(each.name for each in folder.iterdir())
        check("out", not others, "folders of tables that this command made", f"{str(folder)!r} with {others[:1]}")
        write_atomic(mark, told)
        if rows := committed_rows(table):
            write_atomic(folder / FILE_NAME, rows)
    elif mark.read_text() != told:
        (folder / SUMMARY_FILE_NAME).unlink(missing_ok=True)
        write_atomic(mark, told)


def _digest(folder: Path) -> str:
    """Return a hash of all rows of a table, also of a paper's with other settings."""
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(folder.rglob(FILE_NAME)))).hexdigest()


def _has_other_rows(folder: Path, digest: str) -> bool:
    return _digest(folder) != digest


def _render() -> int:
    for path, text in results_pages().items():
        write_atomic(path, text)
        print(path)
    return 0


def _left(durations: list[Duration], done: int, took_s: float, workers: int) -> str:
    """Return a line about the time left, by how much longer the tables so far took than they were to take."""
    expected_h = _sum_of_hours(durations[:done], workers)
    factor = took_s / 3600.0 / expected_h if expected_h > 0 else 1.0
    left_h = factor * _sum_of_hours(durations[done:], workers)
    return f"{done} of {len(durations)} tables; {took_s / 3600.0:.2f} h passed, about {_hours(left_h)} h left"


def _sum_of_hours(durations: list[Duration], workers: int) -> float:
    """Return the sum of the hours that can be foretold."""
    return sum(hours for each in durations if not math.isnan(hours := each.hours(workers)))


def _hours(hours: float) -> str:
    return "?" if math.isnan(hours) else f"{hours:.2f}"
