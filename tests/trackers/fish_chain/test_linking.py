"""The best set of links against all sets."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackers.fish_chain.linking import IMPOSSIBLE, best_links


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
