"""From rows to ``summary.json`` and ``comparisons.json``.

``summary.json`` is a list of ``{"suite", "scenario", "preset", "tracker", "role", "renderer", "metric",
"unit", "better", "mean", "ci_low", "ci_high", "n"}``: 95 % bootstrap over seeds, ``n`` seeds that say
something of the metric. Entries of runs in which the tracker steered carry ``controller`` too.

``comparisons.json`` is a list of ``{"suite", "scenario", "preset", "renderer", "metric", "better", "tracker",
"other", "difference", "ci_low", "ci_high", "p", "p_holm", "n"}`` (and ``controller``): tracker minus other, on the
seeds both ran on. ``p_holm`` is corrected for all comparisons of one (suite, scenario, preset, renderer,
controller): every other tracker times every compared metric.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import pooling, statistics
from benchmarks.records import Row, read_rows, rounded, write_beside
from benchmarks.suites import Condition, Metric, suite

SUMMARY_FILE_NAME = "summary.json"
COMPARISONS_FILE_NAME = "comparisons.json"

Groups = dict[Condition, dict[str, list[Row]]]


def write_summary(directory: Path) -> list[dict[str, Any]]:
    """Make both files from the directory's rows and return the summary.

    Raises:
        ValueError: if the directory holds no records.
    """
    groups = grouped(read_rows(directory))
    summary = summarise(groups)
    write_beside(directory / SUMMARY_FILE_NAME, json.dumps(summary, indent=1) + "\n")
    comparisons = compare_ours(groups)
    write_beside(directory / COMPARISONS_FILE_NAME, json.dumps(comparisons, indent=1) + "\n")
    return summary


def grouped(rows: Iterable[Row]) -> Groups:
    """Return rows by condition and tracker."""
    groups: Groups = defaultdict(lambda: defaultdict(list))
    for row in rows:
        condition = (
            row["suite"],
            row["scenario"],
            row["preset"],
            row["renderer"],
            row["controller"] or "",
        )
        groups[condition][row["tracker"]].append(row)
    return {condition: dict(trackers) for condition, trackers in groups.items()}


def summarise(groups: Groups) -> list[dict[str, Any]]:
    """Return the list of ``summary.json``."""
    entries = []
    for condition, trackers in groups.items():
        for tracker, rows in trackers.items():
            for metric in suite(condition[0]).metrics:
                pool = pooling.pooled(rows, metric)
                if pool is None or pool.seed_count == 0:
                    continue
                low, high = statistics.bootstrap_interval(pool)
                entry = {
                    **_named(condition, metric),
                    "tracker": tracker,
                    "role": rows[0]["role"],
                    "unit": metric.unit,
                    "mean": rounded(pool.mean),
                    "ci_low": rounded(low),
                    "ci_high": rounded(high),
                    "n": pool.seed_count,
                }
                entries.append({key: entry[key] for key in _SUMMARY_KEYS if key in entry})
    return entries


def compare_ours(groups: Groups) -> list[dict[str, Any]]:
    """Return the list of ``comparisons.json``: the tracker whose role is ``ours`` against every other one."""
    entries = []
    for condition, trackers in groups.items():
        ours = [name for name, rows in trackers.items() if rows[0]["role"] == "ours"]
        for name in ours:
            others = [other for other in trackers if other != name]
            entries += compare_trackers(condition, trackers, name, others)
    return entries


def compare_trackers(
    condition: Condition, trackers: Mapping[str, Sequence[Row]], name: str, others: Sequence[str]
) -> list[dict[str, Any]]:
    """Return the comparisons of one tracker with others under one condition, corrected for their number."""
    entries = []
    compared = suite(condition[0]).compared
    for other in others:
        for metric in map(suite(condition[0]).metric, compared):
            comparison = paired(trackers[name], trackers[other], metric)
            if comparison is not None:
                entries.append(
                    {
                        **_named(condition, metric),
                        "tracker": name,
                        "other": other,
                        **{key: rounded(value) for key, value in asdict(comparison).items()},
                        "n": comparison.n,
                    }
                )
    adjusted = statistics.holm(np.array([entry["p"] for entry in entries]))
    for entry, p_holm in zip(entries, adjusted, strict=True):
        entry["p_holm"] = rounded(float(p_holm))
    return [{key: entry[key] for key in _COMPARISON_KEYS if key in entry} for entry in entries]


def paired(first: Sequence[Row], second: Sequence[Row], metric: Metric) -> statistics.Comparison | None:
    """Return the paired comparison in one metric, None where one of the two says nothing of it."""
    grid = None
    if metric.statistic == "median":
        grid = np.union1d(pooling.values(first, metric), pooling.values(second, metric))
    pools = [pooling.pooled(rows, metric, grid) for rows in (first, second)]
    if pools[0] is None or pools[1] is None:
        return None
    if len(np.intersect1d(pools[0].seeds, pools[1].seeds)) == 0:
        return None
    comparison = statistics.compare(pools[0], pools[1])
    return comparison if np.isfinite(comparison.difference) else None


_SUMMARY_KEYS = [
    "suite",
    "scenario",
    "preset",
    "tracker",
    "role",
    "renderer",
    "controller",
    "metric",
    "unit",
    "better",
    "mean",
    "ci_low",
    "ci_high",
    "n",
]
_COMPARISON_KEYS = [
    "suite",
    "scenario",
    "preset",
    "renderer",
    "controller",
    "metric",
    "better",
    "tracker",
    "other",
    "difference",
    "ci_low",
    "ci_high",
    "p",
    "p_holm",
    "n",
]


def _named(condition: Condition, metric: Metric) -> dict[str, Any]:
    suite_name, scenario, preset, renderer, controller = condition
    names = {
        "suite": suite_name,
        "scenario": scenario,
        "preset": preset,
        "renderer": renderer,
        "metric": metric.name,
        "better": metric.better,
    }
    return {**names, "controller": controller} if controller else names
