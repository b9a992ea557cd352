"""``python -m tools learn-colours``: learn colour models of road and other ground from development towns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from benchmarks.cli.arguments import SEEDS, development_seeds, names
from benchmarks.papers.ground_colours import learn_colours, write_model
from sim.checks import check


@dataclass(frozen=True)
class LearnColours:
    """Learn mean and variance of the colours of road and other ground in each light; write them to the trackers' file.

    Pictures come from development towns only, labels from their truth.

    Attributes:
        preset: one or more of the town's presets to take towns from.
        seeds: towns A to B - 1, or A alone, below 10,000.
        every: use one frame in this number.
    """

    preset: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME …")] = ("quick",)
    seeds: Annotated[str, SEEDS] = "0:16"
    every: int = 60
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        seeds = development_seeds(self.seeds)
        check("every", self.every >= 1, "a whole number >= 1", self.every)
        command = (
            f"python -m tools learn-colours --preset {' '.join(self.preset)} --seeds {self.seeds} --every {self.every}"
        )
        model = learn_colours(names(self.preset), seeds, self.every)
        print(write_model(model, command))
        return 0
