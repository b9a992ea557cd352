"""Repeat a paper's experiment over many episodes, and set what came out beside what the paper says."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.commands.progress import progress_bar
from benchmarks.papers.claims import Claim, Finding, print_findings
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.papers.figure import paper_figure
from benchmarks.papers.page import write_page
from benchmarks.report.numbers import ranges_text
from benchmarks.report.pictures import Picture, read_pictures
from benchmarks.run.experiment import Experiment
from benchmarks.run.experiment import run as run_experiment
from benchmarks.run.records import read_rows
from benchmarks.scores.summary import grouped
from benchmarks.suites.registry import suite
from scenarios.scenario import RendererName


def repeat(experiment: PaperExperiment, out: Path, seeds: range, renderer: RendererName, workers: int) -> list[Finding]:
    """Run the experiment, print what came out beside the paper's words, write rows, pictures and page.

    A folder that already holds rows of the other renderer keeps them; the table then shows both.
    """
    runs = Experiment(
        suite=experiment.suite,
        scenario=suite(experiment.suite).scenes[0].scenario,
        presets=(experiment.preset,),
        trackers=experiment.trackers,
        seeds=seeds,
        renderer=renderer,
        workers=workers,
        settings=experiment.settings,
    )
    with progress_bar(f"paper {experiment.name}") as progress:
        outcome = run_experiment(runs, out, progress)
    for told in outcome.moved:
        print(f"note: {told}", file=sys.stderr)
    found = findings(experiment, outcome.summary)
    picture = _picture(experiment, out, seeds, renderer)
    print_findings(experiment.title, found, seeds)
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


def _picture(experiment: PaperExperiment, out: Path, seeds: range, renderer: RendererName) -> Picture | None:
    """Return the paper's figure; where the paper names no frames, what the suite shows of a result."""
    if experiment.frames:
        return paper_figure(experiment, out, seeds.start, renderer)
    judged = suite(experiment.suite)
    for condition, trackers in grouped(read_rows(out)).items():
        if (condition[2], condition[3]) == (experiment.preset, renderer):
            judged.picture(out, condition, trackers, experiment.trackers)
            return next((picture for picture in read_pictures(out) if picture.condition == condition), None)
    return None


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
        return Finding(claim, renderer, None, None, None, "fraction", 0)
    return Finding(
        claim=claim,
        renderer=renderer,
        mean=entry["mean"],
        ci_low=entry["ci_low"],
        ci_high=entry["ci_high"],
        unit=entry["unit"],
        episodes=entry["n"],
    )
