"""Metrics: what the rows of a judge are, and how the rows of one tracker become one number.

A *quantity* is what the values of one kind of row are. A *statistic* takes the rows of some quantities to one number. A
*metric* is a statistic with a name, a unit and a better direction. A metric of your own is one object::

    def jitter_px(truth: TruthSeries, estimate: EstimateSeries) -> float:
        "Return the mean step of the estimates in pixels, >= 0."
        ...

    add_metric("frame-out", Metric("jitter_px", "mean step of the estimates", "px", "lower", value=jitter_px))

Its rows are the values of the function, one an episode, and its statistic is their mean unless you give another one.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row, event_of
from sim.checks import check_choice

Better = Literal["higher", "lower"]
OWN = "Frameout"
"""Source of definitions that are made here."""
NOT_STATED = "not stated"

Parts = tuple[list[int], NDArray[np.float64], NDArray[np.float64]]
"""Seed, numerator (D,) and denominator (D,) of each row."""
Finish = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Takes ratios (..., D) to a statistic (...)."""


@dataclass(frozen=True)
class Quantity:
    """What the values of one kind of row are.

    Attributes:
        name: the rows' ``metric``.
        low, high: range of the values.
        conditions: which frames, events or episodes count.
        source: where the definition comes from: a paper or a benchmark, or ``OWN``.
        defined_by: functions, classes and modules whose docstrings define it.
    """

    name: str
    low: float = -inf
    high: float = inf
    conditions: str = NOT_STATED
    source: str = NOT_STATED
    defined_by: tuple[Any, ...] = ()


@dataclass(frozen=True, eq=False)
class PooledRatios:
    """Sums over the rows of each seed; the statistic is a function of the ratios of their sums over seeds.

    Each seed s gives numerators ``a[s]`` and denominators ``b[s]``, both (D,); the ratios are ``sum_s a[s] / sum_s
    b[s]``. So a mean, a geometric mean of two rates, a quantile and the area under a survival curve are all
    bootstrapped over seeds by the same two matrix products.

    Attributes:
        seeds: (S,) sorted.
        numerators, denominators: (S, D).
        finish: takes ratios (..., D) to the statistic (...).
    """

    seeds: NDArray[np.int64]
    numerators: NDArray[np.float64]
    denominators: NDArray[np.float64]
    finish: Finish

    def finished(self, numerators: NDArray[np.float64], denominators: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the statistic (...) of sums (..., D) over seeds; NaN where it is undefined."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return self.finish(numerators / denominators)

    def value(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the statistic (...) with every seed taken ``counts`` (..., S) times; NaN where it is undefined."""
        return self.finished(counts @ self.numerators, counts @ self.denominators)

    @property
    def mean(self) -> float:
        """The statistic over all seeds."""
        return float(self.value(np.ones(len(self.seeds))))

    @property
    def seed_count(self) -> int:
        """Number of seeds that contribute to the statistic."""
        return int((self.denominators.sum(axis=1) > 0).sum())

    def on(self, seeds: NDArray[np.int64]) -> PooledRatios:
        """Return the sums of these seeds alone; all must be known."""
        places = np.searchsorted(self.seeds, seeds)
        return PooledRatios(seeds, self.numerators[places], self.denominators[places], self.finish)


class Statistic(ABC):
    """Takes the rows of one tracker under one condition to one number, as a function of sums over seeds.

    Attributes:
        formula: how the rows make it, with ``{0}``, ``{1}`` … for the names of the quantities.
        of: the quantities of the rows.
        kind: rows of events of this kind, or with this attribute true, only; None = all.
        ends: of the range of the number; None = those of the quantities.
    """

    formula: str
    ends: tuple[float, float] | None = None

    def __init__(self, *of: Quantity, kind: str | None = None) -> None:
        self.of, self.kind = of, kind

    @abstractmethod
    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """Return the sums over the rows of each seed.

        Args:
            seeds: (S,) sorted, of all rows of the tracker. chosen: rows of each quantity, at least one of each.
        """

    def pooled(self, rows: Sequence[Row]) -> PooledRatios | None:
        """Return the sums over the rows of each seed; None without a row of one of the quantities.

        Args:
            rows: of one tracker under one condition. Every seed in them counts, also one without a row of the metric.
        """
        chosen = [self.chosen(rows, quantity) for quantity in self.of]
        return self.ratios(np.unique([row["seed"] for row in rows]), chosen) if all(chosen) else None

    def pooled_pair(
        self, first: Sequence[Row], second: Sequence[Row]
    ) -> tuple[PooledRatios | None, PooledRatios | None]:
        """Return the sums of two trackers that are compared, of the same columns: the rows of both go to ``ratios`` at
        once, so that what the columns depend on, e.g. a grid of all values, is that of both.
        """
        chosen, others = ([self.chosen(rows, each) for each in self.of] for rows in (first, second))
        if not (all(chosen) and all(others)):
            return None, None
        seeds, other_seeds = (np.unique([row["seed"] for row in rows]) for rows in (first, second))
        after = seeds[-1] + 1 - other_seeds[0]
        both = [
            [*own, *(row | {"seed": row["seed"] + after} for row in some)]
            for own, some in zip(chosen, others, strict=True)
        ]
        pool = self.ratios(np.concatenate([seeds, other_seeds + after]), both)
        return pool.on(seeds), replace(pool.on(other_seeds + after), seeds=other_seeds)

    def chosen(self, rows: Sequence[Row], quantity: Quantity) -> list[Row]:
        """Return the rows of a quantity that count: with a value, and of events of the kind."""
        named = (row for row in rows if row["metric"] == quantity.name)
        return [row for row in named if self._counts(row) and (self.kind is None or _is(event_of(row), self.kind))]

    def _counts(self, row: Row) -> bool:
        return row["value"] is not None

    def range(self) -> tuple[float, float]:
        """Return the ends of the range of the number."""
        return self.ends or (min(each.low for each in self.of), max(each.high for each in self.of))

    def words(self) -> str:
        """Return the formula with the names of the rows."""
        return self.formula.format(*(f"`{each.name}`" for each in self.of))

    def of_line(self, suffix: str) -> Self:
        """Return the same statistic of quantities whose names end with ``_SUFFIX``."""
        other = copy.copy(self)
        other.of = tuple(Quantity(f"{each.name}_{suffix}", each.low, each.high) for each in self.of)
        return other


def _is(event: dict[str, Any] | None, kind: str) -> bool:
    return event is not None and (event["kind"] == kind or event.get(kind) is True)


class Mean(Statistic):
    """``sum w v / sum w`` of values v and weights w (the frames that a value is a mean of, else 1)."""

    formula = "Σ w v / Σ w of {0}"

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """See ``Statistic``."""
        return collected(seeds, [mean_parts(some) for some in chosen], self.finish)

    def finish(self, means: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the statistic (...) of the means (..., D) of the quantities, one after the other."""
        return means[..., 0]


def mean_parts(rows: Sequence[Row]) -> Parts:
    """Return ``a = weight * value, b = weight``: ratios are weighted means, series entry by entry."""
    weights = np.array([row["weight"] for row in rows])[:, None]
    numbers = np.array([np.atleast_1d(row["value"]) for row in rows], dtype=float)
    return [row["seed"] for row in rows], weights * numbers, np.broadcast_to(weights, numbers.shape)


def collected(seeds: NDArray[np.int64], parts: Sequence[Parts], finish: Finish) -> PooledRatios:
    """Return the sums of parts over the rows of each seed (S,), the parts side by side."""
    sums: tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]] = ([], [])
    for row_seeds, numerators, denominators in parts:
        places = np.searchsorted(seeds, row_seeds)
        for total, each in zip(sums, (numerators, denominators), strict=True):
            total.append(np.zeros((len(seeds), each.shape[1])))
            np.add.at(total[-1], places, each)
    return PooledRatios(seeds, np.hstack(sums[0]), np.hstack(sums[1]), finish)


class BrokenMetric(ValueError):
    """The function of a metric raised what is the cause, or returned what is no value of it."""


@dataclass(frozen=True, eq=False)
class Metric:
    """One metric of a suite, as it stands in ``summary.json``.

    Attributes:
        name: in the summary. summary: one line of definition. unit: ``fraction``, ``m``, ``px``, ``frames`` …
        better: better direction.
        statistic: how rows become one number; by default the mean of the rows of the metric's name.
        ideal: the right value, of a metric that can be too low and too high, e.g. a coverage.
        value: function of an episode whose values are the rows, of suites that take such functions, NaN where it is
            undefined; None: the judge makes the rows.
    """

    name: str
    summary: str
    unit: str
    better: Better
    statistic: Statistic = None  # type: ignore[assignment]
    ideal: float | None = field(default=None, kw_only=True)
    value: Callable[..., float] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.statistic is None:
            own = Quantity(self.name, 0.0, 1.0 if self.unit == "fraction" else inf)
            object.__setattr__(self, "statistic", Mean(own))
        if self.value is not None:
            check_choice(f"quantity of metric {self.name}", self.name, [each.name for each in self.statistic.of])

    def value_of(self, *episode: Any) -> float:
        """Return ``value`` of an episode; NaN where it is undefined.

        Raises:
            BrokenMetric: if the function raises, and for what is no number in the range of the metric's quantity.
        """
        assert self.value is not None
        own = next(each for each in self.statistic.of if each.name == self.name)
        wanted = f"value of metric {self.name}: expected a number from {own.low:g} to {own.high:g}, or NaN"
        try:
            value = self.value(*episode)
            number = np.asarray(value)
        except Exception as error:
            raise BrokenMetric(f"{wanted}, got {type(error).__name__}: {error}") from error
        is_number = number.ndim == 0 and number.dtype.kind in "biuf"
        if not (is_number and (np.isnan(number) or own.low <= number <= own.high)):
            raise BrokenMetric(f"{wanted}, got {value!r}")
        return float(number)

    @property
    def definitions(self) -> tuple[Any, ...]:
        """Functions, classes and modules whose docstrings define the rows, each once."""
        own = () if self.value is None else (self.value,)
        return tuple(dict.fromkeys([*own, *(thing for each in self.statistic.of for thing in each.defined_by)]))
