"""Agreement of the ranks of trackers on real sequences with those in simulated episodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

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
    # scipy.stats takes longer to import than all of bench, which needs it for runs on real pictures alone.
    from scipy.stats import kendalltau

    assert suite.on_sequences is not None
    ours = [entry for entry in real if entry["suite"] == suite.name and entry["scenario"] == REAL]
    others = [entry for entry in simulated if entry["suite"] == suite.name and entry["scenario"] != REAL]
    lines: list[str] = []
    for metric in suite.on_sequences.headline:
        pairs = (
            product(_means(ours, metric).items(), _means(others, metric).items()) if metric != "frames_per_s" else ()
        )
        for (where, first), (elsewhere, second) in pairs:
            both = [name for name in first if name in second]
            values = [[means[name] for name in both] for means in (first, second)]
            if len(both) < _LEAST_TRACKERS or any(len(set(each)) == 1 for each in values):
                continue
            tau, p = kendalltau(*values)
            lines.append(
                f"{metric}, {where} and {elsewhere}: Kendall's tau {tau:.2f} (p {p:.2f}, {len(both)} trackers)"
            )
            for title, means in (("real", first), ("simulated", second)):
                best = sorted(both, key=means.__getitem__, reverse=suite.metric(metric).better == "higher")
                lines.append(f"  {title}: {', '.join(f'{name} {means[name]:.3g}' for name in best)}")
    return lines or ["no ranks to compare: they need three trackers that have run on both, and figures that differ"]


def _means(entries: Sequence[Mapping[str, Any]], metric: str) -> dict[str, dict[str, float]]:
    """Return the means of a metric by condition, in words, and tracker."""
    found: dict[str, dict[str, float]] = {}
    for entry in entries:
        if entry["metric"] == metric and entry["mean"] is not None:
            words = [entry["scenario"], entry["preset"], entry["renderer"], entry.get("controller")]
            where = " ".join(dict.fromkeys(filter(None, words)))
            found.setdefault(where, {})[entry["tracker"]] = entry["mean"]
    return found
