"""Experiments of papers that measure a camera and run no tracker: rows by seed, findings, table and page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import joblib
import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.commands.progress import progress_bar
from benchmarks.experiment import make_folder
from benchmarks.records import FILE_NAME, LAST_METRIC, Row, read_blocks, rewrite, rounded, write_beside
from benchmarks.report.numbers import interval_text, number_text, ranges_text
from benchmarks.report.page import page_style
from benchmarks.report.pictures import read_pictures
from benchmarks.statistics import PooledRatios, bootstrap_interval
from benchmarks.versions import versions_of_scene
from scenarios.scenario import RendererName

SCENARIO = "stereo-follow-v1"
PAGE_FILE_NAME = "paper.html"

Values = Mapping[str, float | list[float]]


@dataclass(frozen=True, slots=True)
class Claim:
    """What the paper says, and the number that it comes to here.

    Attributes:
        metric: of the rows. words: what the paper says. counted: what the number is.
        bound: which side of ``level`` agrees with the paper.
    """

    metric: str
    words: str
    counted: str
    bound: Literal["at most", "at least", "more than"]
    level: float

    def agrees(self, mean: float) -> bool:
        """Say whether a mean lies on the paper's side."""
        if self.bound == "at most":
            return mean <= self.level
        return mean >= self.level if self.bound == "at least" else mean > self.level


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
    def agrees(self) -> bool:
        """Whether the mean lies on the paper's side."""
        return self.claim.agrees(self.mean)

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
        claims: what the paper says.
        measure: takes an episode's seed and renderer to the values of its rows.
    """

    name: str
    title: str
    setting: str
    preset: str
    claims: tuple[Claim, ...]
    measure: Callable[[int, RendererName], Values]

    def block(self, seed: int, renderer: RendererName) -> list[Row]:
        """Return the rows of one seed."""
        values = self.measure(seed, renderer)
        heading: Row = {
            "suite": "stereo",
            "scenario": SCENARIO,
            "preset": self.preset,
            "tracker": "stereo_wb_shutter_gain",
            "role": "as-written",
            "controller": None,
            "renderer": renderer,
            "seed": seed,
            "repeat": 0,
        }
        ending = {"weight": 1.0, "frame_out": None, "seconds": None, "versions": versions_of_scene()}
        return [{**heading, "metric": metric, "value": rounded(value), **ending} for metric, value in values.items()]

    def run(self, out: Path, seeds: range, renderer: RendererName, workers: int) -> list[Row]:
        """Measure every seed and return the folder's rows. Rows of the other renderer that it held already stay."""
        make_folder(out)
        blocks = _other_blocks(out, renderer)
        parallel = joblib.Parallel(n_jobs=max(workers, 1), return_as="generator")
        with progress_bar(f"paper {self.name}") as progress:
            progress(0, len(seeds))
            for done, block in enumerate(parallel(joblib.delayed(self.block)(seed, renderer) for seed in seeds)):
                blocks.append(block)
                progress(done + 1, len(seeds))
        rewrite(out, blocks)
        return [row for block in blocks for row in block]

    def findings(self, rows: Sequence[Row]) -> list[Finding]:
        """Return what the rows say of each claim, for each renderer."""
        return [
            _finding(claim, renderer, [r for r in rows if (r["metric"], r["renderer"]) == (claim.metric, renderer)])
            for claim in self.claims
            for renderer in dict.fromkeys(row["renderer"] for row in rows)
        ]

    def publish(self, out: Path, rows: Sequence[Row], seeds: range, plots_title: str, plots: Mapping[str, str]) -> None:
        """Print the table of findings and write the page: it, plots (SVG by heading) and the folder's pictures."""
        found = self.findings(rows)
        _print(self.title, found, seeds)
        path = out / PAGE_FILE_NAME
        write_beside(path, _page(self, found, out, seeds, plots_title, plots))
        print(f"page: {path}")


def frames_value(count: int) -> dict[str, float | list[float]]:
    """Return what ends a block: the number of frames."""
    return {LAST_METRIC: float(count)}


def mean_series(rows: Sequence[Row], metric: str) -> NDArray[np.float64]:
    """Return the mean over seeds of a series."""
    mean: NDArray[np.float64] = np.mean([row["value"] for row in rows if row["metric"] == metric], axis=0)
    return mean


def _other_blocks(out: Path, renderer: RendererName) -> list[list[Row]]:
    if not (out / FILE_NAME).is_file():
        return []
    return [rows for key, rows in read_blocks(out).items() if key.renderer != renderer]


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
        expected = f"{claim.bound} {claim.level:g}: {'yes' if each.agrees else 'NO'}"
        table.add_row(claim.words, claim.counted, each.renderer, each.value, each.interval, expected)
    console = Console()
    (console if console.is_terminal else Console(width=118)).print(table)


def _page(
    experiment: MeasuredExperiment,
    found: Sequence[Finding],
    out: Path,
    seeds: range,
    plots_title: str,
    plots: Mapping[str, str],
) -> str:
    environment = Environment(
        loader=PackageLoader("benchmarks", "papers"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("measured.html.jinja").render(
        experiment=experiment,
        findings=found,
        plots_title=plots_title,
        plots={heading: Markup(plot) for heading, plot in plots.items()},
        pictures=read_pictures(out),
        seeds=ranges_text(seeds),
        command=f"frameout paper {experiment.name} --seeds {seeds.start}:{seeds.stop}",
        style=Markup(page_style()),
    )
