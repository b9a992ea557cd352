"""The controller ``omniscient`` of the suite ``follow``: it knows the target's path and all that moves the camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenarios.command_link import Link
from sim.checks import check
from trackers.types import CameraCommand, Estimate, Observation

if TYPE_CHECKING:
    from benchmarks.judges.follow.planning import Planner


@dataclass(frozen=True)
class OmniscientParameters:
    """Settings of the search for the best commands.

    Attributes:
        horizon_frames: number of frames that are planned.
        plans: number of plans that are tried in each round. rounds: number of rounds.
        best: share of the plans whose mean the next round begins with.
        spread: standard deviation of the first round's plans, as a share of a command's limit.
    """

    horizon_frames: int = 30
    plans: int = 96
    rounds: int = 2
    best: float = 0.125
    spread: float = 0.3


class OmniscientController:
    """Plans with the episode's own dynamics by the cross-entropy method, and replans on every picture.

    It moves a twin of the carrier in the world without pictures, whose paths are those of the rendered one, and never
    looks at an estimate. A plan is worth the env's reward without ``loss``, and the time for which the target is seen,
    so that it looks round those who hide it; less a cost of a target outside the picture, and of one far ahead, that
    grows with its distance. The best plan of a picture is the first guess on the next one (Kobilarov, Cross-entropy
    motion planning, 2012).
    """

    Parameters = OmniscientParameters

    def __init__(self, parameters: OmniscientParameters) -> None:
        self.parameters = parameters
        self._planner: Planner | None = None

    def foresee(self, scenario: str, configuration: Any, seed: int, link: Link) -> None:
        """Take the episode that is to be steered. Raises ValueError for a scenario without such a world."""
        # It imports kernels, which takes seconds.
        from benchmarks.judges.follow.planning import Planner

        self._planner = Planner(self.parameters, scenario, configuration, seed, link)

    def command(self, observation: Observation, estimate: Estimate) -> CameraCommand:
        """Return the first command of the best plan."""
        check("controller", self._planner is not None, "an episode that it knows, in suite follow", "none")
        assert self._planner is not None
        return CameraCommand(**dict(zip(self._planner.commands, self._planner.command().tolist(), strict=True)))
