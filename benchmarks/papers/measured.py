"""Experiments of papers that measure a camera and run no tracker: rows by seed, findings, table and page."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib
import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from benchmarks.commands.progress import progress_bar
from benchmarks.papers.claims import Claim, Finding, print_findings
from benchmarks.papers.page import write_page
from benchmarks.report.numbers import ranges_text
from benchmarks.report.pictures import read_pictures
from benchmarks.run.experiment import check_renderer, make_folder
from benchmarks.run.records import FILE_NAME, BlockKey, Row, append_block, read_blocks, read_rows, rounded, tidy
from benchmarks.run.versions import versions_of_modules
from benchmarks.scores.statistics import PooledRatios, bootstrap_interval
from scenarios import catalog
from scenarios.scenario import RendererName

SUITE, SCENARIO, TRACKER = "paper", "stereo-follow-v1", "none"
_UNIT = "1"

Values = Mapping[str, float | list[float]]


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
        return versions_of_modules(self.measure.__module__, type(catalog.scenario(SCENARIO)).__module__)

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
        _tidy(out)
        return read_rows(out)

    def _current(self, out: Path, seeds: range) -> set[BlockKey]:
        """Return the blocks that are there, made by the same code; other makings are moved out of the way."""
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
        current = {key for key, rows in blocks.items() if rows[0].get("versions") == self.versions}
        _tidy(out, blocks.keys() - current)
        return current

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
        print_findings(self.title, found, seeds)
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


def _tidy(out: Path, outdated: Collection[BlockKey] = ()) -> None:
    told = tidy(out, outdated)
    if told is not None:
        print(f"note: {told}", file=sys.stderr)


def mean_series(rows: Sequence[Row], metric: str) -> NDArray[np.float64]:
    """Return the mean over seeds of a series."""
    mean: NDArray[np.float64] = np.mean([row["value"] for row in rows if row["metric"] == metric], axis=0)
    return mean


def _finding(claim: Claim, renderer: str, rows: Sequence[Row]) -> Finding:
    values = np.array([row["value"] for row in rows], dtype=float)
    seeds = np.array([row["seed"] for row in rows])
    pool = PooledRatios(seeds, values[:, None], np.ones((len(values), 1)), _only)
    low, high = bootstrap_interval(pool)
    return Finding(claim, renderer, pool.mean, low, high, _UNIT, len(seeds))


def _only(ratios: NDArray[Any]) -> NDArray[Any]:
    only: NDArray[Any] = ratios[..., 0]
    return only
