"""The results in a folder, for notebooks and scripts: tables, and plots of the report."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.contract.rows import FILE_NAME, read_rows
from benchmarks.contract.text import counted
from benchmarks.run.outcome import Outcome
from benchmarks.show import long_table
from benchmarks.statistics.summary import COMPARISONS_FILE_NAME, SUMMARY_FILE_NAME, write_summary
from sim.checks import check

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from benchmarks.show.figures import ReportFigure


class Results:
    """What a bench left in a folder; every call reads it anew.

    Attributes:
        directory: the folder.
        outcome: of the run that returned it: failures, frames without an answer; empty for a folder that was opened.
    """

    def __init__(self, directory: Path | str, outcome: Outcome | None = None) -> None:
        """Open a folder. Raises ValueError if it holds no results."""
        self.directory = Path(directory)
        self.outcome = Outcome() if outcome is None else outcome
        there = (self.directory / FILE_NAME).is_file()
        check("directory", there, f"one that holds {FILE_NAME}", repr(str(directory)))

    def __repr__(self) -> str:
        failed = f", {counted(len(self.outcome.failures), 'failure')}" if self.outcome.failures else ""
        return f"Results({str(self.directory)!r}{failed})"

    def rows(self) -> pd.DataFrame:
        """Return all numbers, a line for each condition, seed, tracker, event and metric, see ``long_table``."""
        return long_table.numbers_table(read_rows(self.directory))

    def lists(self) -> pd.DataFrame:
        """Return all lists, e.g. the error on each frame outside, a line for each entry, see ``long_table``."""
        return long_table.lists_table(read_rows(self.directory))

    def summary(self) -> pd.DataFrame:
        """Return means with 95 % intervals, a line for each condition, tracker and metric, see ``scores.summary``."""
        return self._read(SUMMARY_FILE_NAME)

    def comparisons(self) -> pd.DataFrame:
        """Return paired differences of ours and each other tracker, see ``scores.summary``."""
        return self._read(COMPARISONS_FILE_NAME)

    def plot(self, metric: str) -> Figure:
        """Return a figure of a metric of the summary: a dot with its 95 % interval for each contestant, the best above.

        Raises:
            ValueError: for a metric that no contestant has; lists those that there are.
        """
        from benchmarks.show.metric_plot import metric_figure

        return metric_figure(self._entries(SUMMARY_FILE_NAME), metric)

    def figures(self) -> list[ReportFigure]:
        """Return the plots of the report, condition by condition; a notebook shows each as a picture."""
        from benchmarks.show.page import figures_of

        return figures_of(read_rows(self.directory), self._entries(SUMMARY_FILE_NAME))

    def _read(self, name: str) -> pd.DataFrame:
        import pandas as pd

        return pd.DataFrame(self._entries(name))

    def _entries(self, name: str) -> list[dict[str, Any]]:
        if not (self.directory / name).is_file():
            write_summary(self.directory)
        entries: list[dict[str, Any]] = json.loads((self.directory / name).read_text())
        return entries
