"""Paired differences by attribute of the frame-out: where is one tracker better than another?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.records import Row
from benchmarks.statistics import Comparison, holm
from benchmarks.suites import Metric
from benchmarks.summary import paired

COMPARED = {
    metric.name: metric
    for metric in (
        Metric("recovered", "on the car within 5 frames", "fraction", "higher", ("recovered",)),
        Metric("kept", "and still one second later", "fraction", "higher", ("kept",)),
        Metric("reentry_error_m", "error on the last frame outside", "m", "lower", ("reentry_error_m",)),
    )
}
_LENGTHS = (1, 16, 31, 61, 121, 1_000_000)

FrameOutTest = Callable[[dict[str, Any]], bool]


def attributes() -> dict[str, FrameOutTest]:
    """Return what frame-outs are divided by: a name in words, and the test whether a frame-out is one."""
    tests: dict[str, FrameOutTest] = {
        "all": lambda frame_out: True,
        "on the road": lambda frame_out: frame_out["kind"] == "road",
        "off the road": lambda frame_out: frame_out["kind"] == "excursion",
        "with a turn": lambda frame_out: bool(frame_out["turned"]),
        "without a turn": lambda frame_out: not frame_out["turned"],
    }
    for side in ("left", "right", "top", "bottom"):
        tests[f"left by the {side}"] = _is_by(side)
    for low, high in pairwise(_LENGTHS):
        name = f"{low} to {high - 1} frames" if high < _LENGTHS[-1] else f"{low} frames and more"
        tests[name] = _lasts(low, high)
    return tests


def _is_by(side: str) -> FrameOutTest:
    return lambda frame_out: bool(frame_out["side"] == side)


def _lasts(low: int, high: int) -> FrameOutTest:
    return lambda frame_out: bool(low <= frame_out["length_frames"] < high)


def by_attribute(first: Sequence[Row], second: Sequence[Row]) -> list[tuple[str, str, Comparison, float]]:
    """Return (attribute, metric, comparison, p after Holm) for all attributes and metrics both trackers
    have rows of.
    """
    found = []
    for attribute, is_one in attributes().items():
        mine, others = (
            [row for row in rows if row["frame_out"] and is_one(row["frame_out"])] for rows in (first, second)
        )
        if not mine or not others:
            continue
        for metric in COMPARED.values():
            comparison = paired(mine, others, metric)
            if comparison is not None:
                found.append((attribute, metric.name, comparison))
    adjusted = holm(np.array([comparison.p for _, _, comparison in found]))
    return [(*each, float(p)) for each, p in zip(found, adjusted, strict=True)]
