"""Links of tracklets: looks, motion, and the best set."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from tests.trackers.fish_chain.steady import Steady
from tests.trackers.fish_chain.swum import swum
from trackers.fish_chain.linking import IMPOSSIBLE, Appearance, MotionModel, MotionParameters, Starts, best_links
from trackers.gaps import Surroundings

FEATURES = 6


def pieces(
    rng: np.random.Generator, fish: NDArray[np.float64], noise: float, chunks: int = 12
) -> list[NDArray[np.float64]]:
    return [each + rng.normal(0, noise, (chunks, len(each))) for each in fish]


def test_ratios_are_those_of_the_two_gaussians(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trackers.fish_chain.linking._MOST", np.inf)
    rng = np.random.default_rng(1)
    model = Appearance()
    model.learn(pieces(rng, rng.normal(0, 2, (40, FEATURES)), 0.7))
    assert model._axes is not None
    within = np.linalg.inv(model._axes @ model._axes.T)
    between = within @ model._axes @ np.diag(model._spread) @ model._axes.T @ within
    first, second = rng.normal(0, 1, (5, FEATURES)), rng.normal(0, 1, (2, FEATURES))
    noises = [0.3 + 0.7 / len(each) for each in (first, second)]
    a, b = (between + noise * within for noise in noises)
    means = [each.mean(axis=0) - model._mean for each in (first, second)]
    same = multivariate_normal(np.zeros(2 * FEATURES), np.block([[a, between], [between, b]])).logpdf(
        np.concatenate(means)
    )
    different = multivariate_normal(np.zeros(FEATURES), a).logpdf(means[0])
    different += multivariate_normal(np.zeros(FEATURES), b).logpdf(means[1])
    assert model.log_ratios([first], [second])[0, 0] == pytest.approx(same - different, abs=1e-6)


def test_fish_that_differ_are_told_apart_and_those_alike_are_not() -> None:
    rng = np.random.default_rng(2)
    for spread, surely in ((2.0, True), (0.0, False)):
        fish = rng.normal(0, spread, (30, FEATURES))
        model = Appearance()
        model.learn(pieces(rng, fish, 0.7))
        ratios = model.log_ratios(pieces(rng, fish, 0.7), pieces(rng, fish, 0.7))
        others = ratios[~np.eye(30, dtype=bool)]
        if surely:
            assert np.diag(ratios).min() > 0
            assert np.quantile(others, 0.9) < 0
        else:
            assert np.abs(ratios).max() < 1.5


def test_nothing_is_known_before_it_is_learnt() -> None:
    looks = [np.ones((3, FEATURES))]
    model = Appearance()
    assert (model.log_ratios(looks, looks) == 0).all()
    model.learn(looks)
    assert (model.log_ratios(looks, looks) == 0).all()
    assert model.log_ratios([], looks).shape == (0, 1)


BOUNDS = np.array([0.0, 0.0, 400.0, 300.0])


def model(**changes: float | bool) -> MotionModel:
    new = MotionModel(MotionParameters(**changes), Steady())
    new.length_px = 30.0
    new.around = Surroundings(BOUNDS)
    return new


def test_a_place_is_weighed_by_the_region_of_the_gap_method() -> None:
    tail = swum(0, frames=20, velocity_px=(3.0, 0.0))
    start = swum(29, frames=10, velocity_px=(3.0, 0.0), first_px=(170.0, 110.0))
    new = model(use_posture=False, outliers=0.02, inflation=1.0, followed=0.03)
    bridge = Steady().extrapolate(tail.piece(1 / 30), 10, Surroundings())
    covariance = bridge.covariance_px[9] + (0.03 * 30.0) ** 2 * np.eye(2)
    inside = multivariate_normal(bridge.position_px[9], covariance).pdf([170.0, 110.0])
    area = 400.0 * 300.0
    expected = np.log(0.98 * inside + 0.02 / area) - np.log(1 / area)
    assert new.log_ratios(tail, Starts.of([start]))[0] == pytest.approx(expected, rel=1e-6)


def test_headings_are_a_density_that_widens_with_time() -> None:
    new = model()
    rng = np.random.default_rng(0)
    turning = [swum(0, frames=120, velocity_px=(2.0, 1.0), turns_rad=rng.normal(0, 0.08, 120)) for _ in range(8)]
    new.learn([each.piece(1 / 30) for each in turning])
    angles = np.linspace(-np.pi, np.pi, 4001)[:-1]
    peaks = []
    for age in (1, 10, 60, 200):
        ratios = new._heading_ratios(angles, np.full(len(angles), age))
        assert np.exp(ratios).mean() == pytest.approx(1.0, rel=1e-3)
        peaks.append(float(ratios.max()))
    assert peaks == sorted(peaks, reverse=True)
    assert peaks[0] > 1.0


def test_a_fish_that_was_followed_inside_a_blob_is_expected_there() -> None:
    tail = swum(0, frames=20, velocity_px=(3.0, 0.0))
    for frame in range(20, 30):
        tail.haunt(frame, np.array([160.0 - 5 * (frame - 20), 200.0, np.pi, 0.0]))
    there = swum(30, frames=5, velocity_px=(-5.0, 0.0), first_px=(110.0, 200.0))
    ahead = swum(30, frames=5, velocity_px=(3.0, 0.0), first_px=(187.0, 100.0))
    followed, place = (model(use_posture=use).log_ratios(tail, Starts.of([there, ahead])) for use in (True, False))
    assert followed[0] > followed[1] + 5
    assert place[1] > place[0]


def all_sets(rows: int, columns: int) -> list[list[tuple[int, int]]]:
    """Return all sets of links with each row and column at most once."""
    sets = []
    for count in range(min(rows, columns) + 1):
        for chosen in itertools.combinations(range(rows), count):
            sets += [list(zip(chosen, order, strict=True)) for order in itertools.permutations(range(columns), count)]
    return sets


@given(st.integers(0, 10_000), st.integers(0, 4), st.integers(0, 4))
def test_the_set_of_links_costs_least(seed: int, rows: int, columns: int) -> None:
    rng = np.random.default_rng(seed)
    costs = rng.normal(0, 3, (rows, columns))
    costs[rng.random(costs.shape) < 0.2] = IMPOSSIBLE
    found = [(each.tail, each.start) for each in best_links(costs)]
    least = min(sum(costs[pair] for pair in each) for each in all_sets(rows, columns))
    assert sum(costs[pair] for pair in found) == pytest.approx(least)
    assert all(costs[pair] < 0 for pair in found)


@given(st.lists(st.floats(-20, 20), min_size=1, max_size=5))
def test_one_tail_and_several_starts_are_a_softmax(costs: list[float]) -> None:
    table = np.array([costs])
    weights = np.exp(-np.array([0.0, *(each for each in costs if each < 0)]))
    for turned in (table, table.T):
        for each in best_links(turned):
            assert each.probability == pytest.approx(weights.max() / weights.sum())


@given(st.lists(st.floats(-20, -0.1), min_size=4, max_size=4))
def test_two_and_two_are_weighed_as_pairs(costs: list[float]) -> None:
    (a, b), (c, d) = table = np.array(costs).reshape(2, 2)
    if a + d > b + c:
        (b, a), (d, c) = (a, b), (c, d)
    for each in best_links(table):
        own, other = (a, d) if table[each.tail, each.start] == a else (d, a)
        weights = np.exp([-own - other, -b - c, -other])
        assert each.probability == pytest.approx(weights[0] / weights.sum())


def test_two_that_cannot_be_told_apart_are_a_coin_toss() -> None:
    found = best_links(np.full((2, 2), -20.0))
    assert len(found) == 2
    assert all(each.probability == pytest.approx(0.5) for each in found)


def test_what_one_fish_shows_decides_for_the_other() -> None:
    """Nothing is known of the second tail but that the first one goes elsewhere."""
    found = best_links(np.array([[-20.0, -10.0], [-12.0, -12.0]]))
    assert {(each.tail, each.start) for each in found} == {(0, 0), (1, 1)}
    assert all(each.probability > 0.999 for each in found)
