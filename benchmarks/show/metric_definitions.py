"""Definitions of metrics in full: formula, range, unit, better direction, conditions and source, from the code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from benchmarks.contract.metric import Metric, RowMeaning
from benchmarks.contract.suite import Suite
from benchmarks.contract.text import range_text
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.guards import times
from benchmarks.show.docstrings import place_of
from benchmarks.show.showing import showing_of
from benchmarks.statistics.pooling import FORMULAS

_TIMES = {times: TIMES}
"""Rows that every suite has."""
NOT_STATED = "not stated"
"""Conditions and source of a user's own metric."""


@dataclass(frozen=True, slots=True)
class MetricDefinition:
    """The definition of one metric of a suite, each part in words.

    Attributes:
        suite, name, summary, unit: see ``Metric``.
        formula: how rows make it. range: of its values; fractions are 0 to 1.
        better: ``higher``, ``lower``, or the ideal value.
        conditions: which frames, events or episodes count.
        source: where the definitions of its rows come from.
        rows: names of its rows. defined_in: places of their formulas.
    """

    suite: str
    name: str
    summary: str
    formula: str
    range: str
    unit: str
    better: str
    conditions: str
    source: str
    rows: tuple[str, ...]
    defined_in: tuple[str, ...]


def metrics_of(suite: Suite) -> list[Metric]:
    """Return the metrics of a suite's summary, then those of only its events and facts."""
    found: dict[str, Metric] = {}
    facts = showing_of(suite).facts
    for metric in (*suite.metrics, *suite.events.compared, *(facts.columns if facts else ())):
        found.setdefault(metric.name, metric)
    return list(found.values())


def definitions_of(suite: Suite) -> Mapping[Any, tuple[str, ...]]:
    """Return the definitions of a suite's rows: function, class or module -> names of rows."""
    added = {score: (row,) for row, score in suite.added().items()}
    return {**suite.definitions, **added, **_TIMES}


def metric_definitions(suite: Suite) -> list[MetricDefinition]:
    """Return the definitions of all metrics of a suite, see ``metrics_of``."""
    meanings = {row: meaning for meaning in suite.row_meanings for row in meaning.rows}
    return [_definition(suite, metric, [meanings.get(row) for row in metric.rows]) for metric in metrics_of(suite)]


def _definition(suite: Suite, metric: Metric, rows: Sequence[RowMeaning | None]) -> MetricDefinition:
    known = [row for row in rows if row is not None]
    conditions = dict.fromkeys(filter(None, (row.conditions for row in known)))
    places = [place_of(thing) for thing, some in definitions_of(suite).items() if set(some) & {*metric.rows}]
    of_kind = f"; of events: {metric.kind}" if metric.kind else ""
    return MetricDefinition(
        suite=suite.name,
        name=metric.name,
        summary=metric.summary,
        formula=_formula(metric),
        range=range_text(*_range(metric, known)) + (" frames, in s" if _is_in_seconds(metric) else ""),
        unit=metric.unit,
        better=metric.better if metric.ideal is None else f"{metric.ideal:g}",
        conditions="; ".join(conditions or [NOT_STATED]) + of_kind,
        source="; ".join(dict.fromkeys(row.source for row in known)) or NOT_STATED,
        rows=metric.rows,
        defined_in=tuple(places),
    )


def _formula(metric: Metric) -> str:
    rows = [f"`{row}`" for row in metric.rows]
    *low, high = (f"{each:g}" for each in metric.alarms_per_hour or (0.0,))
    alarms = f"a, its mean over log a from {low[0]} to {high}" if low else high
    return FORMULAS[metric.statistic].format(*rows, horizon=metric.horizon_frames, alarms=alarms)


def _is_in_seconds(metric: Metric) -> bool:
    return metric.statistic == "restricted mean" and metric.unit == "s"


def _range(metric: Metric, rows: Sequence[RowMeaning]) -> tuple[float, float]:
    """Return the ends of a metric's range, from those of its rows."""
    if metric.statistic in ("mean", "median", "geometric mean"):
        lows, highs = zip(*((row.low, row.high) for row in rows), strict=True) if rows else ((0.0,), (inf,))
        return (0.0, 1.0) if not rows and metric.unit == "fraction" else (min(lows), max(highs))
    if metric.statistic == "restricted mean":
        return 0.0, metric.horizon_frames
    if metric.statistic == "difference of medians":
        return -inf, inf
    if metric.statistic == "froc at a tenth":
        return -1.0, 1.0
    return 0.0, 1.0 if metric.unit == "fraction" else inf
