"""Definitions of metrics in full: formula, range, unit, better direction, conditions and source, from the code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks.contract.metric import NOT_STATED, Metric
from benchmarks.contract.suite import Suite
from benchmarks.contract.text import range_text
from benchmarks.show.docstrings import place_of
from benchmarks.show.showing import showing_of


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
    found: dict[Any, dict[str, None]] = {}
    for metric in metrics_of(suite):
        own = () if metric.value is None else (metric.value,)
        for quantity in metric.statistic.of:
            for thing in (*own, *quantity.defined_by):
                found.setdefault(thing, {})[quantity.name] = None
    return {thing: tuple(names) for thing, names in found.items()}


def metric_definitions(suite: Suite) -> list[MetricDefinition]:
    """Return the definitions of all metrics of a suite, see ``metrics_of``."""
    return [_definition(suite, metric) for metric in metrics_of(suite)]


def _definition(suite: Suite, metric: Metric) -> MetricDefinition:
    statistic = metric.statistic
    stated = [each for each in statistic.of if each.conditions != NOT_STATED]
    conditions = dict.fromkeys(each.conditions for each in stated if each.conditions)
    of_kind = f"; of events: {statistic.kind}" if statistic.kind else ""
    in_seconds = metric.unit == "s" and "frames" in statistic.formula
    return MetricDefinition(
        suite=suite.name,
        name=metric.name,
        summary=metric.summary,
        formula=statistic.words(),
        range=range_text(*statistic.range()) + (" frames, in s" if in_seconds else ""),
        unit=metric.unit,
        better=metric.better if metric.ideal is None else f"{metric.ideal:g}",
        conditions="; ".join(conditions or [NOT_STATED]) + of_kind,
        source="; ".join(dict.fromkeys(each.source for each in stated)) or NOT_STATED,
        rows=tuple(each.name for each in statistic.of),
        defined_in=tuple(map(place_of, metric.definitions)),
    )
