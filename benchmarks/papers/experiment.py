"""A paper's experiment: setting, runs, claims and figure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import Row, read_rows
from benchmarks.contract.suite import Condition
from benchmarks.papers.claims import Claim, Matrix
from benchmarks.papers.robustness import Sensitivity
from benchmarks.run.experiment import Progress
from benchmarks.run.result_folder import MadeNow
from benchmarks.show.pictures import write_picture
from scenarios.scenario import RendererName


class Plots(NamedTuple):
    """Plots under one title: heading → SVG."""

    title: str
    svgs: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperExperiment(ABC):
    """An experiment as the paper describes it.

    Attributes:
        name: of the command's argument. title, setting: in words.
        fitted: what of scene and method was set so that results agree with the paper's, in words; "" for nothing.
        suite: of the rows. scenario: catalogue id. preset: of the scenario.
        claims: of the paper. notes: on the figures.
        controller: steers by the estimate; None on a set path.
        seeds: default seeds of the episodes.
    """

    name: str
    title: str
    setting: str
    suite: str
    scenario: str
    preset: str
    claims: tuple[Claim, ...]
    fitted: str = ""
    notes: tuple[str, ...] = ()
    controller: str | None = None
    seeds: range = range(10_000, 10_050)

    @property
    def presets(self) -> tuple[str, ...]:
        """Presets of the episodes, the paper's first."""
        return (self.preset,)

    @property
    @abstractmethod
    def contestants(self) -> tuple[str, ...]:
        """All trackers of the rows."""

    @property
    def shown_claims(self) -> tuple[Claim, ...]:
        """Lines of the table: the paper's claims, and what else is counted beside them."""
        return self.claims

    @abstractmethod
    def metric(self, name: str) -> Metric:
        """Return a claim's metric."""

    @abstractmethod
    def run(self, out: Path, seeds: range, renderer: RendererName, workers: int, progress: Progress) -> list[str]:
        """Write the rows that ``out`` lacks; return messages about rows that were moved to another file.

        The same call after a stop continues. Rows of other editions are made again; those of the other renderer stay.

        Raises:
            ValueError: for a folder that holds rows of other seeds or cannot be written.
        """

    @abstractmethod
    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Plots | None:
        """Write the paper's figure to ``out``, and return plots of the rows, if there are any."""

    @abstractmethod
    def made_now(self, renderer: RendererName) -> MadeNow:
        """Return what tells the current ``editions`` of the rows of ``run``."""

    def matrix(self, seeds: range, renderer: RendererName) -> Matrix | None:
        """Return a matrix measured on the episodes of ``seeds``, for experiments that have one."""
        return None

    def sensitivity(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> Sensitivity | None:
        """Return how the figures depend on what was fitted, for experiments in which that was measured."""
        return None

    def rows_in(self, out: Path) -> list[Row]:
        """Return the experiment's rows in a folder, of all renderers."""
        mine = {(self.suite, self.scenario, preset, self.controller) for preset in self.presets}
        keys = ("suite", "scenario", "preset", "controller")
        return [row for row in read_rows(out) if tuple(row[key] for key in keys) in mine]

    def condition(self, renderer: str) -> Condition:
        """Return the condition of the rows of one renderer."""
        return self.suite, self.scenario, self.preset, renderer, self.controller or ""

    def write_figure(
        self,
        out: Path,
        image_rgb: NDArray[np.uint8],
        seed: int,
        renderer: RendererName,
        name: str,
        caption: str,
        part: str = "",
    ) -> None:
        """Write our version (H, W, 3) of one of the paper's figures; ``part`` tells several of one page apart."""
        title = f"The paper's {name}, in this world"
        file = "-".join(filter(None, (self.preset, part, renderer)))
        write_picture(out, file, image_rgb, self.condition(renderer), title, caption, f"seed {seed}")
