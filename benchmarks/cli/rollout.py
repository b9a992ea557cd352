"""``frameout rollout``: make a data set of what a controller does in an env."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from benchmarks.cli.arguments import COUNT, FOLDER, JSON, ONE_NAME, WORKERS, UsualSeeds, WithModules, keywords_of
from benchmarks.cli.printing import trackers_print_to_stderr
from benchmarks.contract.text import counted
from benchmarks.run.workers import cores
from benchmarks.show.progress import progress_bar
from scenarios import catalog
from sim.checks import check

_EPISODES = 10


@dataclass(frozen=True)
class Rollout(WithModules):
    """Make a data set of observations, actions and rewards, for imitation and offline learning: a controller steers in
    an env with pictures.

    The same command continues after a stop; what is made lies in OUT.unfinished until the set is whole. The bytes do
    not depend on the number of workers. Stored actions give the stored rewards when they are played again.
    Needs `pip install 'frameout[data]'`; README.md of the set says how it is read.

    Attributes:
        env: env id, see `frameout list`.
        out: the folder to make, new or empty.
        format: lerobot (v3.0: Parquet and MP4), minari (HDF5), or parquet (a file for each episode, as pandas and
            datasets read it).
        controller: who steers: a name, see `frameout list`, or policy:FILE (default: ours for the carrier). An oracle
            such as omniscient is a teacher that knows more than the observation says.
        episodes: number of episodes, of seeds 0 and following (default: 10).
        seeds: episodes A to B - 1, or A alone, in place of --episodes.
        pictures: how pictures are stored: lerobot: h264 or none; minari: none or raw; parquet: jpeg (quality 95), png
            or none (default: the first of these).
        tracker: name of the tracker (default: the env's).
        preset: one of the scenario's (default: the env's).
        env_kwargs: further keywords of the env as JSON, see `frameout list --envs`, e.g. '{"link": "delayed"}'.
        workers: processes; 0 = run in this process.
        dry_run: play the first episode, say how large the set will be and how long it takes; make nothing.
    """

    env: Annotated[str, tyro.conf.Positional]
    out: Annotated[Path, FOLDER]
    format: Literal["lerobot", "minari", "parquet"] = "parquet"
    controller: Annotated[str, ONE_NAME] = ""
    episodes: Annotated[int | None, COUNT] = None
    seeds: UsualSeeds = None
    pictures: Annotated[Literal["", "h264", "jpeg", "none", "png", "raw"], ONE_NAME] = ""
    tracker: Annotated[str, ONE_NAME] = ""
    preset: Annotated[str, ONE_NAME] = ""
    env_kwargs: Annotated[str, JSON] = "{}"
    workers: Annotated[int | None, WORKERS] = None
    dry_run: bool = False
    resumes = True

    def run(self) -> int:
        """Make it; return the exit status."""
        catalog.check_env(self.env)
        check("episodes", self.episodes is None or self.episodes >= 1, "a whole number >= 1", self.episodes)
        check("episodes", self.episodes is None or self.seeds is None, "none beside --seeds", self.episodes)
        workers, seeds = cores(self.workers), self.seeds or range(self.episodes or _EPISODES)
        from benchmarks.learning.rollouts.request import Rollouts

        rollouts = Rollouts(
            self.env,
            (seeds.start, seeds.stop),
            self.format,
            self.controller,
            self.pictures,
            self.tracker,
            self.preset,
            keywords_of(self.env_kwargs),
            self.modules,
        )
        # After the check of packages, which it imports.
        from benchmarks.learning.rollouts.making import bytes_of, forecast, make

        if self.dry_run:
            with trackers_print_to_stderr():
                size, seconds = forecast(rollouts)
            minutes = seconds / max(min(workers, len(seeds)), 1) / 60
            print(f"{counted(len(seeds), 'episode')}, {size / 2**20:.1f} MiB, about {minutes:.1f} minutes")
            return 0
        began = time.perf_counter()
        with progress_bar(f"{rollouts.env} {rollouts.controller}") as progress, trackers_print_to_stderr():
            made = make(rollouts, self.out, workers, progress)
        room = f"{bytes_of(self.out) / 2**20:.1f} MiB, {time.perf_counter() - began:.0f} s"
        print(f"{self.out}: {counted(made.episodes, 'episode')}, {counted(made.steps, 'step')}, {room}")
        print(f"mean return {made.mean_return:.1f}, target in view {made.time_in_view:.1%} of the time")
        print(f"how to read it: {self.out / 'README.md'}")
        return 0
