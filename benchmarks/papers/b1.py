"""Paper experiment B.1: do a camera's own settings say how much the light has changed the colours?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import joblib
import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.commands.progress import progress_bar
from benchmarks.experiment import make_folder
from benchmarks.papers.sheet_light import CURVES, SCENARIO, Finding, findings, mean_curve, measure
from benchmarks.records import FILE_NAME, Row, read_blocks, rewrite, write_beside
from benchmarks.report.numbers import interval_text, number_text, ranges_text
from benchmarks.report.page import page_style
from benchmarks.report.palette import line_styles
from benchmarks.report.pictures import read_pictures, write_picture
from benchmarks.report.plots import drawn_as, new_figure, svg
from benchmarks.writers import marks
from benchmarks.writers.contact_sheet import picture_sheet
from scenarios.scenario import RendererName
from scenarios.stereo_follow.sheet import CONDITIONS, ILLUMINANCES_LX, photograph
from sim.rng import episode_seed

TITLE = "Paper B, experiment I: what the camera's settings say of the light"
SETTING = (
    "A green sheet on a white wall under a light bulb that is dimmed from 609 to 19 lx. Condition I: white balance, "
    "shutter and gain are automatic; II: shutter and gain stay as they were at 609 lx; III: white balance does."
)
PAGE_FILE_NAME = "paper.html"
_ROLES = ("ours", "as-written", "as-written", "as-written", "oracle")
_REGION_RGB = (230, 60, 60)


def run(out: Path, seeds: range, renderer: RendererName, workers: int) -> None:
    """Run the experiment, print its table beside the paper's words, write rows, plots, pictures and ``out/paper.html``.

    A folder that already holds rows of the other renderer keeps them; the table then shows both.

    Args:
        out: folder. seeds: arrangements of sheet, lamp and camera; 10,000 to 19,999 are the test split.
        renderer: ``raster`` or ``pybullet``.
        workers: processes.
    """
    make_folder(out)
    blocks = _other_rows(out, renderer) + _measured(seeds, renderer, workers)
    rewrite(out, blocks)
    rows = [row for block in blocks for row in block]
    found = findings(rows)
    _write_pictures(out, seeds.start, renderer)
    path = out / PAGE_FILE_NAME
    write_beside(path, _page(found, [row for row in rows if row["renderer"] == renderer], out, seeds))
    _print(found, seeds)
    print(f"page: {path}")


def _other_rows(out: Path, renderer: RendererName) -> list[list[Row]]:
    if not (out / FILE_NAME).is_file():
        return []
    return [rows for key, rows in read_blocks(out).items() if key.renderer != renderer]


def _measured(seeds: range, renderer: RendererName, workers: int) -> list[list[Row]]:
    """Return a block for each seed, in order."""
    parallel = joblib.Parallel(n_jobs=max(workers, 1), return_as="generator")
    blocks: list[list[Row]] = []
    with progress_bar("paper B1") as progress:
        progress(0, len(seeds))
        for block in parallel(joblib.delayed(measure)(seed, renderer) for seed in seeds):
            blocks.append(block)
            progress(len(blocks), len(seeds))
    return blocks


def _write_pictures(out: Path, seed: int, renderer: RendererName) -> None:
    """Write the paper's figure 2 beside the rows: the sheet at each illuminance, under every condition."""
    rows: list[list[tuple[str, NDArray[np.uint8]]]] = []
    for condition in CONDITIONS:
        rows.append([])
        for picture in photograph(condition, episode_seed(seed, SCENARIO, 0), renderer):
            marks.draw_box(picture.image_rgb, picture.region_xyxy, _REGION_RGB)
            rows[-1].append((f"{condition.name}: {picture.illuminance_lx:.0f} lx", picture.image_rgb))
    write_picture(
        out,
        f"paper-b1-{renderer}",
        picture_sheet(rows),
        ("stereo", SCENARIO, "paper-b1", renderer, ""),
        "The paper's figure 2, in this world",
        f"What the camera sees at each illuminance under conditions I, II and III, and the rectangle whose colours "
        f"are looked at; seed {seed}.",
        made_from=f"seed {seed}",
    )


def _plot(rows: Sequence[Row], condition: str) -> str:
    """Draw dissimilarity and settings against illuminance, the mean over seeds, as the paper's figure 3."""
    styles = line_styles(list(zip(CURVES, _ROLES, strict=True)))
    with drawn_as(f"b1-{condition}"):
        figure, axes = new_figure("illuminance on the sheet, lx", "")
        for name, label in CURVES.items():
            style = styles[name]
            (line,) = axes.plot(ILLUMINANCES_LX, mean_curve(rows, condition, name), "o-", markersize=3, label=label)
            line.set(color=style.colour, linewidth=style.width, dashes=style.dashes or (1, 0))
        axes.set_xscale("log")
        axes.invert_xaxis()
        # The second lies so near to the first that their numbers would touch.
        words = ["" if k == 1 else f"{lx:g}" for k, lx in enumerate(ILLUMINANCES_LX)]
        axes.set_xticks(ILLUMINANCES_LX, words, fontsize=8)
        axes.minorticks_off()
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_ylim(0, 1.2)
        figure.legend(frameon=False, fontsize=8, loc="outside upper left", ncols=3)
        return svg(figure)


def _print(found: Sequence[Finding], seeds: range) -> None:
    table = Table(title=f"{TITLE}: seeds {ranges_text(seeds)}, 95 % intervals over them")
    for head in ("the paper", "here", "renderer", "value", "interval", "expected"):
        table.add_column(head)
    for each in found:
        claim = each.claim
        expected = f"{claim.bound} {claim.level:g}: {'yes' if each.agrees else 'NO'}"
        interval = interval_text(each.ci_low, each.ci_high, "1")
        table.add_row(claim.words, claim.counted, each.renderer, number_text(each.mean, "1"), interval, expected)
    console = Console()
    (console if console.is_terminal else Console(width=118)).print(table)


def _page(found: Sequence[Finding], rows: Sequence[Row], out: Path, seeds: range) -> str:
    environment = Environment(
        loader=PackageLoader("benchmarks", "papers"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("sheet_light.html.jinja").render(
        title=TITLE,
        setting=SETTING,
        findings=[(each, number_text(each.mean, "1"), interval_text(each.ci_low, each.ci_high, "1")) for each in found],
        plots=[(condition.name, Markup(_plot(rows, condition.name))) for condition in CONDITIONS],
        pictures=read_pictures(out),
        seeds=ranges_text(seeds),
        command=f"frameout paper B1 --seeds {seeds.start}:{seeds.stop}",
        style=Markup(page_style()),
    )
