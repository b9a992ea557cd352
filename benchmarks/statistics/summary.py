"""From rows to ``summary.json`` and ``comparisons.json``.

``summary.json`` is a list of ``{"suite", "scenario", "preset", "tracker", "role", "renderer", "metric",
"unit", "better", "mean", "ci_low", "ci_high", "n"}``: 95 % bootstrap over seeds, ``n`` of which contribute
to the metric. Entries of runs in which a controller steered carry ``controller`` too. In the suite ``follow`` pairs of
``controller`` and ``tracker`` are compared, entries carry ``link``, and ``role`` is the controller's.

``comparisons.json`` is a list of ``{"suite", "scenario", "preset", "renderer", "metric", "better", "tracker",
"other", "difference", "ci_low", "ci_high", "p", "p_holm", "n"}`` (and ``controller``): tracker minus other, on the
seeds both ran on. ``p_holm`` is corrected for all comparisons of one (suite, scenario, preset, renderer,
controller): every other tracker times every compared metric. Where no tracker is ``ours``, ``tracker`` is the first
by name of the role ``external``. Entries of the suite ``follow`` carry ``link`` and
``compared`` too, the kind of ``other``: ``controller`` (ours and policies minus each other one, with the same
tracker) or ``tracker`` (ours minus each other one, with the same controller); ``p_holm`` is corrected for one
tracker's comparisons with others of that kind.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import Row, read_rows, rounded
from benchmarks.contract.suite import Condition, Name, suite
from benchmarks.statistics import bootstrap as statistics
from trackers.atomic_file import write_atomic

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
    write_atomic(directory / SUMMARY_FILE_NAME, json.dumps(summary, indent=1) + "\n")
    comparisons = compare_ours(groups)
    write_atomic(directory / COMPARISONS_FILE_NAME, json.dumps(comparisons, indent=1) + "\n")
    return summary


def read_summary(directory: Path) -> list[dict[str, Any]]:
    """Return the summary of the rows in a directory. Raises ValueError if it holds no records."""
    return summarise(grouped(read_rows(directory)))


def grouped(rows: Iterable[Row]) -> Groups:
    """Return rows by condition and tracker, named by ``label_of``."""
    groups: Groups = defaultdict(lambda: defaultdict(list))
    for row in rows:
        groups[condition_of(row)][label_of(row)].append(row)
    return {condition: dict(by_label) for condition, by_label in groups.items()}


def condition_of(row: Mapping[str, Any]) -> Condition:
    """Return the condition of a row, or of an entry of the summary or the comparisons."""
    steering = row.get(_steering_key(row["suite"])) or ""
    return row["suite"], row["scenario"], row["preset"], row["renderer"], steering


def label_of(row: Mapping[str, Any]) -> str:
    """Return the name of the tracker of a row or an entry: the tracker's, or ``CONTROLLER+TRACKER``."""
    return "+".join(suite(row["suite"]).names_of(row))


def steering_words(condition: Condition) -> str:
    """Return how the camera is steered, in words."""
    if suite(condition[0]).judges_controllers:
        return f"{condition[4]} link"
    return f"steered by {condition[4]}" if condition[4] else "set path"


def _steering_key(suite_name: str) -> str:
    return "link" if suite(suite_name).judges_controllers else "controller"


def summarise(groups: Groups) -> list[dict[str, Any]]:
    """Return the list of ``summary.json``."""
    entries = []
    for condition, by_label in groups.items():
        for rows, metric in product(by_label.values(), suite(condition[0]).metrics):
            pool = metric.statistic.pooled(rows)
            if pool is None or pool.seed_count == 0:
                continue
            low, high = statistics.bootstrap_interval(pool)
            entry = {
                **_named(condition, metric, rows[0]),
                "role": rows[0]["role"],
                "unit": metric.unit,
                "mean": rounded(pool.mean),
                "ci_low": rounded(low),
                "ci_high": rounded(high),
                "n": pool.seed_count,
            }
            entries.append({key: entry[key] for key in SUMMARY_COLUMNS if key in entry})
    return entries


def compare_ours(groups: Groups) -> list[dict[str, Any]]:
    """Return the list of ``comparisons.json``: the tracker with role ``ours`` against every other one.

    Where none is ours, the first by name of a user's own takes its place. Where controllers are trackers, pairs that
    differ in one of the two names are compared.
    """
    entries = []
    for condition, by_label in groups.items():
        for key in suite(condition[0]).key_columns:
            roles = {label: _role_of(rows[0], key) for label, rows in by_label.items()}
            own = min((by_label[label][0][key] for label, role in roles.items() if role == _OWN_ROLE), default=None)
            for label, rows in by_label.items():
                if roles[label] in _COMPARED_ROLES or ("ours" not in roles.values() and rows[0][key] == own):
                    entries += _compare_along(key, condition, by_label, label)
    return entries


def _role_of(row: Row, key: Name) -> str:
    """Return the role of the tracker or controller in a row."""
    role: str = row["tracker_role"] if key == "tracker" and "tracker_role" in row else row["role"]
    return role


def _compare_along(
    key: Name, condition: Condition, by_label: Mapping[str, Sequence[Row]], label: str
) -> list[dict[str, Any]]:
    """Return a tracker's comparisons with those that differ from it in one name, corrected for their number."""
    judged, mine = suite(condition[0]), by_label[label]
    kept = [each for each in judged.key_columns if each != key]
    others = [
        rows
        for other, rows in by_label.items()
        if other != label and all(rows[0][each] == mine[0][each] for each in kept)
    ]
    entries = []
    for rows, metric in product(others, map(judged.metric, judged.compared_in(condition[1]))):
        if (comparison := paired(mine, rows, metric)) is not None:
            entries.append(
                {
                    **_named(condition, metric, mine[0]),
                    **({"compared": key} if kept else {}),
                    "other": rows[0][key],
                    **{name: rounded(value) for name, value in asdict(comparison).items()},
                    "n": comparison.n,
                }
            )
    adjusted = statistics.holm(np.array([entry["p"] for entry in entries]))
    for entry, p_holm in zip(entries, adjusted, strict=True):
        entry["p_holm"] = rounded(float(p_holm))
    return [{key: entry[key] for key in COMPARISON_COLUMNS if key in entry} for entry in entries]


def paired(first: Sequence[Row], second: Sequence[Row], metric: Metric) -> statistics.Comparison | None:
    """Return the paired comparison in one metric, None where one of the two has no rows of it."""
    mine, others = metric.statistic.pooled_pair(first, second)
    if mine is None or others is None or len(np.intersect1d(mine.seeds, others.seeds)) == 0:
        return None
    comparison = statistics.compare(mine, others)
    return comparison if np.isfinite(comparison.difference) else None


_COMPARED_ROLES = ("ours", "policy")
_OWN_ROLE = "external"
"""Role of a user's own tracker or controller."""
_OF_CONDITION = {
    "suite": "name of the suite",
    "scenario": "catalogue id; `real` for recordings",
    "preset": "of the scenario; name of a recording or of a folder of sequences",
}
SUMMARY_COLUMNS = {
    **_OF_CONDITION,
    "tracker": "name of the tracker",
    "role": "of the tracker, see `frameout list`; in the suite `follow` of the controller",
    "renderer": "`raster` or `pybullet`; `real` for recordings",
    "controller": "name of the one that steered; absent on a set path",
    "link": "suite `follow` alone: how commands reach the carrier",
    "metric": "name of the metric",
    "unit": "of the numbers; fractions are 0 to 1",
    "better": "`higher` or `lower`",
    "mean": "the metric's statistic over all rows; null if undefined",
    "ci_low": "lower end of its 95 % bootstrap interval over seeds",
    "ci_high": "upper end",
    "n": "number of seeds with a value",
}
"""Column of ``summary.json`` -> its meaning."""
COMPARISON_COLUMNS = {
    **_OF_CONDITION,
    "renderer": SUMMARY_COLUMNS["renderer"],
    "controller": SUMMARY_COLUMNS["controller"],
    "link": SUMMARY_COLUMNS["link"],
    "metric": "name of the metric",
    "better": "`higher` or `lower`",
    "tracker": "name of the tracker that is compared with others",
    "compared": "suite `follow` alone: what differs, `controller` or `tracker`",
    "other": "name of the other one",
    "difference": "its metric minus the other's, on the seeds that both ran on",
    "ci_low": "lower end of the paired 95 % bootstrap interval over seeds",
    "ci_high": "upper end",
    "p": "two-sided, of a paired permutation test",
    "p_holm": "the same, corrected for all comparisons of this tracker",
    "n": "number of seeds",
}
"""Column of ``comparisons.json`` -> its meaning."""


def _named(condition: Condition, metric: Metric, row: Row) -> dict[str, Any]:
    suite_name, scenario, preset, renderer, steering = condition
    names = {"suite": suite_name, "scenario": scenario, "preset": preset, "renderer": renderer}
    names |= {"metric": metric.name, "better": metric.better}
    names |= {key: row[key] for key in suite(suite_name).key_columns}
    return {**names, _steering_key(suite_name): steering} if steering else names
