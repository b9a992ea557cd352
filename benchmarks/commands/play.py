"""``frameout play``: a person steers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.commands.arguments import FOLDER, ONE_NAME, SEEDS, seed_range
from benchmarks.commands.leaderboard import print_leaderboard
from benchmarks.learning import playing
from benchmarks.report.page import write_report
from benchmarks.run.experiment import make_folder
from benchmarks.scores.summary import write_summary
from scenarios import catalog
from sim.checks import check


@dataclass(frozen=True)
class Play:
    """Steer a camera yourself, by what it sees and an orange cross where the tracker believes the target to be.

    Keys: w and s go ahead and back; a and d go left and right (a robot turns); q and e turn, r and f climb and sink.
    Every episode played to its end is scored and written as rows of suite `follow`, by the controller `human`, into
    the folder: the report shows you among the others. Needs pygame (pip install 'frameout[play]').

    Attributes:
        env: env id, see `frameout list`.
        preset: of the scenario.
        tracker: in the loop (default: the env's).
        link: prompt, delayed or noisy: how commands reach the carrier.
        seeds: episodes A to B - 1.
        zoom: of the picture.
        out: folder for the rows; that of a bench run, so that you stand on its table.
    """

    env: tyro.conf.Positional[str] = "frameout/RoadTownFollow-v1"
    preset: str = "standard"
    tracker: Annotated[str, ONE_NAME] = ""
    link: str = "prompt"
    seeds: Annotated[str, SEEDS] = "10000:10003"
    zoom: float = 1.0
    out: Annotated[Path, FOLDER] = Path("results/follow")

    def run(self) -> int:
        """Play; return the exit status."""
        check("env", self.env in catalog.envs(), f"one of {', '.join(catalog.envs())}", repr(self.env))
        check("zoom", 0 < self.zoom <= 8, "a number in (0, 8]", self.zoom)
        make_folder(self.out)
        tracker = self.tracker or catalog.envs()[self.env][1]
        seeds = seed_range(self.seeds)
        played = playing.play(playing.Play(self.env, self.preset, tracker, self.link, seeds, self.out, self.zoom))
        if played == 0:
            print("no episode was played to its end")
            return 0
        print_leaderboard(write_summary(self.out))
        print(f"rows: {self.out / 'records.jsonl'}\nreport: {write_report(self.out)}")
        return 0
