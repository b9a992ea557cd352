"""A controller that steers an episode's camera, guarded: whatever it does, the episode goes on and is scored."""

from __future__ import annotations

from dataclasses import astuple

import numpy as np

from benchmarks.run.time_limit import TooSlow, at_most
from scenarios.command_link import CommandLink
from trackers.protocols import Controller
from trackers.types import CameraCommand, Estimate, Observation


class Steering:
    """Asks a controller for a command at every picture. One that fails commands nothing from there on.

    Attributes:
        reason: why it failed, None if it did not.
        failed_at_frame: the frame that its first missing command should have led to.
    """

    def __init__(self, controller: Controller, link: CommandLink | None, limit_s: float) -> None:
        """``link`` takes commands to the carrier; None takes them there as they are."""
        self._controller = controller
        self._link = link
        self._limit_s = limit_s
        self._frame = 0
        self.reason: str | None = None
        self.failed_at_frame: int | None = None

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the command that the carrier obeys until the next picture."""
        self._frame += 1
        wanted = self._ask(observation, estimate) if self.reason is None else CameraCommand()
        return wanted if self._link is None else self._link.send(wanted)

    def _ask(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        try:
            with at_most(self._limit_s):
                wanted = self._controller.command(observation, estimate)
            if not np.isfinite(astuple(wanted)).all():
                raise ValueError(f"command: expected finite numbers, got {wanted}")
            return wanted
        except TooSlow:
            self._fail(f"took longer than {self._limit_s:g} s over one command")
        except Exception as error:
            self._fail(f"{type(error).__name__}: {error}".splitlines()[0])
        return CameraCommand()

    def _fail(self, reason: str) -> None:
        self.reason, self.failed_at_frame = reason, self._frame
