"""``python -m tools learn-swims``: learn from simulated swims what gap methods ship."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Annotated

from benchmarks.cli.arguments import SEEDS, development_seeds
from tools.learn.swims import (
    DECAY_PATH,
    NOISE_PATH,
    PRIOR_PATH,
    detected_track,
    fit_decay,
    fit_noise,
    learn_swims,
    preset_tracks,
    write,
)

_EPISODES, _PRESET_SEEDS = 6, 12


@dataclass(frozen=True)
class LearnSwims:
    """Learn how fish go on from simulated swims, and write it to the files that gap methods load.

    Our regressions learn from many kinds of fish, the noise of ca_kalman from at most 6 episodes of preset paper-c, and
    the decay of damped velocity from at most 12 swims of standard.

    Attributes:
        seeds: swims A to B - 1, or A alone, below 10,000.
    """

    seeds: Annotated[str, SEEDS] = "0:80"
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        seeds = development_seeds(self.seeds)
        command = f"python -m tools learn-swims --seeds {self.seeds}"
        slow = [detected_track("paper-c", seed) for seed in seeds[:_EPISODES]]
        usual = [piece for seed in seeds[:_PRESET_SEEDS] for piece in preset_tracks("standard", seed)]
        print(write(NOISE_PATH, asdict(fit_noise(slow)), command))
        print(write(DECAY_PATH, {"decay_frames": fit_decay(usual)}, command))
        print(write(PRIOR_PATH, learn_swims(seeds), command))
        return 0
