"""``frameout play``: steer a camera by hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.cli.arguments import FOLDER, ONE_NAME, Seeds, WithModules
from benchmarks.cli.leaderboard import print_leaderboard
from benchmarks.contract.suite import controllers_suite
from benchmarks.learning import playing
from benchmarks.run.result_folder import make_folder
from benchmarks.show.page import write_report
from benchmarks.show.progress import progress_bar
from benchmarks.statistics.summary import write_summary
from scenarios import catalog
from scenarios.envs.settings import FollowSettings
from sim.checks import check


@dataclass(frozen=True)
class Play(WithModules):
    """Steer a camera by hand, with its picture on the screen and an orange cross at the tracker's estimate.

    Keys: w and s move ahead and back; a and d move left and right (a robot turns); q and e turn; r and f climb, sink.
    A second camera, whose view is outlined, pans by j and l, tilts by i and k, and zooms in and out by u and o, at a
    quarter of its limits: at all of them its narrow view is past the target within a frame or two.
    Every episode played to its end, with a key pressed on the way, is scored and written as rows of suite `follow` with
    the controller `human`; the report of the folder shows it beside the others. Needs a screen and
    pygame (pip install 'frameout[play]').

    Attributes:
        env: env id, see `frameout list`.
        preset: one of the scenario's (default: the env's).
        tracker: name of the tracker (default: the env's).
        link: how commands reach the carrier: prompt, delayed, noisy or late.
        seeds: episodes A to B - 1, or A alone.
        zoom: factor by which the picture is enlarged.
        out: folder for the rows; take that of a bench run to appear in its table (default: results/follow).
    """

    env: tyro.conf.Positional[str] = catalog.DEFAULT_ENV
    preset: Annotated[str, ONE_NAME] = ""
    tracker: Annotated[str, ONE_NAME] = ""
    link: str = "prompt"
    seeds: Seeds = range(10_000, 10_003)
    zoom: float = 1.0
    out: Annotated[Path | None, FOLDER] = None
    resumes = False

    def run(self) -> int:
        """Play; return the exit status."""
        playing.check_screen()
        catalog.check_env(self.env)
        check("zoom", 0 < self.zoom <= 8, "a number in (0, 8]", self.zoom)
        out = self.out or Path("results") / controllers_suite().name
        make_folder(out)
        scenario, usual = catalog.envs()[self.env]
        settings = FollowSettings(scenario, self.tracker or usual, preset=self.preset or None, link=self.link)
        if playing.play(settings, self.seeds, out, self.zoom, self.modules) == 0:
            print("no episode was played to its end with a key pressed")
            return 0
        print_leaderboard(write_summary(out))
        print(f"rows: {out / 'records.jsonl'}\nreport: {write_report(out, progress=progress_bar)}")
        return 0
