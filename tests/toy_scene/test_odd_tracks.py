"""Odd answers of a tracker of many targets, through the guarded loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from benchmarks.run.guards import GuardedTracker
from benchmarks.run.jobs import take_in
from benchmarks.show.video.drawing import InLargerView, Instant
from scenarios.loop import Loop, ManyFromPictures
from tests.toy_scene.judge import ManyJudge
from tests.toy_scene.scenario import TOY_YARD, YardEpisode
from tests.toy_scene.tracker import WarmBodies, WarmParameters
from trackers.follow_one import FollowOne
from trackers.registry import entry
from trackers.types import CameraModel, Estimate, Observation, Track


def track(identity: int, x: float = 10.0) -> Track:
    return Track(identity, Estimate(np.array([x, 10.0])))


class Says:
    """A tracker of many that answers as it is told to, frame by frame."""

    def __init__(self, answers: Any) -> None:
        self._answers = answers

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        self._frame = -1

    def update(self, observation: Observation) -> Any:
        self._frame += 1
        return self._answers(self._frame)


def lived(episode: YardEpisode, answers: Any) -> tuple[GuardedTracker, list[Any], dict[str, Any]]:
    """Return the guard, the answers and the scores of a tracker that says what it is told to."""
    guard = GuardedTracker(lambda: ManyFromPictures(Says(answers)), 60.0, many=True)
    judge = ManyJudge(episode, TOY_YARD)
    loop, sheet, said = Loop(episode, [guard]), judge.sheet(), []
    for _ in loop.frames():
        take_in(loop, judge, [sheet])
        said.append(loop.answers[0])
    scores = {score.metric: score.value for score in sheet.scores(guard.ending())}
    return guard, said, scores


@pytest.mark.parametrize(
    ("answers", "frame", "reason"),
    [
        (lambda k: [track(3), track(3 if k == 5 else 4)], 5, "identity: expected each once in an answer, got 3 twice"),
        # The start holds the box of one crate, which a tracker of many is not given.
        (lambda k: 1 / 0, 0, "division by zero"),
        (lambda k: Estimate(np.zeros(2)), 0, "update: expected a sequence of Tracks, () without any, got Estimate"),
        (lambda k: [track(0, np.nan)], 0, "position_px: expected finite numbers"),
    ],
)
def test_a_failure_is_named_and_no_track_follows(episode: YardEpisode, answers: Any, frame: int, reason: str) -> None:
    guard, said, scores = lived(episode, answers)
    assert guard.failed_at_frame == frame
    assert reason in str(guard.reason)
    assert [len(tracks) for tracks in said] == [2] * frame + [0] * (20 - frame)
    assert scores["false_tracks"] == pytest.approx(2 * frame / 20)


def test_a_track_of_nan_says_nothing_and_is_no_failure(episode: YardEpisode) -> None:
    guard, said, scores = lived(episode, lambda k: [Track(0, Estimate(np.full(2, np.nan)))])
    assert guard.reason is None
    assert (scores["found_rate"], scores["false_tracks"]) == (0.0, 0.0)
    assert all(len(tracks) == 1 for tracks in said)


def test_a_thousand_tracks_are_judged_and_drawn(episode: YardEpisode) -> None:
    guard, said, scores = lived(episode, lambda k: [track(number, number - 450.0) for number in range(1000)])
    assert guard.reason is None
    assert [len(tracks) for tracks in said] == [1000] * 20
    assert scores["false_tracks"] > 990
    frame = next(Loop(TOY_YARD.episode("quick", 1)).frames())
    picture = InLargerView().picture(Instant(frame, (0, 1), said[0], frame.observation.image_rgb))
    assert picture.ndim == 3


def test_a_track_that_dies_and_comes_back_is_the_same_one_again(episode: YardEpisode) -> None:
    """The judge counts no switch, and the adapter of one target goes on."""

    def answers(k: int) -> list[Track]:
        return [] if 5 <= k < 9 else [Track(7, Estimate(places[k]))]

    frames = list(Loop(TOY_YARD.episode("quick", 1)).frames())
    places = [frame.truth.position_px[0] for frame in frames]
    guard, said, scores = lived(episode, answers)
    assert guard.reason is None
    assert [len(tracks) for tracks in said] == [1] * 5 + [0] * 4 + [1] * 11
    assert scores["identity_switches"] == 0.0
    one = FollowOne(Says(answers))
    one.initialise(frames[0].observation, frames[0].truth.box_xyxy[0])
    known = [bool(np.isfinite(one.update(frame.observation).position_px).all()) for frame in frames[1:]]
    assert known == [True] * 4 + [False] * 4 + [True] * 11


def test_identities_are_drawn_beside_their_tracks(episode: YardEpisode) -> None:
    frame = next(Loop(episode).frames())
    nothing = np.zeros((720, 960, 3), np.uint8)
    pictures = [
        InLargerView().picture(Instant(frame, (), [Track(number, Estimate(np.array([40.0, 30.0])))], nothing))
        for number in (1, 2, 1)
    ]
    assert (pictures[0] == pictures[2]).all()
    assert (pictures[0] != pictures[1]).any()


def test_the_tracker_keeps_identities_over_a_gap_and_gives_none_away_twice(episode: YardEpisode) -> None:
    frames = list(Loop(episode).frames())
    tracker = WarmBodies(WarmParameters(), np.random.default_rng(0))
    tracker.start(episode.start.background, episode.start.camera)
    background = episode.start.background[0]
    seen = [tracker.update(frame.observation) for frame in frames[:6]]
    # Nothing warm for three frames.
    for frame in frames[6:9]:
        empty = Observation(background.image_rgb, frame.observation.time_s, background.camera, counts=background.counts)
        assert tracker.update(empty) == []
    back = tracker.update(frames[9].observation)
    assert {each.identity for each in back} == {each.identity for each in seen[-1]} == {0, 1}


def test_the_tracker_does_without_background_and_without_counts(episode: YardEpisode) -> None:
    tracker = WarmBodies(WarmParameters(), np.random.default_rng(0))
    tracker.start((), episode.start.camera)
    frame = next(Loop(episode).frames())
    seen = frame.observation
    assert len(tracker.update(Observation(seen.image_rgb, 0.0, seen.camera))) == 2
    assert entry("warm_bodies").follows_many
