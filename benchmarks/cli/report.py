"""``frameout report``: make the report of a result folder again from its rows."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import FOLDER, WORKERS, Names, WithModules, report_ignored_rows
from benchmarks.cli.leaderboard import print_by_episode, print_leaderboard
from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import check_metrics
from benchmarks.contract.text import counted
from benchmarks.run.packages import needs_data
from benchmarks.run.workers import cores
from benchmarks.show.page import write_report
from benchmarks.show.progress import progress_bar
from benchmarks.statistics.summary import grouped, write_summary
from sim.checks import check


@dataclass(frozen=True)
class Report(WithModules):
    """Make summary.json, comparisons.json and report.html of a result folder again, from its records.jsonl.

    With --from-estimates the rows in records.jsonl are first made again from the kept answers, without running a
    tracker; they differ from those of the run only where the judge has changed since.

    Attributes:
        directory: folder written by `frameout bench`.
        from_estimates: judge what `frameout bench --keep-estimates` kept (`frameout[data]`); the episodes are
            simulated again.
        data: with --from-estimates, folder or URL of a data set with the episodes, which are then not simulated.
        workers: with --from-estimates, number of worker processes; 0 = this process.
        markdown: also print the leaderboard as a Markdown table.
        by_episode: also print, in Markdown, the metric that ranks of each episode or real sequence, a column for each
            tracker.
        metric: names of the metrics on the leaderboard, see `frameout list --metrics`; the first one ranks (default:
            the suite's own).
    """

    directory: Annotated[Path, tyro.conf.Positional]
    from_estimates: bool = False
    data: Annotated[str | None, FOLDER] = None
    workers: Annotated[int | None, WORKERS] = None
    markdown: bool = False
    by_episode: bool = False
    metric: Names = ()
    resumes = False

    def run(self) -> int:
        """Write them; return the exit status."""
        check("data", self.data is None or self.from_estimates, "none without --from-estimates", repr(self.data))
        if self.from_estimates:
            self._rejudge()
        report_ignored_rows(self.directory, self.modules)
        summary = write_summary(self.directory)
        check_metrics(self.metric, sorted({entry["suite"] for entry in summary}))
        if self.markdown:
            print_leaderboard(summary, self.metric, rows=read_rows(self.directory), markdown=True)
        if self.by_episode:
            print_by_episode(grouped(read_rows(self.directory)), self.metric)
        from benchmarks.data.real import reopened  # It imports the readers of all layouts.

        print(write_report(self.directory, self.metric, reopened, progress_bar))
        return 0

    def _rejudge(self) -> None:
        needs_data()
        from benchmarks.data.estimates.rejudging import rejudge

        with progress_bar("estimates, judged again") as progress:
            done = rejudge(self.directory, self.data, cores(self.workers), self.modules, progress)
        blocks = f"{counted(done.same, 'episode')} with the same rows, {counted(done.new, 'episode')} with new ones"
        print(f"note: judged again: {blocks}", file=sys.stderr)
        if done.moved is not None:
            print(f"note: {done.moved}", file=sys.stderr)
