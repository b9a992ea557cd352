"""Links over gaps: right, wrong or not made, and their scores."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchmarks.judges.fish.gaps import FishGap, find_gaps
from benchmarks.judges.fish.links import (
    Bearers,
    Link,
    Outcome,
    answered,
    bearers,
    judge_links,
    link_events,
    link_scores,
    precision_at,
)
from tests.benchmarks.judges.fish.hand_made import track
from trackers.types import Track

FRAMES, FIRST, END = 40, 15, 22
PLACES = np.stack([np.full((FRAMES, 2), 10.0), np.full((FRAMES, 2), 50.0), np.full((FRAMES, 2), 90.0)], axis=1)
"""Three fish at rest; fish 0 and 1 lie together on frames [FIRST, END)."""


def apart_of(*gaps: tuple[int, int, int]) -> NDArray[np.bool_]:
    apart = np.ones((FRAMES, 3), bool)
    for fish, first, end in gaps:
        apart[first:end, fish] = False
    return apart


APART = apart_of((0, FIRST, END), (1, FIRST, END))
PAIR = np.zeros((3, 3), bool)
PAIR[0, 1] = PAIR[1, 0] = True


def gaps_of(apart: NDArray[np.bool_] = APART) -> list[FishGap]:
    return find_gaps(apart, np.tile(PAIR, (FRAMES, 1, 1)), np.zeros((FRAMES, 3), bool))


def on_fish(answers: Sequence[Sequence[Track]], places: NDArray[np.float64] = PLACES) -> Bearers:
    return bearers([answered(tracks) for tracks in answers], places, 8.0)


def outcomes(before: Sequence[int | None], after: Sequence[int | None], confidence: float = 0.5) -> list[Link]:
    """Links of a tracker that calls the fish ``before`` and ``after`` the gap so, None = no track."""
    answers = [
        [
            track(name, PLACES[k, fish] + 1.0, confidence)
            for fish, name in enumerate(before if k < END else after)
            if name is not None
        ]
        for k in range(FRAMES)
    ]
    return judge_links(gaps_of(), APART, on_fish(answers))


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ((4, 5, 6), (4, 5, 6), "RIGHT RIGHT"),
        ((4, 5, 6), (5, 4, 6), "WRONG WRONG"),
        ((4, 5, 6), (7, 8, 6), "ABSTAINED ABSTAINED"),
        ((4, 5, 6), (4, 8, 6), "RIGHT ABSTAINED"),
        # A new identity on the one, while the other has taken its old one.
        ((4, 5, 6), (7, 4, 6), "WRONG WRONG"),
        # The identity of a fish that was not there.
        ((4, 5, 6), (6, 5, None), "WRONG RIGHT"),
        ((None, 5, 6), (4, 5, 6), "ABSTAINED RIGHT"),
        ((4, 5, 6), (None, 5, 6), "ABSTAINED RIGHT"),
        ((4, 5, 6), (None, 4, 6), "WRONG WRONG"),
    ],
)
def test_outcomes(before: Sequence[int | None], after: Sequence[int | None], expected: str) -> None:
    links = outcomes(before, after)
    assert " ".join(link.outcome.name for link in links) == expected
    assert [link.gap.fish for link in links] == [0, 1]


def test_an_identity_that_a_fish_had_earlier_is_right_again() -> None:
    """After a first gap it has a new identity, after the second its first one."""
    apart = apart_of((0, 8, 12), (0, 22, 26))
    names = [4 if k < 12 or k >= 26 else 7 for k in range(FRAMES)]
    answers = [[track(name, PLACES[k, 0])] for k, name in enumerate(names)]
    links = judge_links(gaps_of(apart), apart, on_fish(answers))
    assert [link.outcome for link in links] == [Outcome.ABSTAINED, Outcome.RIGHT]


def test_a_new_name_that_another_fish_took_on_in_the_gap_is_stolen() -> None:
    """Fish 1 leaves the blob first, as 7; fish 0 comes out as 7, and fish 1 goes on as 8."""
    apart = apart_of((0, 15, 28), (1, 15, 20))
    answers = [
        [track(names[fish], PLACES[k, fish]) for fish in (0, 1) if apart[k, fish]]
        for k in range(FRAMES)
        for names in ([(4, 5), (None, 7), (7, 8)][(k >= 20) + (k >= 28)],)
    ]
    links = judge_links(gaps_of(apart), apart, on_fish(answers))
    assert [(link.gap.fish, link.outcome.name) for link in links] == [(0, "WRONG"), (1, "ABSTAINED")]


def test_a_name_that_a_fish_took_on_in_its_own_gap_is_new() -> None:
    """It stands apart on two frames within the gap, too few to end it."""
    apart = apart_of((0, 15, 18), (0, 20, 25))
    answers = [[track(4 if k < 18 else 7, PLACES[k, 0])] for k in range(FRAMES)]
    (link,) = judge_links(gaps_of(apart), apart, on_fish(answers))
    assert (link.gap.length_frames, link.outcome) == (10, Outcome.ABSTAINED)


def test_the_confidence_is_that_of_the_first_track_after_the_gap() -> None:
    answers = [[track(4, PLACES[k, 0], 0.01 * k)] for k in range(FRAMES)]
    (first, _) = judge_links(gaps_of(), APART, on_fish(answers))
    assert first.confidence == pytest.approx(0.01 * END)
    assert all(np.isnan(link.confidence) for link in outcomes((4, 5, 6), (7, 8, 6)))


def test_gaps_near_each_other_are_one_and_open_ends_are_none() -> None:
    """Four frames apart part no gaps, five do; what begins or ends with the episode is not judged."""
    spans = ((0, 10, 12), (0, 16, 18), (1, 10, 12), (1, 17, 18), (2, 0, 3), (2, 38, 40))
    gaps = gaps_of(apart_of(*spans))
    assert [(gap.fish, gap.first_frame, gap.end_frame) for gap in gaps] == [(0, 10, 18), (1, 10, 12), (1, 17, 18)]
    assert [gap.index for gap in gaps] == [0, 1, 2]
    assert [gap.fish_count for gap in gaps] == [2, 2, 2]


def test_each_track_is_on_the_fish_that_it_is_nearest_to_all_in_all() -> None:
    places = np.array([[[0.0, 0.0], [10.0, 0.0], [np.nan, np.nan]]])
    tracks = [track(1, (6, 0), 0.5), track(2, (11, 0)), track(3, (40, 0)), track(4, (np.nan, np.nan))]
    borne = on_fish([tracks], places)
    assert borne.identity.tolist() == [[1, 2, -1]]
    assert borne.confidence[0, 0] == 0.5
    assert np.isnan(borne.confidence[0, 1:]).all()


def link(outcome: Outcome, confidence: float = np.nan, length: int = 10, crosses: bool = False) -> Link:
    return Link(FishGap(0, 0, 10, length, 2, crosses), outcome, confidence)


RIGHT, WRONG, NONE = Outcome.RIGHT, Outcome.WRONG, Outcome.ABSTAINED


def test_scores_are_shares_of_links_and_of_gaps() -> None:
    links = [
        link(RIGHT),
        link(RIGHT, crosses=True),
        link(WRONG),
        link(NONE),
        link(RIGHT, length=51),
        link(RIGHT, length=201),
    ]
    scores = {each.metric: (each.value, each.weight) for each in link_scores(links, "_x")}
    assert scores["link_precision_50_x"] == (pytest.approx(2 / 3), 3)
    assert scores["link_rate_50_x"] == (0.75, 4)
    assert scores["link_recall_50_x"] == (0.5, 4)
    assert scores["link_precision_200_x"] == (0.75, 4)
    assert scores["link_rate_crossing_50_x"] == (1.0, 1)
    assert scores["link_recall_touching_50_x"] == (pytest.approx(1 / 3), 3)
    assert "link_precision_crowd_50_x" not in scores
    events = [(each.metric, each.value) for each in link_events(links[2:4])]
    assert events == [("link_made", 1.0), ("link_right", 0.0), ("link_made", 0.0)]


def test_the_surest_links_are_compared_at_one_share() -> None:
    links = [link(RIGHT, 0.9)] * 6 + [link(WRONG, 0.2)] * 2 + [link(RIGHT, 0.5)] * 2
    assert precision_at(links, 0.8) == 1.0
    assert precision_at(links, 0.9) == pytest.approx(8 / 9)
    assert precision_at(links, 1.0) == pytest.approx(0.8)
    # What is missing to the share is not right.
    assert precision_at([*links[:6], *[link(NONE)] * 4], 0.9) == pytest.approx(6 / 9)


@given(st.lists(st.sampled_from([RIGHT, WRONG, NONE]), min_size=1, max_size=12))
def test_without_confidence_no_link_is_preferred(given: list[Outcome]) -> None:
    links = [link(outcome) for outcome in given]
    made = len(given) - given.count(NONE)
    wanted = 0.9 * len(given)
    mean = given.count(RIGHT) / made if made else 0.0
    assert precision_at(links) == pytest.approx(mean * min(made, wanted) / wanted)
