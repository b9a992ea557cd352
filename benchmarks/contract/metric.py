"""Metrics of a suite, and what holds of the rows that they are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Statistic = Literal[
    "mean",
    "median",
    "geometric mean",
    "ratio of means",
    "precision",
    "recall",
    "f",
    "precision of counts",
    "recall of counts",
    "f of counts",
    "detection f1 of counts",
    "restricted mean",
    "difference of medians",
    "froc",
    "froc at a tenth",
    "average precision",
]


@dataclass(frozen=True, slots=True)
class Metric:
    """One metric of a suite, as it stands in ``summary.json``.

    Attributes:
        name: in the summary. summary: one line of definition. unit: ``fraction``, ``m``, ``px``, ``frames`` …
        better: better direction. rows: metrics of its rows; () = rows of its own name.
        statistic: how rows become one number, see ``benchmarks.statistics.pooling``.
        kind: rows of events of this kind, or with this attribute true, only; None = all.
        horizon_frames: largest time in a restricted mean, also used for never.
        ideal: the right value, of a metric that can be too low and too high, e.g. a coverage.
        alarms_per_hour: one rate of false alarms, or the ends of a range of them, of the statistic ``froc``.
    """

    name: str
    summary: str
    unit: str
    better: Literal["higher", "lower"]
    rows: tuple[str, ...] = ()
    statistic: Statistic = "mean"
    kind: str | None = None
    horizon_frames: int = 60
    ideal: float | None = None
    alarms_per_hour: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", self.rows or (self.name,))


@dataclass(frozen=True, slots=True)
class RowMeaning:
    """What holds of some kinds of rows, beside the formulas in the docstrings of ``Suite.definitions``.

    Attributes:
        rows: their names. low, high: range of their values.
        conditions: which frames, events or episodes count.
        source: where the definition comes from: a paper or a benchmark, or ``OWN``.
    """

    rows: tuple[str, ...]
    low: float
    high: float
    conditions: str
    source: str


OWN = "Frameout"
"""Source of definitions that are made here."""
