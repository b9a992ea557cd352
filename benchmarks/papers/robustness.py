"""How far figures that were fitted to a paper's depend on a method's settings and on how often something happens."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import Row
from benchmarks.contract.text import interval_text, number_text, ranges_text, unit_sign
from benchmarks.papers.claims import print_table
from benchmarks.statistics.bootstrap import bootstrap_interval

FOLDER = "robustness"
"""Of its rows, in the experiment's folder."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Robustness:
    """What is varied beside an experiment, one thing at a time.

    Attributes:
        trackers: methods whose figures were fitted.
        metrics: of the experiment.
        settings: words → values of the methods' parameters; they run on the pictures of the experiment.
        rates: words → values of the preset's fields; the methods run as in the experiment.
        words: on what is varied and why.
        episodes: the first ones of the experiment's that are used.
    """

    trackers: tuple[str, ...]
    metrics: tuple[str, ...]
    settings: Mapping[str, Mapping[str, Any]]
    rates: Mapping[str, Mapping[str, Any]]
    words: str
    episodes: int


class Sensitivity(NamedTuple):
    """A table of figures: ``heads`` of its columns; ``rows``, each with what is varied and the figures."""

    title: str
    words: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def scaled(name: str, factors: Sequence[float], **values: float) -> dict[str, dict[str, float]]:
    """Return words → ``values`` times each of the factors. The words hold the ``name`` of them all."""
    return {
        f"{name} × {factor:g}": {key: round(factor * value, 10) for key, value in values.items()} for factor in factors
    }


def sensitivity(
    made: Robustness, metrics: Sequence[Metric], rows: Sequence[Row], varied: Sequence[Row], preset: str, seeds: range
) -> Sensitivity:
    """Return the table.

    Args:
        rows: of the experiment, with one renderer. varied: of what is varied, with the same.
    """
    few = seeds[: made.episodes]
    columns = [(tracker, metric) for tracker in made.trackers for metric in metrics]
    as_set = [row for row in rows if row["seed"] in few and row["preset"] == preset]
    lines = [("as in the table above", *_cells(as_set, columns))]
    for name in made.settings:
        under = [(alias(tracker, name), metric) for tracker, metric in columns]
        lines.append((name, *_cells([row for row in varied if row["preset"] == preset], under)))
    for name in made.rates:
        lines.append((name, *_cells([row for row in varied if row["preset"] == alias(preset, name)], columns)))
    heads = [f"{tracker}: {_head(metric)}" for tracker, metric in columns]
    words = f"{made.words} Episodes {ranges_text(few)}; 95 % intervals over them."
    return Sensitivity("What was fitted, varied", words, ("varied", *heads), tuple(lines))


def alias(name: str, words: str) -> str:
    """Return the name under which a varied tracker or preset runs."""
    return f"{name} ({words})"


def _cells(rows: Sequence[Row], columns: Sequence[tuple[str, Metric]]) -> Iterator[str]:
    for tracker, metric in columns:
        pool = metric.statistic.pooled([row for row in rows if row["tracker"] == tracker])
        if pool is None or pool.seed_count == 0:
            yield "–"
        else:
            yield f"{number_text(pool.mean, metric.unit)} ({interval_text(*bootstrap_interval(pool), metric.unit)})"


def _head(metric: Metric) -> str:
    """Return the name of a metric in words, with its unit."""
    words, sign = metric.name.removesuffix(f"_{metric.unit}").replace("_", " "), unit_sign(metric.unit)
    return f"{words} ({sign})" if sign else words


def print_sensitivity(table: Sensitivity) -> None:
    """Print the table under its title, with the words about it below."""
    print_table(table.title, table.words, table.heads, table.rows)
