"""The loop through an episode: its calls of trackers and controllers, and the commands that reach the carrier."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.command_link import Link, episode_link
from scenarios.loop import FromPictures, Loop, ManyFromPictures, tracker_stream
from scenarios.road_town.flight import HELICOPTER
from scenarios.scenario import Frame
from tests.benchmarks.fake_episode import CAMERA, FakeEpisode
from trackers.types import CameraCommand, CameraModel, Estimate, Observation, Start, Track


@dataclass
class Writing:
    """Records its calls; answers with a target at ``place_px`` and the frame's number."""

    place_px: float
    calls: list[tuple[str, int]] = field(default_factory=list)

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``LoopTracker``."""
        self.calls.append(("start", frame.truth.frame))
        return self._answer(frame)

    def update(self, frame: Frame) -> Estimate:
        """See ``LoopTracker``."""
        self.calls.append(("ask", frame.truth.frame))
        return self._answer(frame)

    def _answer(self, frame: Frame) -> Estimate:
        return Estimate(np.array([self.place_px, float(frame.truth.frame)]))


class SpoilsItsBox:
    """A tracker that overwrites the box that it is given, and answers with it."""

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        self._box = box_xyxy
        self._box[:] = -1.0

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        return Estimate(self._box[:2])


class Background:
    """A multi-target tracker that answers with one track per picture of the background."""

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self.camera, self._learnt = camera, background

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        return [Track(k, Estimate(np.full(2, seen.time_s - observation.time_s))) for k, seen in enumerate(self._learnt)]


class ToTheSide:
    """Commands a speed in m/s equal to the estimate's first number."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Controller``."""
        return CameraCommand(right_mps=float(estimate.position_px[0]))


@dataclass
class Noting:
    """Notes the time of each observation, and the second number of the estimate."""

    seen: list[tuple[float, float]] = field(default_factory=list)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Controller``."""
        self.seen.append((observation.time_s, float(estimate.position_px[1])))
        return CameraCommand()


def test_each_is_started_once_and_asked_about_every_later_frame() -> None:
    trackers = [Writing(1.0), Writing(2.0)]
    loop = Loop(FakeEpisode(), trackers)
    steps = [(frame.truth.frame, loop.answers, loop.obeyed, loop.is_over) for frame in loop.frames(count=3)]
    assert [each.calls for each in trackers] == [[("start", 0), ("ask", 1), ("ask", 2)]] * 2
    assert [frame for frame, *_ in steps] == [0, 1, 2]
    places = [[answer.position_px.tolist() for answer in answers] for _, answers, *_ in steps]
    assert places == [[[1.0, k], [2.0, k]] for k in (0.0, 1.0, 2.0)]
    assert [(obeyed, over) for *_, obeyed, over in steps] == [(None, False)] * 3


def test_the_box_given_is_a_tracker_s_first_answer_whatever_becomes_of_it() -> None:
    episode = FakeEpisode()
    loop = Loop(episode, [FromPictures(SpoilsItsBox()), FromPictures(SpoilsItsBox())])
    loop.step()
    box = episode.start.box_xyxy
    assert box is not None
    for estimate in loop.answers:
        assert isinstance(estimate, Estimate)
        assert estimate.box_xyxy is not None
        assert estimate.box_xyxy.tolist() == box.tolist()
        assert estimate.position_px.tolist() == [0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3])]
        assert estimate.in_view_probability == 1.0
    loop.step()
    assert loop.estimate.position_px.tolist() == [-1.0, -1.0]


def test_the_box_that_an_episode_keeps_is_not_the_tracker_s() -> None:
    start = Start(CAMERA, box_xyxy=np.array([1.0, 2.0, 3.0, 4.0]))
    FromPictures(SpoilsItsBox()).initialise(FakeEpisode().step(), start)
    assert start.box_xyxy is not None
    assert start.box_xyxy.tolist() == [1.0, 2.0, 3.0, 4.0]


def test_one_of_many_targets_is_told_the_background_and_asked_about_the_first_picture_too() -> None:
    first = FakeEpisode().step()
    empty = tuple(replace(first.observation, time_s=-time_s) for time_s in (2.0, 1.0))
    tracker = Background()
    many = ManyFromPictures(tracker)
    answers = [many.initialise(first, Start(CAMERA, background=empty)), many.update(first)]
    assert tracker.camera == CAMERA
    for tracks in answers:
        assert [(track.identity, track.estimate.position_px.tolist()) for track in tracks] == [
            (0, [-2.0, -2.0]),
            (1, [-1.0, -1.0]),
        ]


def test_where_no_target_is_pointed_at_a_tracker_of_one_is_refused() -> None:
    with pytest.raises(ValueError, match="start: expected the box of a target, got none"):
        FromPictures(SpoilsItsBox()).initialise(FakeEpisode().step(), Start(CAMERA))


def test_all_frames_are_lived_through_unless_fewer_are_asked_for() -> None:
    loop = Loop(FakeEpisode(frame_count=5))
    assert len(list(loop.frames())) == 5
    assert loop.is_over


def test_the_first_tracker_steers_and_frame_0_is_not_steered_to() -> None:
    episode = FakeEpisode()
    list(Loop(episode, [Writing(3.0), Writing(8.0)]).frames(ToTheSide(), 4))
    steered = [command and command.right_mps for command in episode.commands]
    assert steered == [None, 3.0, 3.0, 3.0]


def test_a_link_is_between_command_and_carrier_and_what_is_obeyed_is_told() -> None:
    episode, delay = FakeEpisode(), Link(delay_frames=1)
    loop = Loop(episode, [], episode_link(HELICOPTER, episode.rate_hz, delay, 0))
    loop.step()
    for _ in range(2):
        loop.step(CameraCommand(forward_mps=0.1))
        assert episode.commands[-1] == loop.obeyed
    assert episode.commands == [None, CameraCommand(), CameraCommand(forward_mps=pytest.approx(0.1))]


def test_late_pictures_are_seen_once_each_and_the_first_one_until_they_arrive() -> None:
    tracker, controller = Writing(1.0), Noting()
    loop = Loop(FakeEpisode(), [tracker], picture_delay_frames=2)
    steps = [(loop.frame.truth.frame, loop.seen.truth.frame, loop.estimate) for _ in loop.frames(controller, 6)]
    assert [(now, seen) for now, seen, _ in steps] == [(0, 0), (1, 0), (2, 0), (3, 1), (4, 2), (5, 3)]
    assert tracker.calls == [("start", 0), ("ask", 1), ("ask", 2), ("ask", 3)]
    assert [estimate.position_px[1] for *_, estimate in steps] == [seen for _, seen, _ in steps]
    assert controller.seen == [(0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (1 / 15.0, 1.0), (2 / 15.0, 2.0)]


def test_noise_and_trackers_draw_from_streams_of_the_seed() -> None:
    def noisy(seed: int) -> CameraCommand:
        return episode_link(HELICOPTER, 15.0, Link(noise=0.1), seed).send(CameraCommand())

    assert noisy(4) == noisy(4) != noisy(5)
    drawn = [tracker_stream(*words).random() for words in ((4, "a"), (4, "a", 0), (4, "a", 1), (4, "b"), (5, "a"))]
    assert drawn[0] == drawn[1]
    assert len(set(drawn)) == 4
