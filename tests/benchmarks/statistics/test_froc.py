"""The FROC curve: exact on small cases, and as counted threshold by threshold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.contract.metric import Metric, Quantity
from benchmarks.contract.rows import Row
from benchmarks.statistics import froc
from benchmarks.statistics.pooling import Froc, FrocAtATenth
from benchmarks.statistics.summary import paired

K = len(froc.THRESHOLDS)
CURVE = tuple(map(Quantity, ("froc_found", "froc_findable", "froc_alarms", "watched_hours")))


def at(high: float, low: float | None = None) -> Metric:
    return Metric("found", "", "fraction", "higher", Froc(*CURVE, low=low, high=high))


AREA, AT_10 = at(100.0, low=1.0), at(10.0)


def rows(
    found: list[float], alarms: list[float], *, seed: int = 0, targets: int | None = None, hours: float = 1.0
) -> list[Row]:
    """Return the rows of an episode with the levels of targets found and of alarms."""
    values = {
        "froc_found": froc.reached(np.array(found)).tolist(),
        "froc_findable": [float(len(found) if targets is None else targets)] * K,
        "froc_alarms": froc.reached(np.array(alarms)).tolist(),
        "watched_hours": hours,
    }
    ending = {"suite": "fish", "seed": seed, "weight": 1.0, "event": None}
    return [{"metric": name, "value": value, **ending} for name, value in values.items()]


def value(metric: Metric, of: list[Row]) -> float:
    pool = metric.statistic.pooled(of)
    assert pool is not None
    return pool.mean


def test_thresholds_rise_from_0_to_1() -> None:
    assert (froc.THRESHOLDS[0], froc.THRESHOLDS[-1]) == (0.0, 1.0)
    assert (np.diff(froc.THRESHOLDS) > 0).all()


def test_a_level_reaches_thresholds_up_to_itself() -> None:
    reached = froc.reached(np.array([0.5, 1.0, -np.inf, np.nan]))
    assert (reached == 1.0 + (froc.THRESHOLDS <= 0.5)).all()


def test_steps_of_a_curve() -> None:
    # Ten alarms an hour while one of four is found, none for the surest.
    of = rows([0.9, 0.6, 0.6, 0.2], [0.7] * 10 + [0.3] * 40)
    # 0 alarms: one found. From 10 on three, and since the fourth comes with 50 alarms, from there on all.
    expected = (0.25 * np.log(10) + 0.75 * np.log(5) + 1.0 * np.log(2)) / np.log(100)
    assert value(AREA, of) == pytest.approx(expected)
    assert value(AT_10, of) == 0.75
    assert value(AT_10, rows([0.9, 0.6], [0.7] * 11)) == 0.5
    assert value(AREA, rows([0.9, 0.2], [0.5] * 200)) == 0.5


def test_without_a_threshold_under_the_limit_nothing_is_found() -> None:
    of = rows([1.0], [1.0] * 20)
    assert value(AT_10, of) == 0.0
    assert value(AREA, of) == pytest.approx(np.log(5) / np.log(100))
    assert value(AREA, rows([], [])) == 0.0


def test_alarms_need_not_fall_with_the_threshold() -> None:
    """One alarm of unlike confidences may be several at a higher threshold; then the lower one is the better."""
    alarms = np.where(froc.THRESHOLDS <= 0.3, 4.0, np.where(froc.THRESHOLDS <= 0.6, 20.0, 2.0))
    of = rows([0.9, 0.6, 0.3, 0.1], [])
    of[2]["value"] = alarms.tolist()
    # Above 0.6 one of four is found, up to 0.3 three, and up to 0.1 all.
    for rate, expected in ((1.0, 0.0), (2.0, 0.25), (3.9, 0.25), (4.0, 1.0), (30.0, 1.0)):
        assert value(at(rate), of) == expected
    assert value(AREA, of) == pytest.approx((0.25 * np.log(2.0) + np.log(25.0)) / np.log(100.0))


def test_episodes_add_up_before_the_curve_is_made() -> None:
    # One threshold holds for both: 30 alarms in 2 hours, half of the targets.
    of = [*rows([0.9], [0.9] * 30, seed=0), *rows([], [], seed=1, targets=1)]
    assert value(AT_10, of) == 0.0
    assert value(AREA, of) == pytest.approx(0.5 * np.log(100 / 15) / np.log(100))


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_area_is_the_mean_of_points_on_the_curve(seed: int) -> None:
    rng = np.random.default_rng(seed)
    of = rows(rng.random(20).tolist(), (0.8 * rng.random(300)).tolist(), targets=25, hours=2.0)
    of[2]["value"] = (np.array(of[2]["value"]) + rng.integers(0, 40, K)).tolist()
    at = np.exp(np.linspace(0.0, np.log(100.0), 501)[1:] - 0.5 * np.log(100.0) / 500)
    pool = AREA.statistic.pooled(of)
    assert pool is not None
    counts = (pool.numerators.sum(axis=0) / pool.denominators.sum(axis=0))[None]
    points = [froc.found_at(counts, float(x))[0] for x in at]
    assert value(AREA, of) == pytest.approx(np.mean(points), abs=3e-3)


def decided(found: list[float], alarms: float, *, seed: int = 0, hours: float = 1.0) -> list[Row]:
    """Return the rows of an episode with what a tracker finds and raises where it decides."""
    ending = {"suite": "fish", "seed": seed, "event": None}
    told = [{"metric": "found", "value": each, "weight": 1.0, **ending} for each in found]
    return [*told, {"metric": "false_alarms_per_hour", "value": alarms, "weight": hours, **ending}]


_DECIDED = map(Quantity, ("false_alarms_per_hour", "found"))
TENTH = Metric("tenth", "", "fraction", "higher", FrocAtATenth(*CURVE, *_DECIDED))


def test_one_tracker_with_a_tenth_of_the_alarms_of_another() -> None:
    """The other finds half of four with 40 alarms where it decides, and all of them with 50."""
    other = [*rows([0.9, 0.6, 0.2, 0.2], [0.7] * 40 + [0.3] * 10), *decided([1.0, 1.0, 0.0, 0.0], 40.0)]
    for alarms, expected in ((4, 0.25), (5, -0.25)):
        # Three of four are found with 4 alarms; with one more only that of 0.9 is left at less than 5.
        mine = [*rows([0.9, 0.6, 0.6, 0.1], [0.7] * alarms + [0.3] * 40), *decided([0.0] * 4, 0.0)]
        found = paired(mine, other, TENTH)
        assert found is not None
        assert found.difference == pytest.approx(expected)
    assert TENTH.statistic.pooled(mine) is None


def test_a_tenth_is_one_of_all_alarms_on_the_seeds_of_both() -> None:
    """Hours weigh: 60 alarms in 3 hours are 20 an hour, and 2 of one's own allowed."""
    other = [
        *(row for seed in (0, 1) for row in rows([0.5], [], seed=seed, hours=1.0 + seed)),
        *decided([1.0], 60.0, seed=0, hours=1.0),
        *decided([0.0], 0.0, seed=1, hours=2.0),
    ]
    for alarms, expected in ((6, 0.5), (7, -0.5)):
        mine = [
            *rows([0.9], [0.9] * alarms, seed=0),
            *rows([0.9], [], seed=1, hours=2.0),
            *rows([0.9], [0.9] * 100, seed=2),
            *(row for seed in range(3) for row in decided([0.0], 0.0, seed=seed)),
        ]
        found = paired(mine, other, TENTH)
        assert found is not None
        assert (found.difference, found.n) == (pytest.approx(expected), 2)
    assert paired(mine, [row | {"seed": 9} for row in other], TENTH) is None
    assert paired(mine, [row for row in other if row["metric"] != "found"], TENTH) is None
