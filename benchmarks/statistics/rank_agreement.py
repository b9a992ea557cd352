"""Agreement of the ranks of trackers on real sequences with those in simulated episodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import REAL
from benchmarks.contract.suite import Suite

_LEAST_TRACKERS = 3
"""Two can only agree or disagree."""


def rank_agreement(
    suite: Suite, real: Sequence[Mapping[str, Any]], simulated: Sequence[Mapping[str, Any]]
) -> list[str]:
    """Return lines of text: for each metric of the real leaderboard both orders and Kendall's tau-b between them.

    Only trackers that have run on both count; there is no line for fewer than three, or where all are equal. Speed is
    left out, as it is the machine's too. tau is 1 for the same order and -1 for the opposite one; p is of no relation.

    Args:
        real, simulated: entries of summaries; those of other suites, and simulated ones among ``real``, are left out.
    """
    assert suite.on_sequences is not None
    ours = [entry for entry in real if entry["suite"] == suite.name and entry["scenario"] == REAL]
    others = [entry for entry in simulated if entry["suite"] == suite.name and entry["scenario"] != REAL]
    lines: list[str] = []
    for name in suite.on_sequences.headline:
        metric = suite.metric(name)
        if metric.name != "frames_per_s":
            for where, first in _by_condition(ours, metric).items():
                for elsewhere, second in _by_condition(others, metric).items():
                    lines += _lines(metric, (where, first), (elsewhere, second))
    return lines or ["no ranks to compare: they need three trackers that have run on both, and figures that differ"]


def _lines(
    metric: Metric, real: tuple[str, Mapping[str, float]], simulated: tuple[str, Mapping[str, float]]
) -> Iterator[str]:
    both = [name for name in real[1] if name in simulated[1]]
    values = [[means[name] for name in both] for _, means in (real, simulated)]
    if len(both) < _LEAST_TRACKERS or any(len(set(each)) == 1 for each in values):
        return
    # scipy.stats takes longer to import than all of bench, which needs it for runs on real pictures alone.
    from scipy.stats import kendalltau

    found = kendalltau(*values)
    tau = f"Kendall's tau {found.statistic:.2f} (p {found.pvalue:.2f}, {len(both)} trackers)"
    yield f"{metric.name}, {real[0]} and {simulated[0]}: {tau}"
    for title, means in (("real", real[1]), ("simulated", simulated[1])):
        order = sorted(both, key=lambda name: means[name], reverse=metric.better == "higher")
        yield f"  {title}: {', '.join(f'{name} {means[name]:.3g}' for name in order)}"


def _by_condition(entries: Sequence[Mapping[str, Any]], metric: Metric) -> dict[str, dict[str, float]]:
    """Return the means of a metric by condition, in words, and tracker."""
    found: dict[str, dict[str, float]] = {}
    for entry in entries:
        if entry["metric"] == metric.name and entry["mean"] is not None:
            words = [entry["scenario"], entry["preset"], entry["renderer"], entry.get("controller")]
            where = " ".join(dict.fromkeys(filter(None, words)))
            found.setdefault(where, {})[entry["tracker"]] = entry["mean"]
    return found
