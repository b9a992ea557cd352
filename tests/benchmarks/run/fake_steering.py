"""Controllers for the world of one line of arithmetic, good and bad, and the suite ``follow`` about it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from benchmarks.contract.suite import Scene, Suite
from benchmarks.judges.follow.suite import FOLLOW
from tests.fakes_scenario import FAKE_TOWN
from trackers.controllers.catalogue import ControllerEntry
from trackers.controllers.centring import CentreController
from trackers.types import CameraCommand, Estimate, Observation

FAKE_FOLLOW: Suite = replace(
    FOLLOW,
    scenes=(Scene(FAKE_TOWN.id, "frame-out", ("fake_knowing", "fake_still")),),
    preset="tiny",
    quick_preset="tiny",
)


@dataclass(frozen=True)
class NothingToSet:
    """No parameters."""


class RaisingController:
    """Has a bug."""

    Parameters = NothingToSet

    def __init__(self, parameters: NothingToSet) -> None:
        self._commands = 0

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return forward at full speed, until it raises."""
        self._commands += 1
        if self._commands == 20:
            raise RuntimeError("a bug")
        return CameraCommand(forward_mps=25.0)


class NanController(RaisingController):
    """Divides by zero."""

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return what no carrier can obey."""
        return CameraCommand(forward_mps=float("nan"))


FAKE_CONTROLLERS = (
    ControllerEntry("fake_ours", "helicopter", "ours", "centre by another name", CentreController),
    ControllerEntry("fake_raises", "helicopter", "baseline", "raises at its twentieth command", RaisingController),
    ControllerEntry("fake_nan", "helicopter", "baseline", "commands NaN at once", NanController),
)
