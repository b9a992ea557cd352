from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.scores.recovery import Recovery, judge_recovery, recovery_curve
from benchmarks.suites.frame_out.metrics.frame_outs import find_frame_outs
from tests.benchmarks.hand_made import truth_of

RATE_HZ = 15.0


def judged(states: list[str], on: list[int], other: dict[int, int] | None = None) -> Recovery | None:
    """Judge the first frame-out with the target hit on frames ``on`` and wrong cars on others."""
    truth = truth_of(states)
    on_target = np.isin(np.arange(len(states)), on)
    on_other = np.array([(other or {}).get(k, -1) for k in range(len(states))])
    return judge_recovery(find_frame_outs(truth)[0], on_target, on_other, RATE_HZ)


STATES = ["in"] * 3 + ["out"] * 4 + ["partial"] + ["in"] * 30
BACK = 8


@pytest.mark.parametrize(("first", "recovered"), [(BACK, True), (BACK + 5, True), (BACK + 6, False)])
def test_five_frames_are_allowed_after_it_is_back(first: int, recovered: bool) -> None:
    outcome = judged(STATES, list(range(first, len(STATES))))
    assert outcome is not None
    assert outcome.recovered is recovered
    assert outcome.kept is recovered
    assert outcome.frames == first - BACK


def test_kept_asks_once_more_after_a_second() -> None:
    on = list(range(BACK + 2, BACK + 12))
    outcome = judged(STATES, on)
    assert outcome is not None
    assert outcome.recovered
    assert not outcome.kept
    outcome = judged(STATES, [*on, BACK + 2 + 15])
    assert outcome is not None
    assert outcome.kept


def test_being_on_the_car_before_it_is_back_in_full_counts_for_nothing() -> None:
    outcome = judged(STATES, list(range(BACK)))
    assert outcome == Recovery(False, False, None, len(STATES) - BACK, False)


def test_recovery_ends_at_the_next_exit() -> None:
    states = ["in"] * 2 + ["out"] * 3 + ["in"] * 3 + ["out"] * 10 + ["in"] * 20
    outcome = judged(states, list(range(8, len(states))))
    assert outcome is not None
    assert not outcome.recovered
    assert outcome.watched_frames == 3


def test_without_a_full_return_there_is_nothing_to_judge() -> None:
    assert judged(["in", "out", "partial", "out", "in"], [2]) is None


def test_an_end_within_the_window_says_nothing_unless_it_was_recovered() -> None:
    states = ["in", "out", "in", "in"]
    assert judged(states, []) is None
    outcome = judged(states, [3])
    assert outcome is not None
    assert outcome.recovered


def test_locked_on_a_wrong_car_takes_most_of_the_window_on_one_other_car() -> None:
    window = range(BACK, BACK + 6)
    same = judged(STATES, [], dict.fromkeys(list(window)[:4], 2))
    half = judged(STATES, [], dict.fromkeys(list(window)[:3], 2))
    mixed = judged(STATES, [], {k: 1 + k % 2 for k in window})
    assert [outcome is not None and outcome.locked_on_other for outcome in (same, half, mixed)] == [
        True,
        False,
        False,
    ]


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 12), st.integers(0, 12)), min_size=1, max_size=30))
def test_the_curve_is_kaplan_and_meiers(cars: list[tuple[int, int]]) -> None:
    """Against their product, by hand: a car recovers at the first number unless its watch ends before (second)."""
    frames = [time if time <= watch else None for time, watch in cars]
    watched = [watch for _, watch in cars]
    ends = [watch if time is None else time for time, watch in zip(frames, watched, strict=True)]
    curve = recovery_curve(frames, watched)
    for t in range(14):
        survival = 1.0
        for u in range(t + 1):
            at_risk = sum(end >= u for end in ends)
            events = sum(time == u for time in frames)
            survival *= 1 - events / at_risk if at_risk else 1.0
        place = np.searchsorted(curve.frames, t, side="right")
        ours = 1.0 if place == 0 else curve.waiting[place - 1]
        assert ours == pytest.approx(survival, abs=1e-12)
    assert (curve.low <= curve.waiting + 1e-12).all()
    assert (curve.waiting <= curve.high + 1e-12).all()
