"""Experiments of papers that measure a camera and run no tracker: rows by seed, findings, table and page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import joblib
import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.commands.progress import progress_bar
from benchmarks.experiment import check_renderer, make_folder
from benchmarks.papers.page import write_page
from benchmarks.records import (
    FILE_NAME,
    BlockKey,
    Row,
    append_block,
    read_blocks,
    rewrite,
    rounded,
)
from benchmarks.report.numbers import interval_text, number_text, ranges_text
from benchmarks.report.pictures import read_pictures
from benchmarks.statistics import PooledRatios, bootstrap_interval
from benchmarks.versions import versions_of_module
from scenarios.scenario import RendererName

SUITE, SCENARIO, TRACKER = "paper", "stereo-follow-v1", "none"

Values = Mapping[str, float | list[float]]


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says, and the number that it comes to here.

    Attributes:
        metric: of the rows. words: what the paper says. counted: what the number is.
        bound: which side of ``level`` agrees with the paper, by our choice; ``reported`` = the paper gives no side.
    """

    metric: str
    words: str
    counted: str
    bound: Literal["at most", "at least", "more than", "reported"]
    level: float = 0.0

    @property
    def expected(self) -> str:
        """Bound and level in words."""
        return "–" if self.bound == "reported" else f"{self.bound} {self.level:g}"


@dataclass(frozen=True, slots=True)
class Finding:
    """A claim and what came out: mean and 95 % interval over seeds."""

    claim: Claim
    renderer: str
    mean: float
    ci_low: float
    ci_high: float
    seeds: int

    @property
    def agrees(self) -> bool | None:
        """Whether the mean lies on the paper's side; None where there is no side."""
        level = self.claim.level
        sides = {"at most": self.mean <= level, "at least": self.mean >= level, "more than": self.mean > level}
        return sides.get(self.claim.bound)

    @property
    def value(self) -> str:
        """The mean in words."""
        return number_text(self.mean, "1")

    @property
    def interval(self) -> str:
        """The interval in words."""
        return interval_text(self.ci_low, self.ci_high, "1")


@dataclass(frozen=True, slots=True)
class MeasuredExperiment:
    """An experiment as the paper describes it.

    Attributes:
        name: what users type. title, setting: in words. preset: of the scenario.
        claims: what the paper says. notes: what a reader of the figures should know.
        measure: takes an episode's seed and renderer to the values of its rows.
    """

    name: str
    title: str
    setting: str
    preset: str
    claims: tuple[Claim, ...]
    notes: tuple[str, ...]
    measure: Callable[[int, RendererName], Values]

    @property
    def versions(self) -> dict[str, str]:
        """What its rows say of their making."""
        return versions_of_module(self.measure.__module__)

    def key(self, seed: int, renderer: RendererName) -> BlockKey:
        """Return what names the block of one seed."""
        return BlockKey(SUITE, SCENARIO, self.preset, renderer, "", TRACKER, seed)

    def block(self, seed: int, renderer: RendererName) -> list[Row]:
        """Return the rows of one seed."""
        values = self.measure(seed, renderer)
        heading: Row = {
            "suite": SUITE,
            "scenario": SCENARIO,
            "preset": self.preset,
            "tracker": TRACKER,
            "role": "measured",
            "controller": None,
            "renderer": renderer,
            "seed": seed,
            "repeat": 0,
        }
        ending = {"weight": 1.0, "frame_out": None, "seconds": None, "versions": self.versions}
        return [{**heading, "metric": metric, "value": rounded(value), **ending} for metric, value in values.items()]

    def run(self, out: Path, seeds: range, renderer: RendererName, workers: int) -> list[Row]:
        """Measure every seed that the folder does not hold yet and return its rows; those of the other renderer stay.

        The same call after a stop goes on where it stopped. Rows that other code made are made again.

        Raises:
            ValueError: for a folder that holds other rows, or cannot be written.
        """
        make_folder(out)
        have = self._current(out, seeds)
        missing = [seed for seed in seeds if self.key(seed, renderer) not in have]
        parallel = joblib.Parallel(n_jobs=max(workers, 1), return_as="generator_unordered")
        with progress_bar(f"paper {self.name}") as progress:
            progress(len(seeds) - len(missing), len(seeds))
            jobs = (joblib.delayed(self.block)(seed, renderer) for seed in missing)
            for done, block in enumerate(parallel(jobs), start=1):
                append_block(out, block)
                progress(len(seeds) - len(missing) + done, len(seeds))
        blocks = read_blocks(out)
        rewrite(out, blocks.values())
        return [row for block in blocks.values() for row in block]

    def _current(self, out: Path, seeds: range) -> set[BlockKey]:
        """Return the blocks that are there, made by the same code; other makings are removed."""
        if not (out / FILE_NAME).is_file():
            return set()
        blocks = read_blocks(out)
        for key in blocks:
            if key.seed not in seeds or key != self.key(key.seed, check_renderer(key.renderer)):
                wanted = f"rows of paper {self.name} with seeds {seeds.start}:{seeds.stop}"
                came = f"{key.suite} {key.preset}, seed {key.seed}"
                raise ValueError(
                    f"out: expected a folder with no rows but {wanted}, got {str(out)!r}, which has {came}"
                )
        current = {key: rows for key, rows in blocks.items() if rows[0]["versions"] == self.versions}
        if len(current) < len(blocks):
            rewrite(out, current.values())
        return set(current)

    def findings(self, rows: Sequence[Row]) -> list[Finding]:
        """Return what the rows say of each claim, for each renderer."""
        return [
            _finding(claim, renderer, [r for r in rows if (r["metric"], r["renderer"]) == (claim.metric, renderer)])
            for claim in self.claims
            for renderer in dict.fromkeys(row["renderer"] for row in rows)
        ]

    def publish(
        self,
        out: Path,
        rows: Sequence[Row],
        seeds: range,
        renderer: RendererName,
        plots_title: str,
        plots: Mapping[str, str],
    ) -> None:
        """Print the table of findings and write the page: it, plots (SVG by heading) and the folder's pictures."""
        found = self.findings(rows)
        _print(self.title, found, seeds)
        again = "" if renderer == "raster" else f" --renderer {renderer}"
        write_page(
            out,
            "measured.html.jinja",
            experiment=self,
            findings=found,
            plots_title=plots_title,
            plots={heading: Markup(plot) for heading, plot in plots.items()},
            pictures=read_pictures(out),
            seeds=ranges_text(seeds),
            command=f"frameout paper {self.name} --seeds {seeds.start}:{seeds.stop}{again}",
        )


def mean_series(rows: Sequence[Row], metric: str) -> NDArray[np.float64]:
    """Return the mean over seeds of a series."""
    mean: NDArray[np.float64] = np.mean([row["value"] for row in rows if row["metric"] == metric], axis=0)
    return mean


def _finding(claim: Claim, renderer: str, rows: Sequence[Row]) -> Finding:
    values = np.array([row["value"] for row in rows], dtype=float)
    seeds = np.array([row["seed"] for row in rows])
    pool = PooledRatios(seeds, values[:, None], np.ones((len(values), 1)), _only)
    low, high = bootstrap_interval(pool)
    return Finding(claim, renderer, pool.mean, low, high, len(seeds))


def _only(ratios: NDArray[Any]) -> NDArray[Any]:
    only: NDArray[Any] = ratios[..., 0]
    return only


def _print(title: str, found: Sequence[Finding], seeds: range) -> None:
    table = Table(title=f"{title}: seeds {ranges_text(seeds)}, 95 % intervals over them")
    for head in ("the paper", "here", "renderer", "value", "interval", "expected"):
        table.add_column(head)
    for each in found:
        claim = each.claim
        verdict = {True: ": yes", False: ": NO", None: ""}[each.agrees]
        expected = f"{claim.expected}{verdict}"
        table.add_row(claim.words, claim.counted, each.renderer, each.value, each.interval, expected)
    console = Console()
    (console if console.is_terminal else Console(width=118)).print(table)
