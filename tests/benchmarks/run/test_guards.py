"""An episode continues after any failure of a controller."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
import pytest

from benchmarks.run.guards import GuardedController
from scenarios.command_link import CommandLink, Link
from scenarios.loop import FromPictures, Loop
from scenarios.road_town.flight import HELICOPTER
from tests.benchmarks.fake_episode import FakeEpisode, FakeTracker
from trackers.types import CameraCommand, CameraModel, Estimate, Observation

PICTURE = Observation(np.zeros((4, 4, 3), np.uint8), 0.0, CameraModel(4, 4, 4.0))
SOMEWHERE = Estimate(np.zeros(2))


@dataclass
class Scripted:
    """Returns the given commands; raises the given exceptions."""

    answers: list[object]
    asked: list[Estimate] = field(default_factory=list)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the next answer."""
        self.asked.append(estimate)
        answer = self.answers[len(self.asked) - 1]
        if isinstance(answer, Exception):
            raise answer
        if answer == "sleeps":
            time.sleep(5.0)
        return answer  # type: ignore[return-value]


AHEAD = CameraCommand(forward_mps=5.0)


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (RuntimeError("a bug\nin two lines"), "RuntimeError: a bug"),
        (CameraCommand(yaw_rate_rad_s=float("nan")), "ValueError: command: expected finite numbers, got"),
        (None, "TypeError"),
        ("sleeps", "took longer than 0.2 s over one command"),
    ],
)
def test_one_that_fails_commands_nothing_from_there_on(answer: object, reason: str) -> None:
    controller = Scripted([AHEAD, answer, AHEAD])
    guard = GuardedController(controller, limit_s=0.2)
    given = [guard.command(PICTURE, SOMEWHERE) for _ in range(3)]
    assert given == [AHEAD, CameraCommand(), CameraCommand()]
    assert len(controller.asked) == 2
    assert guard.failed_at_frame == 2
    assert str(guard.reason).startswith(reason)


def test_the_link_is_between_controller_and_carrier() -> None:
    episode = FakeEpisode(rate_hz=10.0)
    loop = Loop(episode, [FromPictures(FakeTracker())], CommandLink(HELICOPTER, 10.0, Link(), np.random.default_rng(0)))
    guard = GuardedController(Scripted([CameraCommand(forward_mps=1e3), RuntimeError()]), limit_s=1.0)
    obeyed = [loop.obeyed for _ in loop.frames(guard, 3)]
    assert obeyed[0] is None
    assert obeyed == episode.commands
    # After a failure nothing is commanded: the carrier comes to rest at its limits.
    forward = HELICOPTER.axes[0]
    speeds = [command.forward_mps for command in obeyed[1:] if command is not None]
    assert speeds == pytest.approx([forward.slew_per_s / 10.0, 0.0])
    assert guard.reason == "RuntimeError: "
