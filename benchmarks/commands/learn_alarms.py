"""``frameout learn-alarms``: learn from episodes what baselines and the blind contestant of intruders ship."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from joblib import Parallel, delayed

from benchmarks.commands.arguments import SEEDS, development_seeds
from benchmarks.papers.learn_alarms import CONFIDENCE_PATH, PLACES_PATH, PRESETS, episode_samples, learn_alarms
from benchmarks.papers.learn_swims import write


@dataclass(frozen=True)
class LearnAlarms:
    """Learn how the tracks of intruders look and where these often are, and write it to the files of the baselines and
    the blind contestant.

    Attributes:
        seeds: episodes A to B - 1, or A alone, of each preset, below 10,000.
    """

    seeds: Annotated[str, SEEDS] = "0:2"
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        command = f"frameout learn-alarms --seeds {self.seeds}"
        episodes = [(preset, seed) for preset in PRESETS for seed in development_seeds(self.seeds)]
        samples = Parallel(n_jobs=-1)(delayed(episode_samples)(preset, seed) for preset, seed in episodes)
        for path, content in zip((CONFIDENCE_PATH, PLACES_PATH), learn_alarms(samples), strict=True):
            print(write(path, content, command))
        return 0
