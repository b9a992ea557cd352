"""The leaderboard on the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from benchmarks.suites import Metric, Suite

_WIDTH = 132
_WIDE_ENOUGH_FOR_INTERVALS = 120
_ROLE_STYLES = {"ours": "bold green", "oracle": "italic", "variant": "dim"}


def print_leaderboard(summary: Sequence[dict[str, Any]], suite: Suite) -> None:
    """Print a table for each scenario, preset, renderer and controller: the suite's headline, best tracker
    first.
    """
    console = Console()
    if not console.is_terminal:
        console = Console(width=_WIDTH)
    for title, entries in _conditions(summary):
        console.print(_table(title, entries, suite, console.width >= _WIDE_ENOUGH_FOR_INTERVALS))


def _conditions(summary: Sequence[dict[str, Any]]) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    groups: dict[str, list[dict[str, Any]]] = {}
    for entry in summary:
        steered = f", steered by {entry['controller']}" if "controller" in entry else ""
        title = f"{entry['scenario']}, {entry['preset']}, {entry['renderer']}{steered}"
        groups.setdefault(title, []).append(entry)
    yield from groups.items()


def _table(title: str, entries: Sequence[dict[str, Any]], suite: Suite, intervals: bool) -> Table:
    trackers: dict[str, dict[str, dict[str, Any]]] = {}
    for entry in entries:
        trackers.setdefault(entry["tracker"], {})[entry["metric"]] = entry
    present = {entry["metric"] for entry in entries}
    columns = [suite.metric(name) for name in suite.headline if name in present]
    seeds = max(entry["n"] for entry in entries)
    table = Table(
        title=f"{title}: {seeds} episodes{', 95 % intervals over them' if intervals else ''}", box=box.SIMPLE_HEAD
    )
    table.add_column("tracker", no_wrap=True, min_width=max(map(len, trackers)))
    table.add_column("role", no_wrap=True, min_width=len("as-written"))
    for metric in columns:
        table.add_column(_label(metric), justify="right", min_width=9 if intervals else 5)

    def rank(name: str) -> tuple[float, ...]:
        return tuple(_goodness(trackers[name], metric) for metric in columns)

    for name in sorted(trackers, key=rank, reverse=True):
        role = next(iter(trackers[name].values()))["role"]
        cells = [_cell(trackers[name].get(metric.name), intervals) for metric in columns]
        table.add_row(name, role, *cells, style=_ROLE_STYLES.get(role, ""))
    return table


def _label(metric: Metric) -> str:
    """Return a metric's name in words with its unit and an arrow to the better side."""
    arrow = "↑" if metric.better == "higher" else "↓"
    without_unit = metric.name.removesuffix(f"_{metric.unit}")
    unit = f" ({metric.unit})" if without_unit != metric.name else ""
    return f"{without_unit.replace('_', ' ')}{unit} {arrow}"


def _goodness(metrics: dict[str, dict[str, Any]], metric: Metric) -> float:
    if metric.name not in metrics:
        return -math.inf
    mean = float(metrics[metric.name]["mean"])
    return mean if metric.better == "higher" else -mean


def _cell(entry: dict[str, Any] | None, intervals: bool) -> str:
    if entry is None:
        return "-"
    if not intervals:
        return _number(entry["mean"])
    return f"{_number(entry['mean'])}\n{_number(entry['ci_low'])}-{_number(entry['ci_high'])}"


def _number(value: float | None) -> str:
    if value is None:
        return "?"
    digits = 2 if abs(value) < 10 else 1 if abs(value) < 100 else 0
    return f"{value:.{digits}f}"
