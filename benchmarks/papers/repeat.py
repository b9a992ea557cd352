"""Repeat a paper's experiment over many episodes, and set what came out beside what the paper says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.commands.progress import progress_bar
from benchmarks.experiment import Experiment
from benchmarks.experiment import run as run_experiment
from benchmarks.papers.experiment import Claim, PaperExperiment
from benchmarks.papers.figure import paper_figure
from benchmarks.papers.page import write_page
from benchmarks.report.numbers import interval_text, number_text, ranges_text
from scenarios.scenario import RendererName

_SUITE = "frame-out"


@dataclass(frozen=True, slots=True)
class Finding:
    """A claim and what came out, with one renderer.

    Attributes:
        value, interval: in words. episodes: that say something of it.
        agrees: whether the mean lies on the paper's side.
    """

    claim: Claim
    renderer: str
    value: str
    interval: str
    episodes: int
    agrees: bool


def repeat(experiment: PaperExperiment, out: Path, seeds: range, renderer: RendererName, workers: int) -> list[Finding]:
    """Run the experiment, print what came out beside the paper's words, write rows, pictures and page.

    A folder that already holds rows of the other renderer keeps them; the table then shows both.
    """
    runs = Experiment(
        suite=_SUITE,
        scenario="road-town",
        presets=(experiment.preset,),
        trackers=experiment.trackers,
        seeds=seeds,
        renderer=renderer,
        workers=workers,
        settings=experiment.settings,
    )
    with progress_bar(f"paper {experiment.name}") as progress:
        outcome = run_experiment(runs, out, progress)
    found = findings(experiment, outcome.summary)
    picture = paper_figure(experiment, out, seeds.start, renderer)
    _print(experiment, found, seeds)
    again = "" if renderer == "raster" else f" --renderer {renderer}"
    write_page(
        out,
        "paper.html.jinja",
        experiment=experiment,
        findings=found,
        picture=picture,
        seeds=ranges_text(seeds),
        command=f"frameout paper {experiment.name} --seeds {seeds.start}:{seeds.stop}{again}",
    )
    return found


def findings(experiment: PaperExperiment, summary: Sequence[dict[str, Any]]) -> list[Finding]:
    """Return what the summary says of each claim, for each renderer that it holds."""
    mine = [entry for entry in summary if entry["preset"] == experiment.preset]
    said = {(entry["renderer"], entry["tracker"], entry["metric"]): entry for entry in mine}
    renderers = dict.fromkeys(entry["renderer"] for entry in mine)
    return [
        _finding(claim, renderer, said.get((renderer, claim.tracker, claim.metric)))
        for claim in experiment.claims
        for renderer in renderers
    ]


def _finding(claim: Claim, renderer: str, entry: dict[str, Any] | None) -> Finding:
    if entry is None:
        return Finding(claim, renderer, "–", "", 0, agrees=False)
    mean = entry["mean"]
    agrees = mean is not None and (mean <= claim.level if claim.bound == "at most" else mean >= claim.level)
    return Finding(
        claim=claim,
        renderer=renderer,
        value=number_text(mean, entry["unit"]),
        interval=interval_text(entry["ci_low"], entry["ci_high"], entry["unit"]),
        episodes=entry["n"],
        agrees=agrees,
    )


def _print(experiment: PaperExperiment, found: Sequence[Finding], seeds: range) -> None:
    table = Table(title=f"{experiment.title}: seeds {ranges_text(seeds)}, 95 % intervals over them")
    for head in ("method", "the paper", "here", "renderer", "%", "interval", "expected"):
        table.add_column(head)
    for each in found:
        claim = each.claim
        expected = f"{claim.bound} {100 * claim.level:g}: {'yes' if each.agrees else 'NO'}"
        table.add_row(claim.tracker, claim.words, claim.counted, each.renderer, each.value, each.interval, expected)
    console = Console()
    (console if console.is_terminal else Console(width=118)).print(table)
