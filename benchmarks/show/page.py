"""One self-contained HTML page, made from rows alone: it opens offline, and the same rows make the same page."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from benchmarks.contract.rows import FILE_NAME, REAL, Row, read_rows
from benchmarks.contract.suite import Condition, Suite, suite, suites
from benchmarks.contract.text import time_in_words
from benchmarks.judges.tracker_speed import MS_PER_FRAME
from benchmarks.run.blindfold import BLIND_NOTE
from benchmarks.run.editions import judge_edition
from benchmarks.run.experiment import ShowProgress
from benchmarks.run.failures import ended_processes
from benchmarks.show import tables
from benchmarks.show.against import against, points_of
from benchmarks.show.charts import Chart
from benchmarks.show.definitions import metric_definitions
from benchmarks.show.palette import LineStyles, line_styles
from benchmarks.show.pictures import Reopen, keep_event_picture, name_of, read_pictures, remove_picture
from benchmarks.show.provenance import provenance
from benchmarks.show.showing import showing_of
from benchmarks.statistics.bootstrap import Interval
from benchmarks.statistics.summary import (
    COMPARISONS_FILE_NAME,
    SUMMARY_FILE_NAME,
    by_condition,
    grouped,
    label_of,
    read_entries,
    steering_words,
)
from sim.checks import check
from trackers import registry
from trackers.atomic_file import write_atomic
from trackers.papers import Paper, paper_of

if TYPE_CHECKING:
    from benchmarks.show.plots import ShownFigure

REPORT_FILE_NAME = "report.html"
_CODE = (".py", ".jinja", ".css", ".mplstyle")
_DRAWN_ROLES = (*tables.RANKED_ROLES, *tables.UNRANKED_ROLES)
_ABOUT_SEQUENCES = "Real sequences of pictures, with boxes of one target as truth."

Entries = list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class _Results:
    """The results of one condition: rows by tracker or pair, entries of the summary and of the comparisons, line styles
    of trackers or controllers.
    """

    condition: Condition
    rows: Mapping[str, list[Row]]
    summary: Entries
    comparisons: Entries
    suite: Suite
    styles: LineStyles

    @property
    def is_real(self) -> bool:
        """Whether rows are of real sequences or recordings."""
        return self.condition[1] == REAL

    @property
    def anchor(self) -> str:
        """Where metrics are defined: real sequences have conditions of their own."""
        return f"{self.suite.name}{'-real' if self.is_real and self.suite.on_sequences else ''}"

    def charts(self) -> list[Chart]:
        """Return the charts of the suite, and how fast trackers are."""
        # A suite's own references are there for its figures, whatever their role.
        own = {each.name for each in self.suite.references}
        drawn = {name: rows for name, rows in self.rows.items() if name in own or rows[0]["role"] in _DRAWN_ROLES}
        entries = {label_of(entry): entry for entry in self.summary if entry["metric"] == "frames_per_s"}
        speeds = {
            name: {name: Interval(entry["mean"], entry["ci_low"], entry["ci_high"])}
            for name in self.styles
            if (entry := entries.get(name)) and entry["role"] in _DRAWN_ROLES and entry["ci_low"] is not None
        }
        speed = Chart(
            title="How fast are the trackers?",
            words="The tracker alone, without rendering, at the larger of its CPU time and its wall time. Dots: "
            "median over episodes.",
            lines=speeds,
            x_label="frames a second on one core",
            x_scale="log",
        )
        return [chart for chart in (*showing_of(self.suite).charts(drawn), *self._cost(), speed) if chart.values]

    def _cost(self) -> Iterator[Chart]:
        """Yield the score that ranks over the time a frame; nothing of a single point, or in a suite without times."""
        if MS_PER_FRAME not in {each.name for each in self.suite.metrics}:
            return
        y, x = (self.suite.metric(name) for name in (self.suite.headline_in(self.condition[1])[0], MS_PER_FRAME))
        entries = [entry for entry in self.summary if entry["role"] in _DRAWN_ROLES]
        found = points_of(entries, y.name, x.name)
        points = {name: each for name, each in found.items() if name in self.styles}
        if sum(len(each.texts) for each in points.values()) > 1 and x.name != y.name:
            yield against(points, y, x, "What does a better score cost?")


def write_report(
    directory: Path,
    metrics: Sequence[str] = (),
    reopen: Reopen = lambda row, seed: None,
    progress: ShowProgress = lambda title: nullcontext(),
) -> Path:
    """Make ``directory/report.html`` from the rows in ``directory`` and return its path.

    For a picture of the suite part of an episode is run again, if this code made the rows. A missing summary
    or comparison file is made again.

    Args:
        metrics: names of those on the leaderboard, the first one ranks; () = the suite's headline.
        reopen: opens real sequences again; without it there is no picture of them.
        progress: shows progress of the runs for pictures, see ``ShowProgress``.

    Raises:
        ValueError: if the folder holds no results.
    """
    made_from = _made_from(directory, metrics)
    rows = read_rows(directory)
    check("directory", bool(rows), "one that holds results", f"no whole episode in {str(directory)!r}")
    summary, comparisons = (read_entries(directory, name) for name in (SUMMARY_FILE_NAME, COMPARISONS_FILE_NAME))
    results = list(_by_condition(rows, summary, comparisons, metrics))
    _draw_pictures(directory, results, reopen, progress)
    pictures = read_pictures(directory)
    sections = [_section(each, [one for one in pictures if one["condition"] == [*each.condition]]) for each in results]
    headings = (each["showing"].heading or each["suite"].summary for each in sections)
    path = directory / REPORT_FILE_NAME
    page = page_environment(__file__).get_template("page.html.jinja")
    text = page.render(
        heading=" · ".join(dict.fromkeys(headings)),
        made_from=made_from,
        sections=sections,
        definitions=_definitions(results),
        references_heading=tables.REFERENCES,
        style=Markup(page_style()),
    )
    write_atomic(path, text)
    return path


def _definitions(results: Sequence[_Results]) -> dict[str, tuple[str, list[dict[str, Any]]]]:
    """Return the definitions of metrics with their heading, by anchor; of real sequences those that they have."""
    found: dict[str, tuple[str, list[dict[str, Any]]]] = {}
    for each in results:
        name, on_sequences = each.suite.name, each.suite.on_sequences if each.is_real else None
        defined, heading = metric_definitions(suite(name), on_sequences.conditions if on_sequences else {}), name
        if on_sequences is not None:
            held = {entry["metric"] for entry in each.summary}
            defined = [metric for metric in defined if metric["name"] in held]
            heading = f"{name} on real sequences"
        found[each.anchor] = heading, defined
    return found


def is_current(directory: Path, metrics: Sequence[str] = ()) -> bool:
    """Return whether the report of a folder is what ``write_report`` would make of its rows now."""
    report = directory / REPORT_FILE_NAME
    return report.is_file() and f'content="{_made_from(directory, metrics)}"' in report.read_text()


def _made_from(directory: Path, metrics: Sequence[str]) -> str:
    """Return a digest of a folder's rows, of the metrics that are shown and of the code that makes pages of them."""
    rows = directory / FILE_NAME
    own = [judge_edition(judging) for judging in suites().values()]
    parts = [rows.read_bytes() if rows.is_file() else b"", repr((own, *metrics)).encode(), _digest_of_code().encode()]
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()


@cache
def _digest_of_code() -> str:
    files = (file for file in Path(__file__).parents[1].rglob("*") if file.suffix in _CODE)
    return hashlib.sha256(b"".join(file.read_bytes() for file in sorted(files))).hexdigest()


def figures_of(rows: Sequence[Row], summary: Entries) -> list[ShownFigure]:
    """Return the figures of the page of these rows, each with its title, condition by condition."""
    from benchmarks.show.plots import figure_of

    return [
        figure_of(chart, results.styles, titled=True)
        for results in _by_condition(rows, summary, [], ())
        for chart in results.charts()
    ]


def page_style() -> str:
    """Return the style sheet of our pages."""
    return Path(__file__).with_name("page.css").read_text()


def page_environment(module_file: str, *, autoescape: bool = True) -> Environment:
    """Return the environment of the templates beside a module, ``__file__``; a missing variable is an error."""
    return Environment(
        loader=FileSystemLoader(Path(module_file).parent),
        autoescape=autoescape,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _by_condition(
    rows: Sequence[Row], summary: Entries, comparisons: Entries, metrics: Sequence[str]
) -> Iterator[_Results]:
    entries, compared = by_condition(summary), by_condition(comparisons)
    for condition, by_name in grouped(rows).items():
        judging, own = suite(condition[0]).showing(metrics), entries.get(condition, [])
        styles = line_styles(tables.names_and_roles(judging, own))
        yield _Results(condition, by_name, own, compared.get(condition, []), judging, styles)


def _draw_pictures(directory: Path, results: Sequence[_Results], reopen: Reopen, progress: ShowProgress) -> None:
    """Draw a picture of each condition whose suite has one."""
    deadly = ended_processes(directory)
    for each in results:
        showing = showing_of(each.suite)
        event = showing.sequence_picture if each.is_real else showing.event_picture
        # What runs again: no tracker that ended its process, and none that ran elsewhere.
        gone = deadly | {name for name, rows in each.rows.items() if "predicted" in rows[0]}
        alive = [entry for entry in each.summary if gone.isdisjoint((entry["tracker"], entry.get("controller")))]
        if event is not None and alive:
            what = (directory, each.condition, each.rows, worth_showing(each.suite, alive), event)
            with progress(f"picture of {name_of(each.condition)}, frames") as report:
                keep_event_picture(*what, report or (lambda done, of: None), reopen if each.is_real else None)
        elif event is not None:
            remove_picture(directory, name_of(each.condition))


def worth_showing(suite: Suite, summary: Entries) -> list[str]:
    """Return ours, users' own and the best of the methods as written; without them the leader."""
    lines = tables.leaderboard(suite, summary, tables.RANKED_ROLES).lines
    first = {line.role: line.names[:1] for line in reversed(lines)}
    own = [line.names[0] for line in lines if line.role == "external"]
    chosen = [*first.get("ours", ()), *own, *first.get("as-written", ())]
    return chosen or [line.names[0] for line in lines[:1]] or [entry["tracker"] for entry in summary[:1]]


def _section(results: _Results, pictures: Entries) -> dict[str, Any]:
    """Return what the template shows of one condition."""
    from benchmarks.show.plots import plot_of

    _, scenario, preset, renderer, _ = results.condition
    scores, summary = results.suite, results.summary
    showing, real = showing_of(scores), results.is_real
    sequences = scores.on_sequences if real else None
    everything = tables.every_metric(scores, summary)
    roles = {line.role for line in everything.lines}
    ranking = scores.metric(scores.headline_in(scenario)[0])
    order = [label for line in everything.lines if (label := "+".join(line.names)) in results.rows]
    by_episode = tables.by_episode(ranking, results.rows, order)
    notes = {"blind": BLIND_NOTE, "oracle": showing.oracles}
    how = [] if real else [steering_words(results.condition), renderer]
    how += [time_in_words(summary[0]["real_time_hz"])] if "real_time_hz" in summary[0] else []
    return {
        "name": name_of(results.condition),
        "title": " · ".join([scenario, preset, *how]),
        "is_real": real,
        "anchor": results.anchor,
        "about": _ABOUT_SEQUENCES if sequences is not None and not scores.follows_many else scores.summary,
        "silence": scores.silence if sequences is None else sequences.silence,
        "suite": scores,
        "showing": showing,
        "provenance": provenance([row for rows in results.rows.values() for row in rows]),
        "leaderboard": tables.leaderboard(scores, summary, _DRAWN_ROLES),
        "references_note": " ".join(words for role, words in notes.items() if role in roles),
        "papers": _papers(everything),
        "differences": list(_differences(scores, results.comparisons, everything)),
        "everything": everything,
        "by_episode": by_episode,
        "ranking": tables.column_of(ranking),
        "facts": None if showing.facts is None else tables.facts_table(showing.facts, results.rows),
        "plots": [plot_of(chart, results.styles) for chart in results.charts()],
        "pictures": pictures,
    }


def _papers(everything: tables.Table) -> dict[Paper, list[str]]:
    """Return the papers of the trackers in a table, each with the names of their methods."""
    known, found = registry.entries(), dict[Paper, list[str]]()
    for name in sorted({name for line in everything.lines for name in line.names} & known.keys()):
        paper = paper_of(known[name].tracker.__module__)
        if paper is not None:
            found.setdefault(paper, []).append(name)
    return found


def _differences(
    scores: Suite, comparisons: Entries, everything: tables.Table
) -> Iterator[tuple[str, str, tables.Table]]:
    """Yield a tracker or pair, the kind of those that it is compared with, and the table of differences."""
    groups: dict[tuple[str, str], Entries] = {}
    for entry in comparisons:
        kind = entry.get("compared", scores.key_columns[0])
        # The name in which the two differ comes first.
        names = dict(zip(scores.key_columns, scores.names_of(entry), strict=True))
        first = " + ".join([names.pop(kind), *names.values()])
        groups.setdefault((first, kind), []).append(entry)
    for (first, kind), own in groups.items():
        order = dict.fromkeys(line.names[scores.key_columns.index(kind)] for line in everything.lines)
        yield first, kind, tables.paired_differences(scores, own, list(order))
