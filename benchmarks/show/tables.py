"""Tables of the report: leaderboard with intervals, paired differences, every metric, facts; and as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import Row
from benchmarks.contract.suite import Suite
from benchmarks.contract.text import interval_text, number_text, unit_sign
from benchmarks.judges.tracker_speed import FRAMES_SEEN
from benchmarks.statistics.bootstrap import interval_of
from benchmarks.statistics.summary import by_seed, episode_names

Entry = dict[str, Any]

UNRANKED_ROLES = ("blind", "oracle")
"""References, not competitors: never the best, and in a part of the table of their own. Some get the truth at
times, e.g. at each exit, which no competitor does."""
RANKED_ROLES = ("ours", "policy", "as-written", "tuned", "baseline", "external")
"""Competitors: all others but variants."""
_ROLE_ORDER = (*RANKED_ROLES, "variant", *UNRANKED_ROLES)
REFERENCES = "references, not ranked"
"""Heading of that part."""
NO_NUMBER = "–"
"""Text of a cell without a value."""
_RANKED_BY = 3
"""Number of columns that decide the order: the first one, on ties the next …"""
_CAPITALS = "tpr tnr auc nees dat tsr sr evt f f1 hota idf1 mota froc gospa agc"
_WRITTEN_OUT = {"gm": "√(TPR × TNR)"} | {word: word.upper() for word in _CAPITALS.split()}


@dataclass(frozen=True, slots=True)
class Column:
    """Head of a column: the metric's name, the same in words, unit sign, ``↑`` ``↓`` or the ideal value, definition."""

    name: str
    title: str
    unit: str
    goal: str
    summary: str

    @property
    def head(self) -> str:
        """The name in words with its unit and an arrow for the better direction."""
        return " ".join(filter(None, (self.title, f"({self.unit})" if self.unit else "", self.goal)))


@dataclass(frozen=True, slots=True)
class Cell:
    """A value with its interval.

    Attributes:
        text, interval: in words; ``interval`` may be empty.
        bar: left end, width and dot of the interval's bar, in per cent of the column's range; None = no bar.
        mark: ``best``, ``better``, ``worse`` or nothing.
    """

    text: str
    interval: str = ""
    bar: tuple[float, float, float] | None = None
    mark: str = ""

    @property
    def short_interval(self) -> str:
        """The interval as ``89.3–98.3``."""
        return self.interval.replace(" … ", "–")

    def __str__(self) -> str:
        return f"{self.text} ({self.short_interval})" if self.interval else self.text


@dataclass(frozen=True, slots=True)
class Line:
    """One line.

    Attributes:
        names: of tracker, or controller and tracker; or another heading.
        role: of the first name.
    """

    names: tuple[str, ...]
    role: str
    cells: tuple[Cell, ...]

    @property
    def words(self) -> list[str]:
        """Its cells as Markdown: names, role, numbers with their intervals."""
        return [*(f"`{name}`" for name in self.names), self.role, *map(str, self.cells)]


@dataclass(frozen=True, slots=True)
class Table:
    """Columns and lines; references come last."""

    columns: tuple[Column, ...]
    lines: tuple[Line, ...]

    @property
    def parts(self) -> tuple[list[Line], list[Line]]:
        """The lines of competitors, and those of references."""
        references = [line for line in self.lines if line.role in UNRANKED_ROLES]
        return [line for line in self.lines if line.role not in UNRANKED_ROLES], references


@dataclass(frozen=True, slots=True)
class Facts:
    """What a table of the report about the episodes themselves, independent of trackers, is made of.

    Attributes:
        title, words: of the table, note below it. lines: name of a line -> suffix after ``_`` in the names of its rows.
        columns: metrics, with rows named without the suffix. beside: name of what was measured elsewhere -> its rows.
    """

    title: str
    words: str
    lines: Mapping[str, str]
    columns: tuple[Metric, ...]
    beside: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def leaderboard(suite: Suite, entries: Sequence[Entry], roles: Sequence[str]) -> Table:
    """Return the headline metrics of those with one of these roles, the best first, then references."""
    headline = suite.headline_in(entries[0]["scenario"]) if entries else ()
    if any(entry["metric"] == FRAMES_SEEN for entry in entries):
        # In real time every score depends on it.
        headline = tuple(dict.fromkeys((*headline[:1], FRAMES_SEEN, *headline[1:])))
    return _table(suite, [suite.metric(name) for name in headline], entries, roles)


def every_metric(suite: Suite, entries: Sequence[Entry]) -> Table:
    """Return all metrics: a line for each tracker or pair, in the leaderboard's order."""
    roles = sorted({entry["role"] for entry in entries})
    order = [line.names for line in leaderboard(suite, entries, roles).lines]
    table = _table(suite, suite.metrics, entries, roles)
    return Table(table.columns, tuple(sorted(table.lines, key=lambda line: order.index(line.names))))


def names_and_roles(suite: Suite, entries: Sequence[Entry]) -> list[tuple[str, str]]:
    """Return name and role of those that have a line style, in order: of the first name, e.g. the controller."""
    roles: dict[str, str] = {}
    for line in sorted(every_metric(suite, entries).lines, key=lambda line: _ROLE_ORDER.index(line.role)):
        # A controller that also has a blind tracker keeps its own role.
        roles.setdefault(line.names[0], line.role)
    return list(roles.items())


def paired_differences(suite: Suite, comparisons: Sequence[Entry], order: Sequence[str]) -> Table:
    """Return one tracker or pair minus each other one, marked where interval and Holm's p are significant.

    Args:
        comparisons: of that one. order: possible names of ``other``.
    """
    compared = suite.compared_in(comparisons[0]["scenario"]) if comparisons else ()
    known = {(entry["other"], entry["metric"]): entry for entry in comparisons}
    metrics = [suite.metric(name) for name in compared if any(name == metric for _, metric in known)]
    others = [name for name in order if any(name == other for other, _ in known)]
    lines = (
        Line((other,), "", tuple(_difference(metric, known.get((other, metric.name))) for metric in metrics))
        for other in others
    )
    return Table(tuple(map(column_of, metrics)), tuple(lines))


def _table(suite: Suite, metrics: Sequence[Metric], entries: Sequence[Entry], roles: Sequence[str]) -> Table:
    """Return a table of those with one of these roles; bars and marks are relative to all entries."""
    known: dict[str, dict[tuple[str, ...], Entry]] = {}
    for entry in entries:
        known.setdefault(entry["metric"], {})[suite.names_of(entry)] = entry
    metrics = [metric for metric in metrics if metric.name in known]
    role_of = {suite.names_of(entry): entry["role"] for entry in entries if entry["role"] in roles}
    columns = {metric.name: _cells(metric, known[metric.name]) for metric in metrics}

    def place(names: tuple[str, ...]) -> list[float]:
        return [rank(metric, known[metric.name].get(names)) for metric in metrics[:_RANKED_BY]]

    order = sorted(role_of, key=lambda names: [role_of[names] in UNRANKED_ROLES, *place(names)])
    lines = (
        Line(names, role_of[names], tuple(columns[metric.name].get(names, Cell(NO_NUMBER)) for metric in metrics))
        for names in order
    )
    return Table(tuple(map(column_of, metrics)), tuple(lines))


def column_of(metric: Metric) -> Column:
    """Return the head of a metric's column."""
    goal = {"higher": "↑", "lower": "↓"}[metric.better]
    if metric.ideal is not None:
        goal = f"→ {100 * metric.ideal if metric.unit == 'fraction' else metric.ideal:g}"
    if "_per_" in metric.name:
        return Column(metric.name, metric.name.replace("_", " "), "", goal, metric.summary)
    words = [_WRITTEN_OUT.get(word, word) for word in metric.name.split("_")]
    unit = metric.unit.split()
    if words[-len(unit) :] == unit:
        words = words[: -len(unit)]
    return Column(metric.name, " ".join(words), unit_sign(metric.unit), goal, metric.summary)


def _cells(metric: Metric, entries: Mapping[tuple[str, ...], Entry]) -> dict[tuple[str, ...], Cell]:
    """Return the cells of a column; the best of those that are ranked, if there are several of these, is marked."""
    ranks = [rank(metric, entry) for entry in entries.values() if entry["role"] not in UNRANKED_ROLES]
    best = min(ranks) if len(ranks) > 1 else None
    # The right end of the column's bars: 1 for fractions, else the largest upper bound.
    ends = [entry["ci_high"] or 0.0 for entry in entries.values()]
    top = 1.0 if metric.unit == "fraction" else max(ends, default=0.0)
    cells = {}
    for names, entry in entries.items():
        mean, low, high = entry["mean"], entry["ci_low"], entry["ci_high"]
        is_best = mean is not None and entry["role"] not in UNRANKED_ROLES and rank(metric, entry) == best
        interval, bar = "", None
        if mean is not None and low is not None and high is not None and top > 0:
            interval = interval_text(low, high, metric.unit)
            left, right, dot = (max(0.0, min(100.0, 100.0 * value / top)) for value in (low, high, mean))
            bar = left, max(right - left, 0.5), dot
        cells[names] = Cell(number_text(mean, metric.unit), interval, bar, "best" if is_best else "")
    return cells


def rank(metric: Metric, entry: Entry | None) -> float:
    """Return the less, the better the mean of an entry is; infinity without one."""
    if entry is None or entry["mean"] is None:
        return float("inf")
    if metric.ideal is not None:
        return abs(entry["mean"] - metric.ideal)
    return -entry["mean"] if metric.better == "higher" else entry["mean"]


def _difference(metric: Metric, entry: Entry | None) -> Cell:
    if entry is None or entry["difference"] is None:
        return Cell(NO_NUMBER)
    low, high = entry["ci_low"], entry["ci_high"]
    clear = low is not None and high is not None and (low > 0 or high < 0) and entry["p_holm"] < 0.05
    ahead = (entry["difference"] > 0) == (metric.better == "higher")
    mark = "" if not clear else "better" if ahead else "worse"
    return Cell(
        number_text(entry["difference"], metric.unit, signed=True),
        interval_text(low, high, metric.unit, signed=True),
        mark=mark,
    )


def by_episode(metric: Metric, trackers: Mapping[str, Sequence[Row]], order: Sequence[str]) -> Table:
    """Return a metric of each episode or sequence: a line for each, a column for each tracker, its best marked.

    Args:
        trackers: rows by tracker, of one condition. order: of the columns.
    """
    values = {name: by_seed(trackers[name], metric) for name in order}
    shown = [name for name in order if values[name]]
    lines = []
    for seed, episode in episode_names(trackers).items():
        own = {name: values[name][seed] for name in shown if seed in values[name]}
        ranks = {name: rank(metric, {"mean": value}) for name, value in own.items()}
        cells = (
            Cell(number_text(own[name], metric.unit), mark="best" if ranks[name] == min(ranks.values()) else "")
            if name in own
            else Cell(NO_NUMBER)
            for name in shown
        )
        if own:
            lines.append(Line((episode,), "", tuple(cells)))
    return Table(tuple(Column(name, name, "", "", "") for name in shown), tuple(lines))


def facts_table(facts: Facts, trackers: Mapping[str, Sequence[Row]]) -> Table:
    """Return the means over the episodes of one condition, each episode counted once; empty lines are left out.

    On a set path the rows of all trackers are equal; in closed loop each tracker has its own episode.
    """
    once = {
        (row["seed"], name if row["controller"] else "", row["metric"]): row
        for name, rows in trackers.items()
        for row in rows
    }
    rows, lines = list(once.values()), list[Line]()
    units = [metric.unit for metric in facts.columns]
    for words, suffix in facts.lines.items():
        means = [interval_of(metric.statistic.of_line(suffix), rows) for metric in facts.columns]
        if any(mean is not None for mean in means):
            cells = [
                Cell(NO_NUMBER) if mean is None else Cell(number_text(mean.mean, unit), interval_text(*mean[1:], unit))
                for mean, unit in zip(means, units, strict=True)
            ]
            lines.append(Line((words,), "", tuple(cells)))
            for other, values in facts.beside.items():
                there = [values.get(f"{metric.statistic.of[0].name}_{suffix}") for metric in facts.columns]
                lines.append(Line((f"{words}, {other}",), "", tuple(map(Cell, map(number_text, there, units)))))
    columns: Iterable[Column] = map(column_of, facts.columns)
    if facts.beside:
        # Nearer to what was measured elsewhere is better, neither more nor less.
        columns = (replace(column, goal="") for column in columns)
    return Table(tuple(columns), tuple(lines))


def markdown_table(heads: Sequence[str], lines: Iterable[Sequence[str]], words: int) -> str:
    """Return a table as Markdown; the first ``words`` columns are text, the others numbers, which stand at the right.

    A bar in a cell is written so that it ends none.
    """
    ruler = ["---"] * words + ["---:"] * (len(heads) - words)
    rows = ([cell.replace("|", r"\|") for cell in cells] for cells in (heads, ruler, *lines))
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows)
