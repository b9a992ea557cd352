"""The loop through an episode: what each is told and when, and what reaches the carrier."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.command_link import Link, episode_link
from scenarios.loop import Loop, tracker_stream
from scenarios.road_town.flight import HELICOPTER
from scenarios.scenario import Frame
from tests.benchmarks.fake_episode import FakeEpisode
from trackers.types import CameraCommand, Estimate, Observation


@dataclass
class Writing:
    """Writes down what it is told; says that its target is at ``place_px`` and the frame's number."""

    place_px: float
    told: list[tuple[str, int]] = field(default_factory=list)

    def initialise(self, frame: Frame, box_xyxy: NDArray[np.float64]) -> None:
        """Spoil the box, which is its own."""
        self.told.append(("start", frame.truth.frame))
        box_xyxy[:] = -1.0

    def update(self, frame: Frame) -> Estimate:
        """See ``Contestant``."""
        self.told.append(("ask", frame.truth.frame))
        return Estimate(np.array([self.place_px, float(frame.truth.frame)]))


class ToTheSide:
    """Commands as many metres a second as the estimate's first number."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """See ``Controller``."""
        return CameraCommand(right_mps=float(estimate.position_px[0]))


def test_each_is_started_once_and_asked_about_every_later_frame() -> None:
    contestants = [Writing(1.0), Writing(2.0)]
    loop = Loop(FakeEpisode(), contestants)
    said = [(frame.truth.frame, loop.estimates, loop.obeyed, loop.is_over) for frame in loop.frames(count=3)]
    assert [each.told for each in contestants] == [[("start", 0), ("ask", 1), ("ask", 2)]] * 2
    assert [frame for frame, *_ in said] == [0, 1, 2]
    assert [estimate.position_px.tolist() for estimate in said[2][1]] == [[1.0, 2.0], [2.0, 2.0]]
    assert [(obeyed, over) for *_, obeyed, over in said] == [(None, False)] * 3


def test_the_box_given_is_the_first_estimate_whatever_becomes_of_it() -> None:
    episode = FakeEpisode()
    loop = Loop(episode, [Writing(1.0), Writing(2.0)])
    loop.step()
    box = episode.target_box_xyxy
    for estimate in loop.estimates:
        assert estimate.box_xyxy is not None
        assert estimate.box_xyxy.tolist() == box.tolist()
        assert estimate.position_px.tolist() == [0.5 * (box[0] + box[2]), 0.5 * (box[1] + box[3])]
        assert estimate.in_view_probability == 1.0


def test_all_frames_are_lived_through_unless_fewer_are_asked_for() -> None:
    loop = Loop(FakeEpisode(frame_count=5))
    assert len(list(loop.frames())) == 5
    assert loop.is_over


def test_the_first_contestant_steers_and_frame_0_is_not_steered_to() -> None:
    episode = FakeEpisode()
    given = episode.target_box_xyxy[[0, 2]].mean()
    list(Loop(episode, [Writing(3.0), Writing(8.0)]).frames(ToTheSide(), 4))
    steered = [command and command.right_mps for command in episode.commands]
    assert steered == [None, pytest.approx(given), 3.0, 3.0]


def test_a_link_is_between_command_and_carrier_and_what_is_obeyed_is_told() -> None:
    episode, delay = FakeEpisode(), Link(delay_frames=1)
    loop = Loop(episode, [], episode_link(HELICOPTER, episode.rate_hz, delay, 0))
    loop.step()
    for _ in range(2):
        loop.step(CameraCommand(forward_mps=0.1))
        assert episode.commands[-1] == loop.obeyed
    assert episode.commands == [None, CameraCommand(), CameraCommand(forward_mps=pytest.approx(0.1))]


def test_noise_and_trackers_draw_from_streams_of_the_seed() -> None:
    def noisy(seed: int) -> CameraCommand:
        return episode_link(HELICOPTER, 15.0, Link(noise=0.1), seed).send(CameraCommand())

    assert noisy(4) == noisy(4) != noisy(5)
    drawn = [tracker_stream(*words).random() for words in ((4, "a"), (4, "a", 0), (4, "a", 1), (4, "b"), (5, "a"))]
    assert drawn[0] == drawn[1]
    assert len(set(drawn)) == 4
