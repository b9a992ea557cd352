"""Answers that cannot score are told once for each tracker; those of another kind of trouble are not."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.run.guards import GuardedTracker
from benchmarks.run.outcome import AnswerWatch, Outcome
from scenarios.loop import FromPictures
from tests.benchmarks.fake_episode import HEIGHT, WIDTH, FakeEpisode, FakeTracker
from trackers.types import Answer, Estimate, Observation, Track

FRAMES = 10
X, Y = 60.0, 50.0
BOX = np.array([X - 10, Y - 6, X + 10, Y + 6])


def told(answers: Sequence[Answer], needs_depth: bool = False) -> list[str]:
    """Return what is told of answers in an episode."""
    watch, episode = AnswerWatch(needs_depth), FakeEpisode()
    for answer in answers:
        watch.see(episode.step(), answer)
    return watch.in_words()


def estimates(x: float, y: float, box_xyxy: Any = None) -> list[Answer]:
    return [Estimate(np.array([x, y]), box_xyxy)] * FRAMES


def tracks(*identities: Sequence[int], depth_m: float | None = 3.0) -> list[Answer]:
    return [[Track(each, Estimate(np.array([X, Y]), BOX, depth_m=depth_m)) for each in some] for some in identities]


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        (
            estimates(X, Y, np.array([20.0, 40.0, 20.0, 44.0])),
            "answers with positions outside their boxes; boxes are x",
        ),
        (
            estimates(X / WIDTH, Y / HEIGHT, BOX / np.array([WIDTH, HEIGHT] * 2)),
            "answers in the picture's first pixel, from 0 to 1; boxes are x_min, y_min, x_max, y_max in pixels of the",
        ),
        (estimates(X + 5000, Y), "answers outside the picture; boxes are"),
        (tracks(*([k] for k in range(FRAMES))), "gives all targets new identities; a target keeps"),
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
    answers = [*tracks(*[[1, 2]] * 5), *tracks([1, 2], depth_m=None)]
    assert told(answers, needs_depth=True) == [
        "gives tracks without depth_m, which this suite needs; CONTRIBUTING.md says what else"
    ]


def test_a_closed_guard_tells_what_was_odd_and_a_run_how_often() -> None:
    class Apart(FakeTracker):
        def update(self, observation: Observation) -> Estimate:
            return replace(super().update(observation), box_xyxy=np.arange(4.0))

    guard, episode = GuardedTracker(lambda: FromPictures(Apart()), 60.0), FakeEpisode()
    guard.initialise(episode.step(), episode.start)
    for _ in range(FRAMES):
        guard.update(episode.step())
    guard.close()
    (odd,) = guard.oddities
    outcome = Outcome(oddities=Counter({("mine", odd): 1}), silent=Counter(mine=3))
    assert list(outcome.followed_by(outcome).oddities_in_words("nothing")) == [
        "mine gave no answer (NaN) on 6 frames; each counts as nothing",
        f"mine {odd}, in 2 episodes",
    ]
