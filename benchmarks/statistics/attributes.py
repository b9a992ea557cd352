"""Paired differences by attribute of the event: where is one tracker better than another?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.contract.metric import Metric
from benchmarks.contract.rows import REAL, Row, event_of
from benchmarks.contract.suite import EventTest, suite
from benchmarks.statistics.bootstrap import Comparison, holm
from benchmarks.statistics.summary import paired


def by_attribute(first: Sequence[Row], second: Sequence[Row]) -> list[tuple[str, Metric, Comparison, float]]:
    """Return (attribute, metric, comparison, p after Holm) for all attributes and metrics of rows of both trackers.

    All rows are of one suite, whose ``events`` name the attributes.
    """
    judged = suite(first[0]["suite"])
    words = judged.events
    compared = tuple(map(judged.metric, judged.compared_in(first[0]["scenario"])))
    in_sequences = first[0]["scenario"] == REAL and judged.on_sequences is not None
    of_episodes = compared if in_sequences else words.episodes or (() if words.tests else compared)
    whole = [("whole episodes", metric, paired(first, second, metric)) for metric in of_episodes]
    found = [(name, metric, comparison) for name, metric, comparison in whole if comparison is not None]
    for attribute, is_one in words.tests.items():
        own, others = (_about(rows, is_one) for rows in (first, second))
        if not own or not others:
            continue
        for metric in words.compared:
            comparison = paired(own, others, metric)
            if comparison is not None:
                found.append((attribute, metric, comparison))
    adjusted = holm(np.array([comparison.p for _, _, comparison in found]))
    return [(*each, float(p)) for each, p in zip(found, adjusted, strict=True)]


def _about(rows: Sequence[Row], is_one: EventTest) -> list[Row]:
    return [row for row in rows if (event := event_of(row)) is not None and is_one(event)]
