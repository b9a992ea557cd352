"""Paper experiment D: intruders in a harbour, found by sets of particles on a background of eigenspaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.contract.metric import Metric, Quantity
from benchmarks.contract.rows import Row
from benchmarks.contract.suite import suite
from benchmarks.papers.experiment import Plots
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.statistics.pooling import Median
from scenarios.scenario import RendererName


@dataclass(frozen=True, slots=True, kw_only=True)
class HarbourExperiment(TrackerExperiment):
    """See ``TrackerExperiment``. Sizes are those of the tracks that the paper counts."""

    def metric(self, name: str) -> Metric:
        """See ``PaperExperiment``: a metric of the suite, or the median size of a class, ``region_width_m person``."""
        row, _, kind = name.partition(" ")
        if kind:
            return Metric(name, f"{row} of class {kind}", "m", "lower", Median(Quantity(row), kind=kind))
        return suite(self.suite).metric(name)

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots:
        """See ``PaperExperiment``: one visit with both methods, and the suite's figures."""
        TrackerExperiment.show(self, out, rows, seeds, renderer)
        return self.suite_figures("What the paper could not measure", rows, renderer)
