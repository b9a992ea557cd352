"""Scores of one tracker in one episode of the suite ``stereo``, from truth and answers made by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.contract.judging import Score
from benchmarks.judges.stereo.judge import score_episode
from benchmarks.judges.stereo.metrics.people import PeopleSeries
from tests.benchmarks.judges.stereo.hand_made_people import OTHER_M, people_of

RIGHT, AWAY, OTHER = (0.3, 0.0), (0.0, 3.0), OTHER_M


def scores_of(truth: PeopleSeries, places: list[Any], closed_loop: bool = False) -> list[Score]:
    """Score answers, one a frame; None = no answer."""
    given = np.array([place is not None for place in places])
    place_m = np.array([place or (0.0, 0.0) for place in places])
    return list(score_episode(truth, given, place_m, closed_loop=closed_loop))


def values(scores: list[Score], metric: str, kind: str | None = None) -> list[Any]:
    return [
        score.value
        for score in scores
        if score.metric == metric and (None if score.event is None else score.event.attributes()["kind"]) == kind
    ]


def test_counts_of_the_episode_leave_the_first_frame_out() -> None:
    truth = people_of([1.0, 1.0, 1.0, 1.0, 0.05, 0.0, 1.0])
    scores = scores_of(truth, [None, RIGHT, AWAY, None, None, OTHER, OTHER])
    counts = {name: values(scores, f"{name}_frames") for name in ("right", "wrong", "missed")}
    assert counts == {"right": [1.0], "wrong": [2.0], "missed": [1.0]}
    assert values(scores, "outcome_by_frame") == [[0, 1, 2, 3, 0, 5, 4]]
    assert values(scores, "visible_fraction_by_frame") == [[1.0, 1.0, 1.0, 1.0, 0.05, 0.0, 1.0]]
    (rate,) = [score for score in scores if score.metric == "wrong_person_rate"]
    # Of all six frames, those on which the target is hidden too.
    assert (rate.value, rate.weight) == (pytest.approx(2 / 6), 6)


def test_the_error_is_unconditional_where_the_target_is_seen() -> None:
    truth = people_of([1.0, 1.0, 0.1, 0.09, 1.0, 1.0])
    scores = scores_of(truth, [AWAY, RIGHT, AWAY, AWAY, None, (40.0, 0.0)])
    (error,) = [score for score in scores if score.metric == "position_error_m"]
    assert (error.value, error.weight) == (pytest.approx((0.3 + 3.0 + 5.0 + 5.0) / 4), 4)
    (found,) = [score for score in scores if score.metric == "position_error_found_m"]
    assert (found.value, found.weight) == (pytest.approx(0.3), 1)


def test_without_a_right_answer_there_is_no_error_of_those() -> None:
    scores = scores_of(people_of([1.0, 1.0]), [None, AWAY])
    assert values(scores, "position_error_found_m") == [None]


HIDDEN = [1.0, 0.0, 0.0, 0.3] + [1.0] * 20
BACK = 4


@pytest.mark.parametrize(("first", "recovered"), [(BACK, 1.0), (BACK + 10, 1.0), (BACK + 11, 0.0)])
def test_ten_frames_are_allowed_after_half_of_him_is_seen(first: int, recovered: float) -> None:
    places = [RIGHT if k >= first else AWAY for k in range(len(HIDDEN))]
    scores = scores_of(people_of(HIDDEN), places)
    assert values(scores, "recovered", "occlusion") == [recovered]
    assert values(scores, "recovery_frames", "occlusion") == [float(first - BACK)]
    assert values(scores, "watched_frames", "occlusion") == [20.0]


def test_being_right_before_half_of_him_is_seen_counts_for_nothing() -> None:
    places = [RIGHT if k < BACK else None for k in range(len(HIDDEN))]
    scores = scores_of(people_of(HIDDEN), places)
    assert values(scores, "recovered", "occlusion") == [0.0]
    assert values(scores, "recovery_frames", "occlusion") == [None]


def test_locked_on_another_takes_most_of_the_window() -> None:
    for frames, locked in ((6, 1.0), (5, 0.0)):
        places = [OTHER if BACK <= k < BACK + frames else None for k in range(len(HIDDEN))]
        assert values(scores_of(people_of(HIDDEN), places), "locked_on_wrong_person", "occlusion") == [locked]


def test_an_occlusion_that_never_ends_is_judged_only_where_the_tracker_steers() -> None:
    truth = people_of([1.0, 1.0, 0.0, 0.0, *[0.3] * 10])
    places = [RIGHT] * 14
    assert values(scores_of(truth, places), "recovered", "occlusion") == []
    assert values(scores_of(truth, places, closed_loop=True), "recovered", "occlusion") == [0.0]


def test_whether_an_occlusion_counts_does_not_depend_on_the_answer() -> None:
    """Ten frames must follow the return, so that late successes and late failures count alike."""
    for count, recovered in ((BACK + 10, [[], []]), (BACK + 11, [[1.0], [0.0]])):
        truth = people_of(HIDDEN[:count])
        right, silent = (scores_of(truth, [place] * count) for place in (RIGHT, None))
        assert [values(scores, "recovered", "occlusion") for scores in (right, silent)] == recovered
        for scores in (right, silent):
            assert values(scores, "watched_frames", "occlusion") == [float(count - BACK)]


def test_frames_after_a_change_of_light_are_counted_for_it() -> None:
    truth = people_of([1.0] * 12, lights={3: "lamp off", 4: "lamp off"}, rate_hz=2.0)
    places: list[Any] = [RIGHT, RIGHT, AWAY, RIGHT, OTHER, AWAY, None, AWAY, RIGHT, None, RIGHT, RIGHT]
    scores = scores_of(truth, places)
    # Frames 3 to 6.
    counts = [values(scores, f"event_{name}_frames", "lamp off") for name in ("right", "wrong", "missed")]
    assert counts == [[1.0], [2.0], [1.0]]
    assert values(scores, "event_wrong_person_rate", "lamp off") == [0.25]


def test_stretches_with_and_without_somebody_near_add_up_to_the_episode() -> None:
    rng = np.random.default_rng(0)
    truth = people_of(rng.choice([0.0, 0.05, 1.0], 60).tolist(), near=rng.choice(60, 25).tolist())
    places = [[RIGHT, AWAY, OTHER, None][k] for k in rng.integers(0, 4, 60)]
    scores = scores_of(truth, places)
    for name in ("right", "wrong", "missed"):
        parts = [sum(values(scores, f"event_{name}_frames", kind)) for kind in ("near person", "nobody near")]
        assert min(parts) > 0
        assert [sum(parts)] == values(scores, f"{name}_frames")
