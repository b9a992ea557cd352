"""Repeats a paper's experiment over many episodes and compares the results with the paper's."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup
from rich import box
from rich.table import Table

from benchmarks.contract.text import ranges_text
from benchmarks.papers.experiment import Finding, PaperExperiment, TextTable, findings
from benchmarks.run.outcome import WHY_MOVED
from benchmarks.show.page import page_environment, page_style
from benchmarks.show.pictures import read_pictures
from benchmarks.show.progress import console_of, progress_bar
from scenarios.scenario import RendererName
from trackers.atomic_file import write_atomic
from trackers.papers import PAPERS

_FILE_NAME = "paper.html"


def repeat(experiment: PaperExperiment, out: Path, seeds: range, renderer: RendererName, workers: int) -> list[Finding]:
    """Run the experiment, print findings beside the paper's claims, write rows, pictures and ``out/paper.html``.

    Rows of the other renderer in the folder stay; the page shows one.

    Args:
        out: folder; a second call with the same arguments resumes.
        seeds: episodes to run; 10,000 to 19,999 are the test split.
        workers: processes.
    """
    with progress_bar(f"paper {experiment.name}") as progress:
        moved = experiment.run(out, seeds, renderer, workers, progress)
    for message in moved:
        print(f"note: {message} ({WHY_MOVED})", file=sys.stderr)
    rows = experiment.rows_in(out, renderer)
    found = findings(experiment, rows)
    plots = experiment.show(out, rows, seeds, renderer)
    paper = PAPERS[experiment.name[0]]
    print(f"{paper.name}, {paper.about}. {paper.reference()}")
    print_table(table_of_findings(experiment, found, seeds, renderer))
    varied = experiment.sensitivity(out, rows, seeds, renderer)
    if varied is not None:
        print_table(varied)
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
            varied=varied,
            pictures=read_pictures(out),
            seeds=ranges_text(seeds),
            renderer=renderer,
            one_seed=len(seeds) == 1,
            command=f"frameout paper {experiment.name} --seeds {seeds.start}:{seeds.stop}{again}",
        )
    )
    write_atomic(out / _FILE_NAME, page)
    print(f"page: {out / _FILE_NAME}")
    return found


def table_of_findings(experiment: PaperExperiment, found: Sequence[Finding], seeds: range, renderer: str) -> TextTable:
    """Return our findings beside the paper's claims, those against a fitted figure marked, and what was fitted."""
    several = len(seeds) > 1
    over = "seeds {}, 95 % intervals over them" if several else "seed {}, which decides nothing"
    rows = []
    for each in found:
        claim = each.claim
        verdict = {True: ": yes", False: ": NO", None: ""}[each.agrees] if several else ""
        expected = f"{each.expected}{verdict}{' (fitted)' if claim.fitted else ''}"
        rows.append((claim.tracker, claim.words, claim.counted, each.value, each.interval, expected))
    return TextTable(
        f"{experiment.title}: {over.format(ranges_text(seeds))}, renderer {renderer}",
        f"fitted: {experiment.fitted}" if experiment.fitted else "",
        ("method", "the paper", "here", "value", "interval", "expected"),
        tuple(rows),
    )


def print_table(texts: TextTable) -> None:
    """Print a table with the words below it, without columns that have no text; names and numbers stay whole."""
    table = Table(
        title=texts.title,
        caption=texts.words or None,
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    columns = zip(texts.heads, *texts.rows, strict=True)
    shown = [column for column in columns if any(column[1:]) or not texts.rows]
    for head, *cells in shown:
        widest = 0 if any(" " in cell for cell in cells) else max(map(len, cells), default=0)
        table.add_column(head, overflow="fold", min_width=widest)
    for row in zip(*(cells[1:] for cells in shown), strict=True):
        table.add_row(*row)
    console_of().print(table)
