from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.judges.frame_out.metrics.frame_outs import find_frame_outs
from benchmarks.judges.recovery import NEVER_BACK, Recovery, judge_recovery, time_scores
from tests.benchmarks.hand_made import truth_of

KEPT_FRAMES = 15


def judged(
    states: list[str], on: list[int], other: dict[int, int] | None = None, closed_loop: bool = False
) -> Recovery | None:
    """Judge the first frame-out with the target hit on frames ``on`` and wrong cars on others."""
    frame_out = find_frame_outs(truth_of(states))[0]
    on_target = np.isin(np.arange(len(states)), on)
    on_other = np.array([(other or {}).get(k, -1) for k in range(len(states))])
    return judge_recovery(frame_out, on_target, on_other, kept_frames=KEPT_FRAMES, closed_loop=closed_loop)


def times(states: list[str], on: list[int], closed_loop: bool = False) -> list[float | None]:
    """Return time to recover and watched frames of the first frame-out, in frames."""
    frame_out = find_frame_outs(truth_of(states))[0]
    on_target = np.isin(np.arange(len(states)), on)
    return [score.value for score in time_scores(frame_out, on_target, closed_loop=closed_loop)]  # type: ignore[misc]


STATES = ["in"] * 3 + ["out"] * 4 + ["partial"] + ["in"] * 30
BACK = 8


@pytest.mark.parametrize(("first", "recovered"), [(BACK, True), (BACK + 5, True), (BACK + 6, False)])
def test_five_frames_are_allowed_after_it_is_back(first: int, recovered: bool) -> None:
    on = list(range(first, len(STATES)))
    assert judged(STATES, on) == Recovery(recovered, recovered, False)
    assert times(STATES, on) == [first - BACK, 30]


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
    assert judged(STATES, list(range(BACK))) == Recovery(False, False, False)
    assert times(STATES, list(range(BACK))) == [None, len(STATES) - BACK]


def test_recovery_ends_at_the_next_exit() -> None:
    states = ["in"] * 2 + ["out"] * 3 + ["in"] * 3 + ["out"] * 10 + ["in"] * 20
    assert judged(states, list(range(8, len(states)))) == Recovery(False, False, False)
    assert times(states, list(range(8, len(states)))) == [None, 3]


def test_without_a_full_return_there_is_nothing_to_judge() -> None:
    states = ["in", "out", "partial", "out", *["in"] * 30]
    assert judged(states, [2]) is None
    assert judged(states, [2], closed_loop=True) is None
    assert times(states, [2]) == times(states, [2], closed_loop=True) == []


def test_whether_it_counts_is_decided_by_the_truth_and_not_by_the_answer() -> None:
    """Five frames and a second must follow, so that late successes and late failures count alike."""
    late = ["in", "out", *["in"] * (5 + KEPT_FRAMES)]
    enough = [*late, "in"]
    assert judged(late, [2]) is judged(late, []) is None
    assert judged(enough, [2]) == Recovery(True, False, False)
    assert judged(enough, []) == Recovery(False, False, False)
    assert judged(enough, [7, 22]) == Recovery(True, True, False)


def test_where_the_tracker_steers_the_time_counts_from_the_exit() -> None:
    away = ["in", *["out"] * 25]
    assert judged(away, []) is None
    assert judged(away, [], closed_loop=True) == NEVER_BACK
    assert judged(away[:21], [], closed_loop=True) is None
    assert times(away, []) == []
    assert times(away, [], closed_loop=True) == [None, 0]
    # Back too late for the whole window; the tracker steered.
    assert judged([*away, "in", "in"], [27], closed_loop=True) == Recovery(True, True, False)
    assert judged([*away, "in", "in"], [], closed_loop=True) == Recovery(False, False, False)


STATE = st.sampled_from(["in", "out", "partial"])


@given(st.lists(STATE, min_size=1, max_size=60), st.booleans(), st.data())
def test_no_answer_changes_which_absences_count(states: list[str], closed_loop: bool, data: st.DataObject) -> None:
    truth = truth_of(states)
    flags = st.lists(st.booleans(), min_size=len(states), max_size=len(states)).map(np.array)
    others = st.lists(st.integers(-1, 2), min_size=len(states), max_size=len(states)).map(np.array)
    first, second = ((data.draw(flags), data.draw(others)) for _ in range(2))
    for frame_out in find_frame_outs(truth):
        outcomes, watched = [], []
        for on_target, on_other in (first, second):
            found = judge_recovery(frame_out, on_target, on_other, kept_frames=3, closed_loop=closed_loop)
            outcomes.append(found is None)
            timed = {score.metric: score.value for score in time_scores(frame_out, on_target, closed_loop=closed_loop)}
            watched.append(timed.get("watched_frames"))
        assert outcomes[0] == outcomes[1]
        assert watched[0] == watched[1]


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
