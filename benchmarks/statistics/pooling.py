"""Statistics beside the mean: each takes the rows of one tracker to one number, as a function of sums over seeds.

Add one of your own as a subclass of ``contract.metric.Statistic``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.metric import Mean, Parts, PooledRatios, Quantity, Statistic, collected, mean_parts
from benchmarks.contract.rows import Row
from benchmarks.statistics import average_precision, froc, long_term
from sim.checks import check


class GeometricMean(Mean):
    """Root of the product of the means of two quantities."""

    formula = "√(mean of {0} × mean of {1})"

    def finish(self, means: NDArray[np.float64]) -> NDArray[np.float64]:
        """See ``Mean``."""
        return np.sqrt(means[..., 0] * means[..., 1])


class RatioOfMeans(Mean):
    """The mean of the first quantity over that of the second."""

    formula = "mean of {0} / mean of {1}"

    def __init__(self, *quantities: Quantity, kind: str | None = None, high: float = inf) -> None:
        """``high``: the greatest value there is; 1 for a part of a whole."""
        super().__init__(*quantities, kind=kind)
        self.ends = (0.0, high)

    def finish(self, means: NDArray[np.float64]) -> NDArray[np.float64]:
        """See ``Mean``."""
        return means[..., 0] / means[..., 1]


class BestF(Mean):
    """The greatest F over confidences of the mean curves of precision and recall, see ``long_term``."""

    formula = "the greatest 2 P R / (P + R) over confidences of the mean curves P = {0} and R = {1}"

    def finish(self, means: NDArray[np.float64]) -> NDArray[np.float64]:
        """See ``Mean``."""
        curves = np.split(means, 2, axis=-1)
        best = long_term.best_f_score(*curves)[..., None]
        return self._of(*(np.take_along_axis(curve, best, -1)[..., 0] for curve in curves))

    def _of(self, precision: NDArray[np.float64], recall: NDArray[np.float64]) -> NDArray[np.float64]:
        return long_term.f_score(precision, recall)


class BestPrecision(BestF):
    """The precision at the confidence where F is greatest."""

    formula = "mean of {0} at the confidence at which F of the mean curves {0} and {1} is greatest"

    def _of(self, precision: NDArray[np.float64], recall: NDArray[np.float64]) -> NDArray[np.float64]:
        return precision


class BestRecall(BestF):
    """The recall at the confidence where F is greatest."""

    formula = "mean of {1} at the confidence at which F of the mean curves {0} and {1} is greatest"

    def _of(self, precision: NDArray[np.float64], recall: NDArray[np.float64]) -> NDArray[np.float64]:
        return recall


class OfCounts(Statistic):
    """``sum_k p_k C_k / sum_k q_k C_k`` of the sums C of some counts, e.g. of right, wrong and missed frames."""

    ends = (0.0, 1.0)

    def __init__(
        self, formula: str, above: Sequence[float], below: Sequence[float], *of: Quantity, kind: str | None = None
    ) -> None:
        """``above`` and ``below``: factors p and q of the quantities ``of``."""
        super().__init__(*of, kind=kind)
        self.formula, self._above, self._below = formula, above, below

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """See ``Statistic``."""
        of_rows = [row["seed"] for some in chosen for row in some]
        values = np.array([[row["value"]] for some in chosen for row in some], dtype=float)
        lengths = [len(some) for some in chosen]
        numerators, denominators = (
            values * np.repeat(factors, lengths)[:, None] for factors in (self._above, self._below)
        )
        return collected(seeds, [(of_rows, numerators, denominators)], lambda ratios: ratios[..., 0])


_SUMS = "of the sums A of {0}, B of {1}, C of {2}"


def precision_of(*counts: Quantity) -> OfCounts:
    """Return ``A / (A + B)`` of right, wrong and missed frames."""
    return OfCounts("A / (A + B) of the sums A of {0}, B of {1}", (1, 0, 0), (1, 1, 0), *counts)


def recall_of(*counts: Quantity) -> OfCounts:
    """Return ``A / (A + C)`` of right, wrong and missed frames."""
    return OfCounts("A / (A + C) of the sums A of {0}, C of {2}", (1, 0, 0), (1, 0, 1), *counts)


def f_of(*counts: Quantity) -> OfCounts:
    """Return ``2 P R / (P + R) = 2 A / (2 A + B + C)`` of right, wrong and missed frames."""
    return OfCounts(f"2 A / (2 A + B + C) {_SUMS}", (2, 0, 0), (2, 1, 1), *counts)


def detection_f1_of(*counts: Quantity, kind: str | None = None) -> OfCounts:
    """Return the same with ``R = A / (A + B + C)``, see ``judges.stereo.metrics.people``; ``kind``: of events."""
    return OfCounts(f"2 A / (2 A + 2 B + C) {_SUMS}", (2, 0, 0), (2, 2, 1), *counts, kind=kind)


class Median(Statistic):
    """The median of the values, one for each row: the mean of lower and upper median."""

    formula = "median of {0}"

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """See ``Statistic``."""
        grid = np.unique(np.array([row["value"] for some in chosen for row in some], dtype=float))

        def finish(below: NDArray[np.float64]) -> NDArray[np.float64]:
            return self._of([_median(each, grid) for each in np.split(below, len(chosen), axis=-1)])

        return collected(seeds, [_indicator_parts(some, grid) for some in chosen], finish)

    def _of(self, medians: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        return medians[0]


class DifferenceOfMedians(Median):
    """The median of the first quantity minus that of the second."""

    formula = "median of {0} − median of {1}"
    ends = (-inf, inf)

    def _of(self, medians: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        return medians[0] - medians[1]


def _indicator_parts(rows: Sequence[Row], grid: NDArray[np.float64]) -> Parts:
    """Return ``a_g = [value <= grid_g], b_g = 1``: ratios are the distribution function on the grid."""
    numbers = np.array([row["value"] for row in rows], dtype=float)[:, None]
    below = (numbers <= grid).astype(float)
    return [row["seed"] for row in rows], below, np.ones_like(below)


def _median(below: NDArray[np.float64], grid: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean of lower and upper median: half of the values are <= the one, half >= the other."""
    lower = grid[np.argmax(below >= 0.5 - 1e-12, axis=-1)]
    upper = grid[np.argmax(below > 0.5 + 1e-12, axis=-1)]
    return np.where(np.isnan(below[..., -1]), np.nan, 0.5 * (lower + upper))


class RestrictedMean(Statistic):
    """The area under the Kaplan-Meier curve of times in frames, from 0 to a horizon; a time of null is censored.

    It is in frames, or in seconds where a third quantity gives the frames a second.
    """

    def __init__(self, horizon_frames: int, times: Quantity, watched: Quantity, *rate_hz: Quantity) -> None:
        """``watched``: frames after which a time of null is censored. ``horizon_frames``: also used for never."""
        super().__init__(times, watched, *rate_hz)
        self._horizon_frames, self.ends = horizon_frames, (0.0, horizon_frames)
        words = f"area under the Kaplan-Meier curve of {{0}}, censored at {{1}}, from 0 to {horizon_frames} frames"
        self.formula = words

    def _counts(self, row: Row) -> bool:
        return row["value"] is not None or row["metric"] == self.of[0].name

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """See ``Statistic``. Ratios are the hazards of Kaplan-Meier."""
        times, watched, *rates = chosen
        rates_hz = {row["value"] for rows in rates for row in rows}
        check("rate_hz", len(rates_hz) <= 1, "one rate of all that is pooled or compared", sorted(rates_hz))
        frames_per_unit = rates_hz.pop() if rates else 1.0
        steps = np.arange(self._horizon_frames)
        never = np.array([row["value"] is None for row in times])
        ends = np.array([w["value"] if t["value"] is None else t["value"] for t, w in zip(times, watched, strict=True)])
        # a_t = [recovered at step t], b_t = [not recovered and watched until step t]
        found = ((ends[:, None] == steps) & ~never[:, None]).astype(float)
        parts = [row["seed"] for row in times], found, (ends[:, None] >= steps).astype(float)
        return collected(seeds, [parts], lambda hazards: still_waiting(hazards).sum(axis=-1) / frames_per_unit)


def still_waiting(hazards: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Kaplan and Meier's ``S(t) = prod_{u <= t} (1 - h_u)`` (..., T) of hazards h (..., T), ``h_u = d_u / n_u``:
    d_u found at frame u among the n_u still missing; NaN (nothing is missing) leaves S unchanged.

    Its sum over t is the restricted mean. (statsmodels computes one curve a call, not one for each of thousands of
    resamples; the tests compare this function with it.)
    """
    return np.asarray(np.cumprod(1.0 - np.nan_to_num(hazards), axis=-1))


class Froc(Statistic):
    """The share found with at most so many false alarms an hour, see ``froc``; over a range of them the mean of it on a
    log axis.
    """

    ends = (0.0, 1.0)

    def __init__(self, *curve: Quantity, low: float | None = None, high: float) -> None:
        """See ``Statistic``.

        Args:
            curve: what was found and what could be, false alarms, and hours; all but the last are series over
                thresholds.
            low, high: ends of the range of false alarms an hour; without ``low`` the share at ``high``.
        """
        super().__init__(*curve)
        self._low, self._high = low, high
        at = f"{high:g}" if low is None else f"a, its mean over log a from {low:g} to {high:g}"
        self.formula = f"the largest Σ {{0}} / Σ {{1}} at any threshold with Σ {{2}} / Σ {{3}} at most {at}"

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """See ``Statistic``. Ratios are the shares found, then the alarms an hour, at each threshold."""
        return collected(seeds, froc_parts(chosen), self._of)

    def _of(self, counts: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._low is None:
            return froc.found_at(counts, self._high)
        return froc.area(counts, self._low, self._high)


class FrocAtATenth(Statistic):
    """Of a pair alone: the share that the first finds with at most a tenth of the false alarms an hour that the second
    raises where it decides, minus what that finds there.
    """

    formula = "Σ {0} / Σ {1} over thresholds, with at most a tenth of the other's {4}, − the other's mean of {5}"
    ends = (-1.0, 1.0)

    def pooled(self, rows: Sequence[Row]) -> None:
        """See ``Statistic``. It is of a pair alone."""
        return

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """See ``Statistic``. The second tracker's: what it finds where it decides."""
        *curve, raised, decided = chosen
        parts = [*froc_parts(curve), mean_parts(raised), mean_parts(decided)]
        return collected(seeds, parts, lambda ratios: ratios[..., -1])

    def pooled_pair(
        self, first: Sequence[Row], second: Sequence[Row]
    ) -> tuple[PooledRatios | None, PooledRatios | None]:
        """See ``Statistic``; of the seeds that both ran on."""
        both = np.intersect1d([row["seed"] for row in first], [row["seed"] for row in second])

        def of_both(rows: Sequence[Row]) -> list[list[Row]]:
            return [[row for row in self.chosen(rows, each) if row["seed"] in both] for each in self.of]

        own, others = of_both(first), of_both(second)
        own[4] = others[4]
        if not (all(own) and all(others)):
            return None, None
        found = self.ratios(both, own)
        tenth = replace(found, finish=lambda ratios: froc.found_at(ratios[..., :-2], 0.1 * ratios[..., -2:-1]))
        return tenth, self.ratios(both, others)


def froc_parts(chosen: Sequence[Sequence[Row]]) -> list[Parts]:
    """Return the parts of found over findable, then of alarms over hours."""
    found, findable, alarms, hours = chosen
    return [_sum_parts(found, findable), _sum_parts(alarms, hours)]


class AveragePrecision(Statistic):
    """See ``average_precision``; of series over thresholds of boxes that are right and of all that count, and of the
    number of true boxes.
    """

    formula = "mean over recalls Σ {0} / Σ {2} of the greatest precision Σ {0} / Σ {1} with as much recall"
    ends = (0.0, 1.0)

    def ratios(self, seeds: NDArray[np.int64], chosen: Sequence[Sequence[Row]]) -> PooledRatios:
        """See ``Statistic``."""
        right, counted, true = chosen
        return collected(seeds, [_sum_parts(right, true), _sum_parts(right, counted)], average_precision.average)


def _sum_parts(above: Sequence[Row], below: Sequence[Row]) -> Parts:
    """Return ``a = value of the one kind, b = value of the other`` of the same seeds: ratios are those of the sums."""
    numerators, denominators = (
        np.array([np.atleast_1d(row["value"]) for row in rows], float) for rows in (above, below)
    )
    return [row["seed"] for row in above], numerators, np.broadcast_to(denominators, numerators.shape)
