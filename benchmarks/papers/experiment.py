"""What a paper's experiment is: its setting, what is run, its claims, its figure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.papers.claims import Claim
from benchmarks.report.pictures import write_picture
from benchmarks.run.experiment import Progress
from benchmarks.run.records import Row, read_rows
from benchmarks.suites.registry import Condition, Metric
from scenarios.scenario import RendererName


class Plots(NamedTuple):
    """Plots under one title: heading → SVG."""

    title: str
    svgs: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperExperiment(ABC):
    """An experiment as the paper describes it.

    Attributes:
        name: what users type. title, setting: in words.
        suite: of the rows. scenario: catalogue id. preset: of the scenario.
        claims: what the paper says. notes: what a reader of the figures should know.
        controller: steers by the estimate; None on a set path.
        seeds: of the episodes if users name none.
    """

    name: str
    title: str
    setting: str
    suite: str
    scenario: str
    preset: str
    claims: tuple[Claim, ...]
    notes: tuple[str, ...] = ()
    controller: str | None = None
    seeds: range = range(10_000, 10_050)

    @abstractmethod
    def metric(self, name: str) -> Metric:
        """Return how a claim's metric is made from rows."""

    @abstractmethod
    def run(self, out: Path, seeds: range, renderer: RendererName, workers: int, progress: Progress) -> list[str]:
        """Write the rows that ``out`` does not hold yet; return lines that say which rows were moved, and where to.

        The same call after a stop goes on where it stopped. Rows that other code made are made again; those of the
        other renderer stay.

        Raises:
            ValueError: for a folder that holds other seeds' rows or cannot be written.
        """

    @abstractmethod
    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots | None:
        """Write the paper's figure beside the rows, and return plots of them, if there are any."""

    def rows_in(self, out: Path) -> list[Row]:
        """Return the experiment's own rows of a folder, of all renderers."""
        keys = ("suite", "scenario", "preset", "renderer", "controller")
        return [row for row in read_rows(out) if tuple(row[k] or "" for k in keys) == self.condition(row["renderer"])]

    def condition(self, renderer: str) -> Condition:
        """Return the condition of the rows that one renderer drew."""
        return self.suite, self.scenario, self.preset, renderer, self.controller or ""

    def write_figure(
        self, out: Path, image_rgb: NDArray[np.uint8], seed: int, renderer: RendererName, name: str, caption: str
    ) -> None:
        """Write one of the paper's figures (H, W, 3), as it is in our world."""
        title = f"The paper's {name}, in this world"
        write_picture(
            out, f"{self.preset}-{renderer}", image_rgb, self.condition(renderer), title, caption, f"seed {seed}"
        )
