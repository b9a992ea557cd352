"""``frameout report``: make the report of a result folder again from its rows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import NAMES
from benchmarks.commands.ignored_rows import report_ignored_rows
from benchmarks.commands.leaderboard import print_leaderboard
from benchmarks.report.page import write_report
from benchmarks.run.contestants import load_modules
from benchmarks.scores.summary import write_summary


@dataclass(frozen=True)
class Report:
    """Make summary.json, comparisons.json and report.html of a result folder again, from its records.jsonl.

    Attributes:
        directory: folder written by `frameout bench`.
        markdown: also print the leaderboard as a Markdown table.
        modules: your own Python modules, imported first; they register the suite of the rows, its scenario and so on.
    """

    directory: Annotated[Path, tyro.conf.Positional]
    markdown: bool = False
    modules: Annotated[tuple[str, ...], NAMES] = ()
    resumes = False

    def run(self) -> int:
        """Write them; return the exit status."""
        load_modules(self.modules)
        summary = write_summary(self.directory)
        report_ignored_rows(self.directory)
        if self.markdown:
            print_leaderboard(summary, markdown=True)
        print(write_report(self.directory))
        return 0
