"""Answers that cannot score are told once for each tracker; those of another kind of trouble are not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from benchmarks.run.guards import GuardedTracker
from benchmarks.run.outcome import AnswerWatch, Oddities, Outcome
from scenarios.loop import FromPictures
from tests.benchmarks.fake_episode import HEIGHT, WIDTH, FakeEpisode, FakeTracker
from trackers.types import Answer, Estimate, Track

FRAMES = 10
X, Y = 60.0, 50.0
BOX = np.array([X - 10, Y - 6, X + 10, Y + 6])


def told(answers: Sequence[Answer], needs_depth: bool = False) -> list[str]:
    """Return what is told of answers in two episodes."""
    found = Oddities()
    for _ in range(2):
        watch, episode = AnswerWatch(needs_depth), FakeEpisode()
        for answer in answers:
            watch.see(episode.step(), answer)
        episode_oddities = Oddities()
        episode_oddities.add("mine", watch, ())
        found += episode_oddities
    return list(found.in_words())


def estimates(x: float, y: float, box_xyxy: Any = None) -> list[Answer]:
    return [Estimate(np.array([x, y]), box_xyxy)] * FRAMES


def tracks(*identities: Sequence[int], depth_m: float | None = 3.0) -> list[Answer]:
    return [[Track(each, Estimate(np.array([X, Y]), BOX, depth_m=depth_m)) for each in some] for some in identities]


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        (
            estimates(X, Y, np.array([20.0, 40.0, 20.0, 44.0])),
            "mine: in 20 of 20 pictures the position lies outside its box; boxes are x_min, y_min, x_max, y_max in",
        ),
        (
            estimates(X / WIDTH, Y / HEIGHT, BOX / np.array([WIDTH, HEIGHT] * 2)),
            "mine: in 20 of 20 pictures the estimate lies in its first pixel, from 0 to 1; boxes are x_min",
        ),
        (estimates(X + 5000, Y), "mine: in 20 of 20 pictures the estimate lies outside the picture; boxes are"),
        (tracks(*([k] for k in range(FRAMES))), "mine: in 18 of 18 pictures all identities are new; a target keeps"),
    ],
)
def test_answers_of_another_kind_are_told(answers: Sequence[Answer], words: str) -> None:
    (line,) = told(answers)
    assert line.startswith(words)


@pytest.mark.parametrize(
    "answers",
    [
        estimates(X, Y, BOX),
        estimates(np.nan, np.nan),
        # It leaves the picture, and never comes back.
        [*estimates(X, Y)[:1], *estimates(5000.0, Y)],
        tracks(*([k // 4] for k in range(FRAMES))),
        tracks(*([k, k + 1] for k in range(FRAMES))),
        tracks([1], [], [2], []),
        tracks(*([] for k in range(FRAMES))),
        tracks(*([1] for k in range(FRAMES)), depth_m=None),
    ],
)
def test_other_answers_are_not(answers: Sequence[Answer]) -> None:
    assert told(answers) == []


def test_tracks_without_a_depth_are_told_where_it_is_needed() -> None:
    answers = [*tracks([1, 2], [1, 2], depth_m=None), *tracks([1, 2])]
    assert told(answers, needs_depth=True) == [
        "mine: 8 of 12 tracks have no depth_m, which this suite needs; CONTRIBUTING.md says what else"
    ]


def test_a_guard_watches_answers_and_a_run_tells_them_beside_silence() -> None:
    guard, episode = GuardedTracker(lambda: FromPictures(FakeTracker()), 60.0), FakeEpisode()
    guard.initialise(episode.step(), episode.start)
    for _ in range(FRAMES):
        guard.update(episode.step())
    outcome = Outcome()
    outcome.oddities.add("mine", guard.watch, ["left 1 thread running"])
    assert list(outcome.oddities_in_words("nothing")) == ["mine left 1 thread running, in 1 episode"]
    both = outcome.followed_by(outcome)
    assert list(both.oddities_in_words("nothing")) == ["mine left 1 thread running, in 2 episodes"]
    assert guard.watch.of["apart"] == FRAMES
