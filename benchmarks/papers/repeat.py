"""Repeats a paper's experiment over many episodes and compares the results with the paper's."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup

from benchmarks.contract.rows import Row
from benchmarks.contract.text import ranges_text
from benchmarks.papers.claims import Claim, Finding, print_findings, print_matrix
from benchmarks.papers.experiment import PaperExperiment
from benchmarks.papers.robustness import print_sensitivity
from benchmarks.run.outcome import WHY_MOVED
from benchmarks.show.page import page_environment, page_style
from benchmarks.show.pictures import read_pictures
from benchmarks.show.progress import progress_bar
from benchmarks.statistics.bootstrap import bootstrap_interval
from benchmarks.statistics.summary import paired
from scenarios.scenario import RendererName
from trackers.atomic_file import write_atomic
from trackers.papers import PAPERS

_FILE_NAME = "paper.html"


def repeat(experiment: PaperExperiment, out: Path, seeds: range, renderer: RendererName, workers: int) -> list[Finding]:
    """Run the experiment, print findings beside the paper's claims, write rows, pictures and ``out/paper.html``.

    Rows of the other renderer in the folder stay; the table then shows both.

    Args:
        out: folder; a second call with the same arguments resumes.
        seeds: episodes to run; 10,000 to 19,999 are the test split.
        workers: processes.
    """
    with progress_bar(f"paper {experiment.name}") as progress:
        moved = experiment.run(out, seeds, renderer, workers, progress)
    for message in moved:
        print(f"note: {message} ({WHY_MOVED})", file=sys.stderr)
    rows = experiment.rows_in(out)
    found = findings(experiment, rows)
    plots = experiment.show(out, rows, seeds, renderer)
    paper = PAPERS[experiment.name[0]]
    print(f"{paper.name}, {paper.about}. {paper.reference()}")
    print_findings(experiment.title, found, seeds, experiment.fitted)
    varied = experiment.sensitivity(out, rows, seeds, renderer)
    if varied is not None:
        print_sensitivity(varied)
    matrix = experiment.matrix(seeds, renderer)
    if matrix is not None:
        print_matrix(matrix)
    again = "" if renderer == "raster" else f" --renderer {renderer}"
    page = (
        page_environment(__file__)
        .get_template("paper.html.jinja")
        .render(
            style=Markup(page_style()),
            experiment=experiment,
            paper=paper,
            findings=found,
            runs_trackers=any(each.claim.tracker for each in found),
            plots=plots,
            matrix=matrix,
            varied=varied,
            pictures=read_pictures(out),
            seeds=ranges_text(seeds),
            one_seed=len(seeds) == 1,
            command=f"frameout paper {experiment.name} --seeds {seeds.start}:{seeds.stop}{again}",
        )
    )
    write_atomic(out / _FILE_NAME, page)
    print(f"page: {out / _FILE_NAME}")
    return found


def findings(experiment: PaperExperiment, rows: Sequence[Row]) -> list[Finding]:
    """Return the findings of each line of the table, for each renderer."""
    renderers = dict.fromkeys(row["renderer"] for row in rows)
    return [_finding(experiment, claim, renderer, rows) for claim in experiment.shown_claims for renderer in renderers]


def _finding(experiment: PaperExperiment, claim: Claim, renderer: str, rows: Sequence[Row]) -> Finding:
    metric = experiment.metric(claim.metric)
    preset = claim.preset or experiment.preset
    drawn = [row for row in rows if row["renderer"] == renderer and row["preset"] == preset]
    mine = [row for row in drawn if claim.tracker in ("", row["tracker"])]
    if claim.minus:
        found = paired(mine, [row for row in drawn if row["tracker"] == claim.minus], metric)
        if found is None:
            return Finding(claim, renderer, None, None, None, metric.unit, 0)
        return Finding(claim, renderer, found.difference, found.ci_low, found.ci_high, metric.unit, found.n)
    pool = metric.statistic.pooled(mine)
    if pool is None or pool.seed_count == 0:
        return Finding(claim, renderer, None, None, None, metric.unit, 0)
    return Finding(claim, renderer, pool.mean, *bootstrap_interval(pool), metric.unit, pool.seed_count)
