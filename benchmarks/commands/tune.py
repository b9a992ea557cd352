"""``frameout tune``: choose trackers' parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import FOLDER, SEEDS, TEST_SPLIT, WORKERS, cores, names
from benchmarks.commands.learn_colours import development_seeds
from benchmarks.commands.progress import progress_bar
from benchmarks.tuning import TUNED_FOLDER, Budget, tunables, tune, write_tuned
from trackers import registry


@dataclass(frozen=True)
class Tune:
    """Choose trackers' parameters on development seeds, by the same search, score and number of trials for
    each, on the first suite it takes part in.

    Writes trackers/tuned/NAME.json with the values, the score, the number of trials, the seeds and this
    command; from then on these values are used in place of the defaults. Variants share the values of the
    tracker they are made of. Needs Optuna (pip install 'frameout[tune]').

    Attributes:
        trackers: names (default: every tracker that declares something to tune).
        trials: settings to try for each tracker.
        preset: one or more presets; their scores are averaged.
        seeds: episodes A:B, below 10,000; the best setting takes the defaults' place if it is better than they are on
            the B - A episodes after these too.
        workers: processes.
        out: folder for the values (default: trackers/tuned, the only place from which they are used).
    """

    trackers: Annotated[tuple[str, ...], tyro.conf.Positional] = ()
    trials: int = 40
    preset: tuple[str, ...] = ("standard",)
    seeds: Annotated[str, SEEDS] = "0:4"
    workers: Annotated[int | None, WORKERS] = None
    out: Annotated[Path, FOLDER] = TUNED_FOLDER

    def run(self) -> int:
        """Tune them one after the other; return the exit status."""
        seeds = development_seeds(self.seeds)
        if self.trials < 1:
            raise ValueError(f"trials: expected a whole number >= 1, got {self.trials}")
        chosen = names(self.trackers) or tuple(filter(_has_tunables, registry.entries()))
        for name in chosen:
            tunables(name)
        budgets = {
            name: Budget(registry.entry(name).suites[0], names(self.preset), seeds, self.trials, cores(self.workers))
            for name in chosen
        }
        if seeds.stop + len(seeds) > TEST_SPLIT.start:
            raise ValueError(
                f"seeds: expected as many development seeds after them, below {TEST_SPLIT.start}, to check the best "
                f"setting on, got {self.seeds!r}"
            )
        for name in chosen:
            with progress_bar(f"{name}, {self.trials} trials") as progress:
                tuned = tune(name, budgets[name], progress)
            command = (
                f"frameout tune {name} --trials {self.trials} --preset {' '.join(self.preset)} --seeds {self.seeds}"
            )
            path = write_tuned(name, tuned, budgets[name], command, self.out)
            print(
                f"{name}: score {tuned.score:.3f}, with the defaults {tuned.default_score:.3f}; on fresh seeds "
                f"{tuned.fresh_score:.3f} and {tuned.fresh_default_score:.3f}: {path}"
            )
        return 0


def _has_tunables(name: str) -> bool:
    entry = registry.entry(name)
    if entry.name != entry.tuned_as:
        return False
    try:
        tunables(name)
    except ValueError:
        return False
    return True
