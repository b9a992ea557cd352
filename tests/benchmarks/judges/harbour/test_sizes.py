"""Sizes against truth: medians of a visit, over all distances and at 100 m."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.contract.suite import suite
from benchmarks.judges.harbour.sizes import MEAN_SIZE_M
from tests.benchmarks.judges.harbour.hand_made import Intruder, judged, of_visits, standing, track
from trackers.types import Track

FRAMES = 90


def test_sizes_are_medians_of_a_visit_beside_the_mean_of_the_class() -> None:
    big = Intruder("car", dict.fromkeys(range(20, 40), (10.0, 3.0)), size_m=(5.0, 2.0, 1.5))

    def answer(k: int) -> list[Track]:
        width = {0: 1.0, 1: 1.8, 2: 9.0}[k % 3]
        return (
            [track(1, (10.0, 3.0), "car", size_m=(4.0, width, 1.5), named="car" if k % 2 else None)]
            if 20 <= k < 38
            else []
        )

    scores = judged([big], FRAMES, answer)
    name = "car-0"
    assert of_visits(scores, "region_width_m") == {name: 1.8}
    assert of_visits(scores, "width_error") == {name: pytest.approx(0.1)}
    assert of_visits(scores, "depth_error") == {name: pytest.approx(0.2)}
    assert of_visits(scores, "height_error") == {name: pytest.approx(0.0)}
    assert of_visits(scores, "kind_right") == {name: 1.0}


@pytest.mark.parametrize(
    ("ahead_m", "across_m", "counts"),
    [(-19.9, 0.0, True), (-20.1, 0.0, False), (19.9, 0.0, True), (20.1, 0.0, False), (-20.1, 6.0, True)],
)
def test_at_100_m_is_20_m_more_or_less_over_the_ground(ahead_m: float, across_m: float, counts: bool) -> None:
    """The camera stands 100 m before the origin, 20 m high."""
    person = standing("person", (ahead_m, across_m), range(20, 40))
    scores = judged([person], FRAMES, lambda k: [track(1, (ahead_m, across_m))] if 20 <= k < 40 else [])
    for metric in ("height_error_at_100_m", "height_error_of_mean"):
        assert list(of_visits(scores, metric)) == ["person-0"] * counts
    assert list(of_visits(scores, "height_error")) == ["person-0"]


def test_at_100_m_only_the_sizes_there_count() -> None:
    """A car drives away from the camera, and its track grows."""
    car = Intruder("car", {k: (2.0 * (k - 30), 3.0) for k in range(21, 50)}, size_m=(5.0, 2.0, 1.5))

    def grows(k: int) -> list[Track]:
        size_m = (5.0, 2.0 + 0.1 * (k - 30), 1.5)
        return [track(1, (2.0 * (k - 30), 3.0), "car", size_m=size_m)] if 21 <= k < 50 else []

    scores = judged([car], FRAMES, grows)
    # From 21 to 39 it is at most 20 m nearer or farther; 21 to 49 is the whole drive.
    assert of_visits(scores, "width_error_at_100_m") == {"car-0": pytest.approx(0.0)}
    assert of_visits(scores, "width_error") == {"car-0": pytest.approx(0.25)}
    mean_m = np.array(MEAN_SIZE_M["car"])
    for name, said_m, true_m in zip(("depth", "width", "height"), mean_m, (5.0, 2.0, 1.5), strict=True):
        assert of_visits(scores, f"{name}_error_of_mean") == {"car-0": pytest.approx(abs(said_m / true_m - 1.0))}


def test_the_metric_against_the_mean_is_about_100_m() -> None:
    """A size that is wrong at other distances alone does not count in it."""
    metric = suite("harbour").metric("width_error_to_mean_car")
    heading = {"suite": "harbour", "seed": 0, "weight": 1.0, "event": {"kind": "car"}}
    given = {"width_error": 0.9, "width_error_at_100_m": 0.05, "width_error_of_mean": 0.12}
    pool = metric.statistic.pooled([heading | {"metric": name, "value": value} for name, value in given.items()])
    assert pool is not None
    assert pool.mean == pytest.approx(-0.07)
