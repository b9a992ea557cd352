"""The command that judges a trained policy with pictures, and the time that it takes."""

from __future__ import annotations

import math
import shlex
from dataclasses import dataclass
from pathlib import Path

from benchmarks.contract.suite import controllers_suite
from benchmarks.learning.training import Training
from benchmarks.run.episode_time import seconds_of_episode
from benchmarks.run.selection import job_on
from benchmarks.run.workers import cores

SEEDS = range(9_996, 10_000)
"""Development episodes; a training without pictures reaches them only if it plans nearly all there are."""
_ALONE = "centre"
"""The controller that a policy without one is compared with."""


@dataclass(frozen=True)
class Judging:
    """A few episodes of suite ``follow`` with a policy, and as many with the controller that it corrects.

    Attributes:
        training: of the policy.
        policy: its file.
    """

    training: Training
    policy: Path

    @property
    def controller(self) -> str:
        """The controller that the policy is compared with."""
        own = self.training.controller_name
        return _ALONE if own == "none" else own

    @property
    def command(self) -> str:
        """The command, quoted for a shell."""
        own = self.training
        words = ["frameout", "bench", controllers_suite().name, "--scenario", own.scenario]
        words += ["--preset", own.preset_name, "--trackers", own.tracker_name]
        words += ["--controllers", f"policy:{self.policy}", self.controller]
        words += ["--seeds", f"{SEEDS.start}:{SEEDS.stop}", "--out", str(self.policy.parent / "judged")]
        return shlex.join([*words, *(("--modules", *own.modules) if own.modules else ())])

    def minutes(self) -> int:
        """Return about how many minutes the command takes, rounded up, on cores that do nothing else.

        Some frames of the first episode are run to measure it, see ``seconds_of_episode``. The time for compilation on
        a new machine, and for the report, is not in it.
        """
        own = self.training
        steered = job_on(
            controllers_suite(),
            own.scenario,
            own.preset_name,
            SEEDS.start,
            (own.tracker_name,),
            controller=self.controller,
            link="prompt",
            modules=own.modules,
        )
        # An episode with the policy takes as long: its network is small.
        rounds = math.ceil(2 * len(SEEDS) / cores(None))
        return math.ceil(rounds * seconds_of_episode(steered) / 60.0)
