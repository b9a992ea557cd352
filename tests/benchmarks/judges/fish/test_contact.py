"""Fish stand apart, lie together, or cross."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString

from benchmarks.judges.fish.contact import CONTACT_PX, crossing, stands_apart, together
from tests.benchmarks.judges.fish.hand_made import truth_of


@pytest.mark.parametrize(("down_px", "touch"), [(3, True), (4, True), (5, False), (20, False)])
def test_fish_lie_together_when_their_pixels_are_near(down_px: int, touch: bool) -> None:
    """Bodies are three pixels wide: parallel ones d rows apart have d - 2 rows from one's edge to the other's."""
    truth = truth_of([(40, 30), (40, 30 + down_px), (90, 30)], [0.0, 0.0, 0.0])
    assert (down_px - 2 <= CONTACT_PX) == touch
    pairs = together(truth)
    assert pairs[0, 1] == pairs[1, 0] == touch
    assert not pairs[2].any()
    assert not pairs.diagonal().any()
    assert stands_apart(truth, pairs).tolist() == [not touch, not touch, True]
    assert not crossing(truth, pairs).any()


@given(st.lists(st.tuples(st.integers(15, 100), st.integers(15, 60), st.floats(-3, 3)), min_size=2, max_size=4))
def test_pairs_are_those_of_brute_force(fish: list[tuple[int, int, float]]) -> None:
    truth = truth_of([each[:2] for each in fish], [each[2] for each in fish])
    places = [np.argwhere(truth.instance_map == name) for name in truth.instance_id]
    pairs = together(truth)
    for a, first in enumerate(places):
        for b, second in enumerate(places):
            if a != b:
                away = np.abs(first[:, None] - second[None]).max(axis=2)
                assert pairs[a, b] == bool((away <= CONTACT_PX).any())
    crossed = crossing(truth, np.ones((len(fish), len(fish)), bool))
    lines = [LineString(line) for line in truth.centre_line_px]
    for a, line in enumerate(lines):
        near = [line.distance(other) for b, other in enumerate(lines) if b != a]
        if min(abs(each) for each in near) > 1e-6:
            assert not crossed[a]
        elif any(line.crosses(other) for b, other in enumerate(lines) if b != a) and not _touches(line, lines, a):
            assert crossed[a]


def _touches(line: LineString, lines: list[LineString], mine: int) -> bool:
    """Whether a point of one line lies on another, or lines run along each other: neither side is then strict."""
    for other in (each for k, each in enumerate(lines) if k != mine):
        points = [*line.coords, *other.coords]
        on = sum(LineString([p, p]).distance(line) < 1e-6 and LineString([p, p]).distance(other) < 1e-6 for p in points)
        if on:
            return True
    return False


def test_a_fish_that_is_hidden_does_not_stand_apart() -> None:
    truth = truth_of([(40, 30), (90, 30)], [0.0, 0.0], visible=[0.4, 0.6])
    assert stands_apart(truth, together(truth)).tolist() == [False, True]


def test_fish_across_each_other_cross() -> None:
    truth = truth_of([(40, 30), (41, 31), (42, 60)], [0.0, 1.3, 0.0])
    pairs = together(truth)
    assert crossing(truth, pairs).tolist() == [True, True, False]
    assert not crossing(truth, np.zeros_like(pairs)).any()


def test_no_fish() -> None:
    truth = truth_of([], [])
    assert together(truth).shape == (0, 0)
