"""One self-contained HTML page, made from rows alone: it opens offline, and the same rows make the same page."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from markupsafe import Markup

from benchmarks.contract.rows import REAL, Row, read_rows
from benchmarks.contract.suite import Condition, Suite, suite
from benchmarks.run.blindfold import WHAT_BLIND_MEANS
from benchmarks.run.failures import ended_processes
from benchmarks.show import plots, tables
from benchmarks.show.facts import facts_table
from benchmarks.show.figures import ReportFigure
from benchmarks.show.metric_definitions import MetricDefinition, metric_definitions
from benchmarks.show.palette import LineStyle, line_styles
from benchmarks.show.pictures import Picture, read_pictures, remove_picture
from benchmarks.show.plots import Plot
from benchmarks.show.provenance import Provenance, provenance
from benchmarks.show.showing import Showing, showing_of
from benchmarks.show.templates import page_environment
from benchmarks.statistics.summary import (
    COMPARISONS_FILE_NAME,
    SUMMARY_FILE_NAME,
    condition_of,
    grouped,
    label_of,
    steering_words,
    write_summary,
)
from sim.checks import check
from trackers import registry
from trackers.atomic_file import write_atomic
from trackers.papers import Paper, paper_of

REPORT_FILE_NAME = "report.html"
_RANKED_ROLES = ("ours", "policy", "as-written", "tuned", "baseline", "external")
_ROLE_ORDER = (*_RANKED_ROLES, "variant", *tables.UNRANKED_ROLES)
_DRAWN_ROLES = (*_RANKED_ROLES, *tables.UNRANKED_ROLES)


@dataclass(frozen=True, slots=True)
class Differences:
    """One contestant minus others: ``first`` minus each ``other`` (a kind of contestant)."""

    first: str
    other: str
    table: tables.Table


@dataclass(frozen=True, slots=True)
class Section:
    """The report's section of one condition; ``about`` it, and what ``silence`` counts as, in words."""

    name: str
    title: str
    is_real: bool
    about: str
    silence: str
    suite: Suite
    showing: Showing
    provenance: Provenance
    leaderboard: tables.Table
    references: tables.Table
    references_note: str
    papers: Mapping[Paper, Sequence[str]]
    variants: tables.Table
    differences: tuple[Differences, ...]
    everything: tables.Table
    facts: tables.Table | None
    ours: str | None
    plots: tuple[Plot, ...]
    legend: tuple[tuple[str, str, LineStyle], ...]
    pictures: tuple[Picture, ...] = ()


def write_report(directory: Path, metrics: Sequence[str] = (), plots: Sequence[str] = ()) -> Path:
    """Make ``directory/report.html`` from the rows in ``directory`` and return its path.

    For a picture of the suite part of a simulated episode is run again, if this code made the rows. A missing summary
    or comparison file is made again.

    Args:
        metrics: names of those on the leaderboard, the first one ranks; () = the suite's headline.
        plots: words of the titles of those to draw; () = all.

    Raises:
        ValueError: if the folder holds no results, or no plot has such a title.
    """
    rows = read_rows(directory)
    check("directory", bool(rows), "one that holds results", f"no whole episode in {str(directory)!r}")
    if not all((directory / name).is_file() for name in (SUMMARY_FILE_NAME, COMPARISONS_FILE_NAME)):
        write_summary(directory)
    summary = json.loads((directory / SUMMARY_FILE_NAME).read_text())
    comparisons = json.loads((directory / COMPARISONS_FILE_NAME).read_text())
    groups = grouped(rows)
    sections = [
        _section(condition, trackers, _of(summary, condition), _of(comparisons, condition), metrics)
        for condition, trackers in groups.items()
    ]
    if plots:
        chosen = _chosen(sections, plots)
        sections = [replace(section, plots=each) for section, each in zip(sections, chosen, strict=True)]
    # After the check of the plots, since they run a tracker again.
    pictures = _pictures(directory, groups, summary)
    sections = [
        replace(section, pictures=tuple(picture for picture in pictures if picture.condition == condition))
        for section, condition in zip(sections, groups, strict=True)
    ]
    path = directory / REPORT_FILE_NAME
    write_atomic(path, _render(sections))
    return path


def _pictures(
    directory: Path, groups: Mapping[Condition, Mapping[str, list[Row]]], summary: list[dict[str, Any]]
) -> list[Picture]:
    """Draw the pictures of simulated episodes; return all that the folder has."""
    deadly = ended_processes(directory)
    for condition, trackers in groups.items():
        if condition[1] == REAL:
            continue
        alive = [
            each for each in _of(summary, condition) if deadly.isdisjoint((each["tracker"], each.get("controller")))
        ]
        if alive:
            showing_of(suite(condition[0])).picture(directory, condition, trackers, _worth_showing(alive, condition))
        else:
            remove_picture(directory, "-".join(filter(None, condition)))
    return read_pictures(directory)


def _chosen(sections: Sequence[Section], plots: Sequence[str]) -> list[tuple[Plot, ...]]:
    """Return the plots of each section whose titles hold one of ``plots``."""
    titles = dict.fromkeys(plot.title for section in sections for plot in section.plots)
    for words in plots:
        known = any(words.lower() in title.lower() for title in titles)
        check("plot", known, f"words of one of the titles {', '.join(map(repr, titles))}", repr(words))
    return [
        tuple(plot for plot in section.plots if any(words.lower() in plot.title.lower() for words in plots))
        for section in sections
    ]


def page_style() -> str:
    """Return the style sheet of our pages."""
    return Path(__file__).with_name("page.css").read_text()


def _worth_showing(summary: list[dict[str, Any]], condition: Condition) -> list[str]:
    """Return ours, users' own and the best of the methods as written; without them the leader."""
    lines = tables.leaderboard(suite(condition[0]), summary, _RANKED_ROLES).lines
    first = {line.role: line.names[:1] for line in reversed(lines)}
    own = [line.names[0] for line in lines if line.role == "external"]
    chosen = [*first.get("ours", ()), *own, *first.get("as-written", ())]
    return chosen or [line.names[0] for line in lines[:1]] or [entry["tracker"] for entry in summary[:1]]


def _render(sections: list[Section]) -> str:
    heading = " · ".join(dict.fromkeys(section.showing.heading or section.suite.summary for section in sections))
    page = page_environment(__file__).get_template("page.html.jinja")
    definitions = [(section.suite.name, _defined(section.suite, sections)) for section in _one_a_suite(sections)]
    return page.render(
        heading=heading,
        sections=sections,
        definitions=definitions,
        references_heading=tables.REFERENCES,
        style=Markup(page_style()),
    )


def _one_a_suite(sections: list[Section]) -> list[Section]:
    return list({section.suite.name: section for section in sections}.values())


def _defined(suite: Suite, sections: list[Section]) -> list[MetricDefinition]:
    """Return the definitions of those metrics of a suite that stand in a table."""
    mine = [section for section in sections if section.suite.name == suite.name]
    shown = [each for section in mine for each in (section.everything, section.facts) if each is not None]
    names = {column.name for table in shown for column in table.columns}
    return [each for each in metric_definitions(suite) if each.name in names]


def _of(entries: list[dict[str, Any]], condition: Condition) -> list[dict[str, Any]]:
    return [entry for entry in entries if condition_of(entry) == condition]


def _section(
    condition: Condition,
    contestants: Mapping[str, list[Row]],
    summary: list[dict[str, Any]],
    comparisons: list[dict[str, Any]],
    metrics: Sequence[str],
) -> Section:
    suite_name, scenario, preset, renderer, _ = condition
    scores = suite(suite_name).showing(metrics)
    everything = tables.every_metric(scores, summary)
    ranked = _ranked(everything)
    references = tables.leaderboard(scores, summary, tables.UNRANKED_ROLES)
    shown = showing_of(scores)
    notes = {"blind": WHAT_BLIND_MEANS, "oracle": shown.oracles}
    styles, real = line_styles(ranked), scenario == REAL
    sequences = scores.on_sequences if real else None
    return Section(
        name="-".join(filter(None, condition)),
        title=f"{scenario} · {preset}" if real else f"{scenario} · {preset} · {steering_words(condition)} · {renderer}",
        is_real=real,
        about=scores.summary if sequences is None else "Real sequences of pictures, with boxes of one target as truth.",
        silence=scores.silence if sequences is None else sequences.silence,
        suite=scores,
        showing=shown,
        provenance=provenance([row for rows in contestants.values() for row in rows]),
        leaderboard=tables.leaderboard(scores, summary, _RANKED_ROLES),
        references=references,
        references_note=" ".join(notes[role] for role in dict.fromkeys(line.role for line in references.lines)),
        papers=_papers(everything),
        variants=tables.leaderboard(scores, summary, ("variant",)),
        differences=_differences(scores, comparisons, everything),
        everything=everything,
        facts=None if shown.facts is None else facts_table(shown.facts, contestants),
        ours=next((name for name, role in ranked if role == "ours"), None),
        plots=_plots(scores, contestants, summary, styles),
        legend=tuple((name, role, styles[name]) for name, role in ranked if role in _DRAWN_ROLES),
    )


def _papers(everything: tables.Table) -> dict[Paper, list[str]]:
    """Return the papers of the trackers in a table, each with the names of their methods."""
    known, found = registry.entries(), dict[Paper, list[str]]()
    for name in sorted({name for line in everything.lines for name in line.names} & known.keys()):
        paper = paper_of(known[name].tracker.__module__)
        if paper is not None:
            found.setdefault(paper, []).append(name)
    return found


def figures_of(rows: Sequence[Row], summary: list[dict[str, Any]]) -> list[ReportFigure]:
    """Return the plots of the page of these rows, condition by condition."""
    made: list[ReportFigure] = []
    for condition, contestants in grouped(rows).items():
        scores, entries = suite(condition[0]), _of(summary, condition)
        ranked = _ranked(tables.every_metric(scores, entries))
        styles = line_styles(ranked)
        legend = [(name, styles[name]) for name, role in ranked if role in _DRAWN_ROLES]
        drawn = _plots(scores, contestants, entries, styles)
        made += [ReportFigure(plot.title, plot.words, plot.svg, legend) for plot in drawn]
    return made


def _ranked(everything: tables.Table) -> list[tuple[str, str]]:
    """Return name and role of those that have a line style: that of the first name, e.g. the controller's."""
    roles: dict[str, str] = {}
    for line in sorted(everything.lines, key=lambda line: _ROLE_ORDER.index(line.role)):
        # A controller that also has a blind tracker keeps its own role.
        roles.setdefault(line.names[0], line.role)
    return list(roles.items())


def _plots(
    scores: Suite,
    contestants: Mapping[str, Sequence[Row]],
    summary: list[dict[str, Any]],
    styles: Mapping[str, LineStyle],
) -> tuple[Plot, ...]:
    drawn = {name: rows for name, rows in contestants.items() if rows[0]["role"] in _DRAWN_ROLES}
    # A suite's own references are there for its figures, whatever their role.
    own = {name: contestants[name] for each in scores.references if (name := each.name) in contestants}
    return (*showing_of(scores).figures(drawn | own, styles), *_speed_plot(summary, styles))


def _differences(scores: Suite, comparisons: list[dict[str, Any]], everything: tables.Table) -> tuple[Differences, ...]:
    """Return the tables of differences, in the order of the comparisons."""
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for entry in comparisons:
        kind = entry.get("compared", scores.contestants[0])
        # The name in which the two differ comes first.
        names = dict(zip(scores.contestants, scores.names_of(entry), strict=True))
        first = " + ".join([names.pop(kind), *names.values()])
        groups.setdefault((first, kind), []).append(entry)
    return tuple(
        Differences(
            first,
            kind,
            tables.paired_differences(
                scores,
                mine,
                list(dict.fromkeys(line.names[scores.contestants.index(kind)] for line in everything.lines)),
            ),
        )
        for (first, kind), mine in groups.items()
    )


def _speed_plot(summary: list[dict[str, Any]], styles: Mapping[str, LineStyle]) -> list[Plot]:
    entries = {label_of(entry): entry for entry in summary if entry["metric"] == "frames_per_s"}
    speeds = {
        name: (entry["mean"], entry["ci_low"], entry["ci_high"])
        for name in styles
        if (entry := entries.get(name)) and entry["role"] in _DRAWN_ROLES and entry["ci_low"] is not None
    }
    if not speeds:
        return []
    words = (
        "The tracker alone, without rendering, at the larger of its CPU time and its wall time. Dots: median over "
        "episodes."
    )
    return [Plot("How fast are the trackers?", words, plots.plot_speed(speeds, styles))]
