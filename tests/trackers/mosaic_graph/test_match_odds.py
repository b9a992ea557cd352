"""The odds of a match: what they learn from, and that a better match is never less likely."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackers.mosaic_graph.match_odds import MatchOdds

peaks = st.floats(0.0, 2.0)


def taught(targets: list[float], others: list[float]) -> MatchOdds:
    odds = MatchOdds()
    for peak in targets:
        odds.learn_target(peak)
    for peak in others:
        odds.learn_other(peak)
    return odds


@given(st.lists(peaks, max_size=20), st.lists(peaks, max_size=20), peaks)
def test_the_log_ratio_is_finite_and_limited(targets: list[float], others: list[float], peak: float) -> None:
    assert -6.0 <= taught(targets, others).log_ratio(peak) <= 3.5


@given(st.floats(0.3, 0.9), st.floats(0.02, 0.1), peaks, peaks)
def test_a_higher_peak_is_never_less_like_the_target(on: float, off: float, one: float, other: float) -> None:
    odds = taught([on] * 60, [off] * 60)
    low, high = sorted((one, other))
    assert odds.log_ratio(low) <= odds.log_ratio(high) + 1e-9


def test_it_learns_where_the_two_part() -> None:
    """0.2 is what else matches in one film, and the target in another."""
    rng = np.random.default_rng(0)
    strong = taught(list(rng.normal(0.8, 0.05, 80)), list(rng.normal(0.2, 0.02, 80)))
    weak = taught(list(rng.normal(0.2, 0.02, 80)), list(rng.normal(0.05, 0.01, 80)))
    assert strong.log_ratio(0.2) < -1.0 < 1.0 < weak.log_ratio(0.2)


@pytest.mark.parametrize(("peak", "usual"), [(0.5, True), (0.3, True), (0.2, False), (0.0, False)])
def test_half_the_usual_peak_is_unusual(peak: float, usual: bool) -> None:
    assert taught([0.5] * 60, []).is_usual(peak) == usual
