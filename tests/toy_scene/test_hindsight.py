"""Answers that a tracker of many revises at the end, and its method to bridge gaps, through the guarded loop."""

from __future__ import annotations

import gc
import time
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from benchmarks.contract.judging import Ending
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.blindfold import ManyBlindfolded
from benchmarks.run.guards import GuardedTracker
from scenarios.loop import FromPictures, Loop, LoopTracker, ManyFromPictures, ManyLoopTracker
from tests.benchmarks.fake_episode import FakeTracker
from tests.toy_scene.scenario import TOY_YARD, YardEpisode
from trackers.gaps import Bridge, Piece, Surroundings
from trackers.types import CameraModel, Estimate, Observation, Track

PAST = Piece(0, np.zeros((4, 2)), 0.1)
FUTURE = Piece(7, np.zeros((4, 2)), 0.1)


class Follows:
    """Follows one target, which it calls 0."""

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        self.seen = 0

    def update(self, observation: Observation) -> list[Track]:
        self.seen += 1
        return [Track(0, Estimate(np.zeros(2)))]


class Revises(Follows):
    """Says at the end what it is told to say of its number of pictures."""

    def __init__(self, revised: Any) -> None:
        self._revised = revised

    def revised(self) -> Any:
        return self._revised(self.seen)


class Bridges(Follows):
    """Has a gap method: extrapolates by what it is told, and needs no second end."""

    def __init__(self, extrapolated: Any = lambda count: Bridge(np.ones((count, 2)))) -> None:
        self.gap_method = self
        self._extrapolated = extrapolated
        self.lessons = 0

    def learn(self, pieces: Sequence[Piece]) -> None:
        self.lessons += 1

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        answer: Bridge | None = self._extrapolated(count)
        return answer

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        return None


def ended(episode: YardEpisode, tracker: LoopTracker, limit_s: float = 60.0) -> tuple[GuardedTracker, Ending]:
    guard = GuardedTracker(lambda: tracker, limit_s, many=isinstance(tracker, ManyLoopTracker))
    assert len(list(Loop(episode, [guard]).frames())) == 20
    return guard, guard.ending()


def test_revised_answers_are_asked_for_once_all_pictures_were_seen(episode: YardEpisode) -> None:
    revised = [[Track(k, Estimate(np.zeros(2)))] for k in range(20)]
    guard, ending = ended(episode, ManyFromPictures(Revises(lambda seen: revised[:seen])))
    assert guard.reason is None
    assert [[track.identity for track in tracks] for tracks in ending.revised] == [[k] for k in range(20)]
    assert (ending.failed_at_frame, ending.new_gap_method) == (None, None)


def test_one_that_does_not_revise_leaves_nothing(episode: YardEpisode) -> None:
    _, ending = ended(episode, ManyFromPictures(Follows()))
    assert ending == Ending()
    assert GuardedTracker(lambda: FromPictures(FakeTracker()), 60.0).ending() == Ending()


def test_one_that_saw_no_picture_has_none_to_revise_and_bridges_gaps_all_the_same() -> None:
    """As on tracks, on which its answers are never asked for."""

    class Asked(Bridges):
        def revised(self) -> Any:
            raise AttributeError("it has not begun")

    guard = GuardedTracker(lambda: ManyFromPictures(Asked()), 60.0, many=True)
    ending = guard.ending()
    assert (guard.reason, ending.failed_at_frame, ending.revised) == (None, None, None)
    assert ending.new_gap_method is not None


def late(seen: int) -> list[list[Track]]:
    time.sleep(60.0)
    return [[]] * seen


@pytest.mark.parametrize(
    ("revised", "reason"),
    [
        (lambda seen: 1 / 0, "ZeroDivisionError"),
        (lambda seen: [[]] * (seen - 1), "ValueError: revised: expected an answer on each of 20 pictures, got 19"),
        (lambda seen: 7, "ValueError: revised: expected a sequence of answers, got int"),
        (
            lambda seen: [[7]] * seen,
            "ValueError: update: expected a sequence of Tracks, () without any, got one of int",
        ),
        (late, "took longer than"),
    ],
)
def test_a_revision_that_fails_is_a_failure_after_the_last_frame(
    episode: YardEpisode, revised: Any, reason: str
) -> None:
    guard, ending = ended(episode, ManyFromPictures(Revises(revised)), limit_s=0.1)
    assert str(guard.reason).startswith(reason)
    assert (guard.failed_at_frame, ending.failed_at_frame, ending.revised) == (20, 20, None)
    assert {score.metric: score.value for score in guard.scores()}["failed_at_frame"] == 20.0


def test_the_time_of_a_revision_is_shared_among_frames(episode: YardEpisode) -> None:
    def slow(seen: int) -> list[list[Track]]:
        until = time.thread_time() + 0.2
        while time.thread_time() < until:
            pass
        return [[]] * seen

    guard, _ = ended(episode, ManyFromPictures(Revises(slow)))
    quick, _ = ended(TOY_YARD.episode("quick", 1), ManyFromPictures(Follows()))
    times = [{score.metric: score.value for score in each.scores()}["cpu_ms_per_frame"] for each in (guard, quick)]
    assert 200 / 20 <= float(times[0]) < 200 / 20 + 5
    assert float(times[1]) < 5


def test_one_that_follows_nothing_has_no_times(episode: YardEpisode) -> None:
    class Silent(Bridges):
        def update(self, observation: Observation) -> list[Track]:
            return []

    guard, _ = ended(episode, ManyFromPictures(Silent()))
    assert list(guard.scores()) == []


def test_a_gap_method_is_handed_on_and_checked(episode: YardEpisode) -> None:
    tracker = Bridges()
    guard, ending = ended(episode, ManyFromPictures(tracker))
    assert ending.new_gap_method is not None
    method = ending.new_gap_method()
    method.learn([PAST])
    bridge = method.extrapolate(PAST, 3, Surroundings())
    assert bridge is not None
    assert bridge.position_px.tolist() == [[1.0, 1.0]] * 3
    assert method.interpolate(PAST, FUTURE, Surroundings()) is None
    # What it learns stays in the copy.
    assert (tracker.lessons, guard.reason) == (0, None)


def test_a_note_is_written_before_a_tracker_is_asked_for_anything(episode: YardEpisode) -> None:
    """Else one that ends its process there is taken for the one whose note is the latest."""
    noted: list[str] = []

    class Asked(Bridges):
        @property
        def decides_at(self) -> float:
            noted.append("threshold")
            return 0.5

    guard = GuardedTracker(
        lambda: ManyFromPictures(Asked()), 60.0, many=True, note=lambda frame: noted.append(f"frame {frame}")
    )
    guard.initialise(Loop(episode).step(), episode.start)
    assert noted.index("frame 0", 1) < noted.index("threshold")


def test_a_closed_guard_holds_nothing_of_its_tracker(episode: YardEpisode) -> None:
    guard, ending = ended(episode, ManyFromPictures(Bridges()))
    assert ending.new_gap_method is not None
    method = weakref.ref(guard.gap_method)
    del ending
    guard.close()
    gc.collect()
    assert method() is None


def test_a_gap_method_knows_nothing_of_the_pictures_of_its_gaps(episode: YardEpisode) -> None:
    class Peeks(Bridges):
        def update(self, observation: Observation) -> list[Track]:
            self._extrapolated = lambda count: Bridge(np.full((count, 2), 9.0))
            return super().update(observation)

    _, ending = ended(episode, ManyFromPictures(Peeks()))
    assert ending.new_gap_method is not None
    bridge = ending.new_gap_method().extrapolate(PAST, 1, Surroundings())
    assert bridge is not None
    assert bridge.position_px.tolist() == [[1.0, 1.0]]


def test_one_that_answers_with_hindsight_alone_has_times(episode: YardEpisode) -> None:
    class Late(Revises):
        def update(self, observation: Observation) -> list[Track]:
            super().update(observation)
            return []

    revised = [[Track(k, Estimate(np.zeros(2)))] for k in range(20)]
    guard, _ = ended(episode, ManyFromPictures(Late(lambda seen: revised)))
    assert {score.metric for score in guard.scores()} == {*TIMES}


@pytest.mark.parametrize("answer", [lambda count: 1 / 0, lambda count: Bridge(np.ones((count + 1, 2)))])
def test_a_gap_method_that_fails_predicts_nan_from_there_on(episode: YardEpisode, answer: Any) -> None:
    tracker = Bridges(answer)
    guard, ending = ended(episode, ManyFromPictures(tracker))
    assert ending.new_gap_method is not None
    method = ending.new_gap_method()
    bridges = [method.extrapolate(PAST, 5, Surroundings()), method.interpolate(PAST, FUTURE, Surroundings())]
    assert [np.isnan(each.position_px).sum() for each in bridges if each is not None] == [10, 6]
    method.learn([PAST])
    assert guard.failed_at_frame == 20


def test_a_tracker_that_failed_before_is_not_asked(episode: YardEpisode) -> None:
    class Fails(Bridges, Revises):
        def update(self, observation: Observation) -> list[Track]:
            raise RuntimeError("it fails")

    guard, ending = ended(episode, ManyFromPictures(Fails()))
    assert ending == Ending(failed_at_frame=0)
    assert guard.reason == "RuntimeError: it fails"


def test_a_blind_one_sees_no_picture(episode: YardEpisode) -> None:
    class Peeks(Bridges):
        def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
            self.seen, self.told = 0, [tuple(background)]

        def update(self, observation: Observation) -> list[Track]:
            self.told.append((observation.image_rgb.size, observation.settings, observation.counts))
            return super().update(observation)

    tracker = Peeks()
    guard, ending = ended(episode, ManyBlindfolded(tracker))
    assert set(tracker.told) == {(), (0, None, None)}
    assert tracker.seen == 20
    assert guard.reason is None
    assert ending.new_gap_method is not None
    assert ending.new_gap_method().extrapolate(PAST, 2, Surroundings()) is not None


@pytest.mark.parametrize(
    ("told", "kept", "reason"),
    [(None, 0.0, ""), (0.7, 0.7, ""), (1.5, 0.0, "ValueError: decides_at: expected a number from 0 to 1, got 1.5")],
)
def test_a_tracker_may_say_from_which_confidence_on_it_decides(
    episode: YardEpisode, told: float | None, kept: float, reason: str
) -> None:
    tracker = Follows()
    if told is not None:
        tracker.decides_at = told  # type: ignore[attr-defined]
    guard, ending = ended(episode, ManyFromPictures(tracker))
    assert (ending.decides_at, guard.reason or "") == (kept, reason)
