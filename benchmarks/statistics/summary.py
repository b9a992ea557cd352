"""From rows to ``summary.json`` and ``comparisons.json``, and the comparison of two trackers.

Both files are lists of objects. Those of ``summary.json`` are about one metric of one tracker:

======================  =====================================================================================
``suite``               name of the suite
``scenario``            catalogue id; ``real`` for recordings
``preset``              of the scenario; name of a recording or of a folder of sequences
``tracker``             name of the tracker
``role``                of the tracker, see ``frameout list``; in the suite ``follow`` of the controller
``renderer``            ``raster`` or ``pybullet``; ``real`` for recordings
``controller``          name of the one that steered; absent on a set path
``link``                suite ``follow`` alone: how commands reach the carrier
``real_time_hz``        pictures a second, in real time alone, see ``run.real_time``
``metric``              name of the metric
``unit``                of the numbers; fractions are 0 to 1
``better``              ``higher`` or ``lower``
``mean``                the metric's statistic over all rows; null if undefined
``ci_low``, ``ci_high``  ends of its 95 % bootstrap interval over seeds
``n``                   number of seeds with a value
======================  =====================================================================================

Those of ``comparisons.json`` are about one metric of two trackers, on the seeds that both ran on; where no tracker is
``ours``, the first by name of the role ``external`` is compared. In the suite ``follow`` pairs that differ in one of
controller and tracker are compared: ours and policies minus each other controller with the same tracker, and our
tracker minus each other one with the same controller. Beside columns of the summary they have:

======================  =====================================================================================
``tracker``             name of the tracker that is compared with others
``compared``            suite ``follow`` alone: what differs, ``controller`` or ``tracker``
``other``               name of the other one
``difference``          its metric minus the other's
``ci_low``, ``ci_high``  ends of the paired 95 % bootstrap interval over seeds
``p``                   two-sided, of a paired permutation test
``p_holm``              the same, corrected for all comparisons of this tracker with others of that kind
======================  =====================================================================================
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import REAL, Row, event_of, read_rows, rounded
from benchmarks.contract.suite import Condition, EventTest, Name, suite
from benchmarks.statistics import bootstrap as statistics
from trackers.atomic_file import write_atomic

SUMMARY_FILE_NAME = "summary.json"
COMPARISONS_FILE_NAME = "comparisons.json"

_WHERE = ("renderer", "controller", "link", "real_time_hz")
_COMPARED_ROLES = ("ours", "policy")
_OWN_ROLE = "external"
"""Role of a user's own tracker or controller."""

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


def read_entries(directory: Path, file_name: str) -> list[dict[str, Any]]:
    """Return what one of both files holds; files that are missing are made from the directory's rows."""
    if not (directory / file_name).is_file():
        write_summary(directory)
    entries: list[dict[str, Any]] = json.loads((directory / file_name).read_text())
    return entries


def grouped(rows: Iterable[Row]) -> Groups:
    """Return rows by condition and tracker, named by ``label_of``."""
    groups: Groups = defaultdict(lambda: defaultdict(list))
    for row in rows:
        groups[condition_of(row)][label_of(row)].append(row)
    return {condition: dict(by_label) for condition, by_label in groups.items()}


def by_condition(entries: Iterable[dict[str, Any]]) -> dict[Condition, list[dict[str, Any]]]:
    """Return entries of the summary or of the comparisons by their condition."""
    found: dict[Condition, list[dict[str, Any]]] = defaultdict(list)
    for entry in entries:
        found[condition_of(entry)].append(entry)
    return dict(found)


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
            entries.append(
                {
                    **_of(rows[0], "suite", "scenario", "preset", "tracker", "role", *_WHERE),
                    "metric": metric.name,
                    "unit": metric.unit,
                    "better": metric.better,
                    "mean": rounded(pool.mean),
                    "ci_low": rounded(low),
                    "ci_high": rounded(high),
                    "n": pool.seed_count,
                }
            )
    return entries


def _of(row: Row, *columns: str) -> dict[str, Any]:
    """Return the columns that a row has, in order."""
    return {column: row[column] for column in columns if row.get(column)}


def by_seed(rows: Sequence[Row], metric: Metric) -> dict[int, float]:
    """Return a metric of each episode alone, by seed, of the rows of one tracker under one condition; without those in
    which it is undefined.
    """
    pool = metric.statistic.pooled(rows)
    if pool is None:
        return {}
    values = pool.value(np.eye(len(pool.seeds)))
    return {int(seed): float(value) for seed, value in zip(pool.seeds, values, strict=True) if np.isfinite(value)}


def episode_names(by_label: Mapping[str, Sequence[Row]]) -> dict[int, str]:
    """Return seed → name of the episodes under one condition: the seed, or that of the real sequence."""
    rows = (row for some in by_label.values() for row in some)
    names = {row["seed"]: row.get("sequence", str(row["seed"])) for row in rows}
    return dict(sorted(names.items()))


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
    judged, own = suite(condition[0]), by_label[label]
    kept = [each for each in judged.key_columns if each != key]
    others = [
        rows
        for other, rows in by_label.items()
        if other != label and all(rows[0][each] == own[0][each] for each in kept)
    ]
    entries = []
    for rows, metric in product(others, map(judged.metric, judged.compared_in(condition[1]))):
        if (found := paired(own, rows, metric)) is not None:
            entries.append(
                {
                    **_of(own[0], "suite", "scenario", "preset", *_WHERE),
                    "metric": metric.name,
                    "better": metric.better,
                    "tracker": own[0]["tracker"],
                    **({"compared": key} if kept else {}),
                    "other": rows[0][key],
                    "difference": rounded(found.difference),
                    "ci_low": rounded(found.ci_low),
                    "ci_high": rounded(found.ci_high),
                    "p": rounded(found.p),
                    "p_holm": found.p,
                    "n": found.n,
                }
            )
    adjusted = statistics.holm(np.array([entry["p"] for entry in entries]))
    for entry, p_holm in zip(entries, adjusted, strict=True):
        entry["p_holm"] = rounded(float(p_holm))
    return entries


def paired(first: Sequence[Row], second: Sequence[Row], metric: Metric) -> statistics.Comparison | None:
    """Return the paired comparison in one metric, None where one of the two has no rows of it."""
    own, others = metric.statistic.pooled_pair(first, second)
    if own is None or others is None or len(np.intersect1d(own.seeds, others.seeds)) == 0:
        return None
    comparison = statistics.compare(own, others)
    return comparison if np.isfinite(comparison.difference) else None


def by_attribute(first: Sequence[Row], second: Sequence[Row]) -> list[tuple[str, Metric, statistics.Comparison, float]]:
    """Return (attribute of the event, metric, comparison, p after Holm) of rows of two trackers: where is one better?

    All rows are of one suite, whose ``events`` name the attributes.
    """
    judged = suite(first[0]["suite"])
    words = judged.events
    compared = tuple(map(judged.metric, judged.compared_in(first[0]["scenario"])))
    in_sequences = first[0]["scenario"] == REAL and judged.on_sequences is not None
    of_episodes = compared if in_sequences else words.episodes or (() if words.tests else compared)
    pairs = [("whole episodes", metric, first, second) for metric in of_episodes]
    for (attribute, is_one), metric in product(words.tests.items(), words.compared):
        pairs.append((attribute, metric, _about(first, is_one), _about(second, is_one)))
    tried = [(name, metric, paired(one, other, metric)) for name, metric, one, other in pairs if one and other]
    found = [(name, metric, comparison) for name, metric, comparison in tried if comparison is not None]
    adjusted = statistics.holm(np.array([comparison.p for _, _, comparison in found]))
    return [(*each, float(p)) for each, p in zip(found, adjusted, strict=True)]


def _about(rows: Sequence[Row], is_one: EventTest) -> list[Row]:
    return [row for row in rows if (event := event_of(row)) is not None and is_one(event)]
