"""The results in a folder, for notebooks and scripts: tables, and plots of the report.

Rows become long tables for pandas: a line for each number, and apart from them a line for each entry of a list. Columns
of both: ``suite scenario preset renderer controller link tracker role real_time_hz seed sequence repeat``; then what
the row is about, ``event_kind event_index`` and the event's other attributes, all empty for rows about a whole episode;
then ``metric value weight``. ``benchmarks.contract.rows`` defines metrics and events. Values are floats; an undefined
value, null in a row, is NaN. A column that no row has is left out, e.g. ``link`` in most suites, and ``sequence`` in
simulated ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.contract.rows import FILE_NAME, Row, event_of, read_rows
from benchmarks.contract.suite import Suite, check_metrics, suite
from benchmarks.contract.text import counted, number_text
from benchmarks.run.outcome import Outcome
from benchmarks.show.against import against, points_of
from benchmarks.show.charts import Chart, Points
from benchmarks.show.palette import LineStyles, line_styles
from benchmarks.show.tables import column_of, names_and_roles, rank
from benchmarks.statistics.bootstrap import Interval
from benchmarks.statistics.summary import (
    COMPARISONS_FILE_NAME,
    SUMMARY_FILE_NAME,
    by_condition,
    by_seed,
    episode_names,
    grouped,
    label_of,
    read_entries,
)
from sim.checks import check, check_choice

if TYPE_CHECKING:
    import pandas as pd

    from benchmarks.show.plots import ShownFigure

_NAMES = (
    *("suite", "scenario", "preset", "renderer", "controller", "link"),
    *("tracker", "tracker_role", "role", "real_time_hz", "seed", "sequence", "repeat"),
)


_CONDITION = ("suite", "scenario", "preset", "renderer", "steering")


class Results:
    """What a bench left in a folder; every call reads it anew.

    Attributes:
        directory: the folder.
        outcome: of the run that returned it: failures, frames without an answer; empty for a folder that was opened.
    """

    def __init__(self, directory: Path | str, outcome: Outcome | None = None) -> None:
        """Open a folder. Raises ValueError if it holds no results."""
        self.directory = Path(directory)
        self.outcome = Outcome() if outcome is None else outcome
        there = (self.directory / FILE_NAME).is_file()
        check("directory", there, f"one that holds {FILE_NAME}", repr(str(directory)))

    def __repr__(self) -> str:
        failed = f", {counted(len(self.outcome.failures), 'failure')}" if self.outcome.failures else ""
        return f"Results({str(self.directory)!r}{failed})"

    def rows(self) -> pd.DataFrame:
        """Return all numbers, a line for each condition, seed, tracker, event and metric."""
        return numbers_table(read_rows(self.directory))

    def lists(self) -> pd.DataFrame:
        """Return all lists, e.g. the error on each frame outside, a line for each entry."""
        return lists_table(read_rows(self.directory))

    def summary(self) -> pd.DataFrame:
        """Return means with 95 % intervals, a line for each condition, tracker and metric: ``statistics.summary``."""
        return self._read(SUMMARY_FILE_NAME)

    def comparisons(self) -> pd.DataFrame:
        """Return paired differences of ours and each other tracker, see ``statistics.summary``."""
        return self._read(COMPARISONS_FILE_NAME)

    def plot(self, metric: str, over: str | None = None) -> ShownFigure:
        """Return a figure of a metric of the summary: a dot with its 95 % interval for each tracker, the best above.

        Those of several conditions stand below each other, condition by condition.

        Args:
            over: another metric, e.g. ``ms_per_frame``, for the x axis: points with intervals both ways, those of a
                tracker with several values of a parameter joined.

        Raises:
            ValueError: for a metric that none has; lists those that there are.
        """
        from benchmarks.show.plots import figure_of

        entries = read_entries(self.directory, SUMMARY_FILE_NAME)
        chart, styles = metric_chart(entries, metric) if over is None else over_chart(entries, metric, over)
        return figure_of(chart, styles, titled=True)

    def by_episode(self, metric: str) -> pd.DataFrame:
        """Return a metric of each episode or sequence: a line for each, a column for each tracker.

        Raises:
            ValueError: for a metric that none has; lists those that there are.
        """
        import pandas as pd

        groups = grouped(read_rows(self.directory))
        check_metrics([metric], dict.fromkeys(condition[0] for condition in groups))
        values = [
            {**dict(zip(_CONDITION, condition, strict=True)), "episode": names[seed], "tracker": label, metric: value}
            for condition, by_label in groups.items()
            if metric in {each.name for each in suite(condition[0]).metrics}
            for names in [episode_names(by_label)]
            for label, rows in by_label.items()
            for seed, value in by_seed(rows, suite(condition[0]).metric(metric)).items()
        ]
        table = pd.DataFrame(values, columns=[*_CONDITION, "episode", "tracker", metric])
        return table.pivot(index=[*_CONDITION, "episode"], columns="tracker", values=metric)

    def figures(self) -> list[ShownFigure]:
        """Return the plots of the report, condition by condition; a notebook shows each as a picture."""
        from benchmarks.show.page import figures_of

        return figures_of(read_rows(self.directory), read_entries(self.directory, SUMMARY_FILE_NAME))

    def _read(self, name: str) -> pd.DataFrame:
        import pandas as pd

        return pd.DataFrame(read_entries(self.directory, name))


def metric_chart(summary: Sequence[dict[str, Any]], metric: str) -> tuple[Chart, LineStyles]:
    """Return the chart of a metric of the list of ``summary.json``, see ``Results.plot``, and the report's styles."""
    lines: dict[str, dict[str, Interval]] = {}
    styles: LineStyles = {}
    for scores, entries, where, looks in _conditions_with(summary, metric):
        defined = scores.metric(metric)
        shown = [entry for entry in entries if entry["metric"] == metric]
        for entry in sorted(shown, key=lambda entry: rank(defined, entry)):
            name, mean = f"{label_of(entry)}{where}", entry["mean"]
            low, high = (mean if entry[key] is None else entry[key] for key in ("ci_low", "ci_high"))
            lines[name] = {} if mean is None else {name: Interval(mean, low, high)}
            styles[name] = looks[scores.names_of(entry)[0]]
    column, is_share = column_of(defined), defined.unit == "fraction"
    unit = f" ({column.unit})" if column.unit and not is_share else ""
    goal = f"{defined.better} is better"
    if defined.ideal is not None:
        goal = f"ideal: {number_text(defined.ideal, defined.unit)} {column.unit}".rstrip()
    chart = Chart(
        title=f"{column.title}, {max(entry['n'] for entry in summary if entry['metric'] == metric)} seeds",
        words="",
        lines=lines,
        x_label=f"{column.title}{unit}, {goal}, 95 % intervals",
        x_scale="share" if is_share else "linear",
    )
    return chart, styles


def over_chart(summary: Sequence[dict[str, Any]], y: str, x: str) -> tuple[Chart, LineStyles]:
    """Return the chart of one metric over another, see ``Results.plot``, and the report's styles."""
    points: dict[str, Points] = {}
    styles: LineStyles = {}
    for scores, entries, where, looks in _conditions_with(summary, y, x):
        of_y, of_x = scores.metric(y), scores.metric(x)
        own = points_of(entries, y, x)
        points |= {f"{name}{where}": each for name, each in own.items()}
        styles |= {f"{name}{where}": looks[name.partition("+")[0]] for name in own}
    return against(points, of_y, of_x, f"{column_of(of_y).title} over {column_of(of_x).title}"), styles


def _conditions_with(
    summary: Sequence[dict[str, Any]], *metrics: str
) -> list[tuple[Suite, list[dict[str, Any]], str, LineStyles]]:
    """Return suite, entries, words after a tracker's name and line styles of each condition that has these metrics.

    Raises:
        ValueError: if none has; lists the metrics that there are.
    """
    found = by_condition(summary)
    known = {condition: {entry["metric"]: None for entry in entries} for condition, entries in found.items()}
    for metric in metrics:
        check_choice("metric", metric, {name: None for names in known.values() for name in names})
        found = {condition: entries for condition, entries in found.items() if metric in known[condition]}
    check("metric", bool(found), "metrics of one suite", " and ".join(metrics))
    alike = len({condition[0] for condition in found}) == 1
    made = []
    for condition, entries in found.items():
        scores = suite(condition[0])
        where = "" if len(found) == 1 else f", {' '.join(filter(None, condition[alike:]))}"
        made.append((scores, entries, where, line_styles(names_and_roles(scores, entries))))
    return made


def numbers_table(rows: Iterable[Row]) -> pd.DataFrame:
    """Return the rows whose value is a number, a truth value (1 or 0) or null, a line for each."""
    return _table([row for row in rows if not isinstance(row["value"], list)], "value").astype({"value": float})


def lists_table(rows: Iterable[Row]) -> pd.DataFrame:
    """Return the rows whose value is a list (a *series*), a line for each entry: ``entry`` is its place from 0 on."""
    table = _table([row for row in rows if isinstance(row["value"], list)], "entry", "value").explode("value")
    table["entry"] = table.groupby(level=0).cumcount()
    return table.astype({"value": float}).reset_index(drop=True)


def _table(rows: Sequence[Row], *last: str) -> pd.DataFrame:
    import pandas as pd

    about = [{f"event_{key}": value for key, value in (event_of(row) or {}).items()} for row in rows]
    events = dict.fromkeys(["event_kind", "event_index", *(name for event in about for name in event)])
    lines = [{**row, **event, "entry": 0} for row, event in zip(rows, about, strict=True)]
    table = pd.DataFrame(lines, columns=[*_NAMES, *events, "metric", *last, "weight"])
    return table.dropna(axis="columns", how="all").astype({"weight": float}) if rows else table
