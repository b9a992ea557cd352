"""Repeat a paper's experiment over many episodes, and set what came out beside what the paper says."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.commands.progress import progress_bar
from benchmarks.papers.claims import Claim, Finding, print_findings
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.report.numbers import ranges_text
from benchmarks.report.page import page_style
from benchmarks.report.pictures import read_pictures
from benchmarks.run.records import Row
from benchmarks.scores.pooling import pooled
from benchmarks.scores.statistics import bootstrap_interval
from scenarios.scenario import RendererName
from trackers.atomic_file import write_atomic

_FILE_NAME = "paper.html"


def repeat(experiment: PaperExperiment, out: Path, seeds: range, renderer: RendererName, workers: int) -> list[Finding]:
    """Run the experiment, print what came out beside the paper's words, write rows, pictures and ``out/paper.html``.

    A folder that already holds rows of the other renderer keeps them; the table then shows both.

    Args:
        out: folder; a second call with the same arguments resumes.
        seeds: episodes to run; 10,000 to 19,999 are the test split.
        workers: processes.
    """
    with progress_bar(f"paper {experiment.name}") as progress:
        moved = experiment.run(out, seeds, renderer, workers, progress)
    for told in moved:
        print(f"note: {told}", file=sys.stderr)
    rows = experiment.rows_in(out)
    found = findings(experiment, rows)
    plots = experiment.show(out, rows, seeds, renderer)
    print_findings(experiment.title, found, seeds)
    environment = Environment(
        loader=PackageLoader("benchmarks", "papers"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    again = "" if renderer == "raster" else f" --renderer {renderer}"
    page = environment.get_template("paper.html.jinja").render(
        style=Markup(page_style()),
        experiment=experiment,
        findings=found,
        runs_trackers=any(claim.tracker for claim in experiment.claims),
        plots=plots,
        pictures=read_pictures(out),
        seeds=ranges_text(seeds),
        command=f"frameout paper {experiment.name} --seeds {seeds.start}:{seeds.stop}{again}",
    )
    write_atomic(out / _FILE_NAME, page)
    print(f"page: {out / _FILE_NAME}")
    return found


def findings(experiment: PaperExperiment, rows: Sequence[Row]) -> list[Finding]:
    """Return what the experiment's rows say of each claim, for each renderer."""
    renderers = dict.fromkeys(row["renderer"] for row in rows)
    return [_finding(experiment, claim, renderer, rows) for claim in experiment.claims for renderer in renderers]


def _finding(experiment: PaperExperiment, claim: Claim, renderer: str, rows: Sequence[Row]) -> Finding:
    metric = experiment.metric(claim.metric)
    mine = [row for row in rows if row["renderer"] == renderer and claim.tracker in ("", row["tracker"])]
    pool = pooled(mine, metric)
    if pool is None or pool.seed_count == 0:
        return Finding(claim, renderer, None, None, None, metric.unit, 0)
    return Finding(claim, renderer, pool.mean, *bootstrap_interval(pool), metric.unit, pool.seed_count)
