"""``python -m tools learn-alarms``: learn from episodes what baselines and the blind contestant of intruders ship."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from joblib import Parallel, delayed

from benchmarks.cli.arguments import SEEDS, development_seeds
from tools.learn.alarms import (
    CONFIDENCE_PATHS,
    LEARNERS,
    PLACES_PATH,
    PRESETS,
    episode_samples,
    learn_confidences,
    learn_places,
)
from tools.learn.swims import write


@dataclass(frozen=True)
class LearnAlarms:
    """Learn how the tracks of intruders look, and by the baselines where these often are, and write it to the files of
    the trackers.

    Attributes:
        of: the baselines, and with them the blind contestant, or paper D's method with a learnt confidence.
        seeds: episodes A to B - 1, or A alone, of each preset, below 10,000.
    """

    of: Literal["baselines", "swarm"] = "baselines"
    seeds: Annotated[str, SEEDS] = "0:2"
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        command = f"python -m tools learn-alarms --of {self.of} --seeds {self.seeds}"
        names = LEARNERS[self.of]
        episodes = [(preset, seed) for preset in PRESETS for seed in development_seeds(self.seeds)]
        samples = Parallel(n_jobs=-1)(delayed(episode_samples)(preset, seed, names) for preset, seed in episodes)
        print(write(CONFIDENCE_PATHS[self.of], learn_confidences(samples, names), command))
        if self.of == "baselines":
            print(write(PLACES_PATH, learn_places(samples), command))
        return 0
