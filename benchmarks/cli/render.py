"""``frameout render``: write an episode as a video."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from benchmarks.cli.arguments import COUNT, FILE, ONE_NAME, WithModules
from benchmarks.run.jobs import Job
from benchmarks.run.selection import job_on
from benchmarks.show.progress import progress_bar
from benchmarks.show.showing import suite_shown, suite_watching
from benchmarks.show.video.episode_video import render_episode
from scenarios import catalog
from sim.checks import check


@dataclass(frozen=True)
class Render(WithModules):
    """Write one episode as an MP4: the camera's picture, the truth, and a tracker's estimate.

    A road town is shown in a larger view; a followed person beside a view from above. Of a
    tracker of many targets all tracks are drawn, with their identities; with a controller only the one that it steers
    by. With --controller the video is of what the suite follow scores: the controller is tuned, and its commands go
    through the link. In a preset in closed loop (see `frameout list`) it is of what `bench` scores trackers on: the
    controller is as written and has no link, unless you name a link.

    Attributes:
        scenario: catalogue id, see `frameout list`; without a version the latest.
        preset: one of the scenario's (default: standard, or its first).
        seed: of the episode, a whole number >= 0.
        tracker: name of the tracker to draw (default: truth only).
        controller: name of the controller that steers by the tracker's estimate (default: a set path).
        link: how the controller's commands reach the carrier: prompt, delayed or noisy (default: prompt; on a preset
            in closed loop none).
        renderer: raster or pybullet.
        frames: number of frames (default: the whole episode).
        scale: size of the larger view over that of the camera's picture, 1 to 8.
        out: the file (default: results/SCENARIO-PRESET-SEED.mp4).
    """

    scenario: Annotated[str, tyro.conf.Positional] = catalog.DEFAULT
    preset: Annotated[str | None, ONE_NAME] = None
    seed: int = 0
    tracker: Annotated[str | None, ONE_NAME] = None
    controller: Annotated[str | None, ONE_NAME] = None
    link: Annotated[str | None, ONE_NAME] = None
    renderer: str = "raster"
    frames: Annotated[int | None, COUNT] = None
    scale: float = 2.0
    out: Annotated[Path | None, FILE] = None
    resumes = False

    def run(self) -> int:
        """Write it; return the exit status."""
        scenario = catalog.scenario(self.scenario)
        check("seed", self.seed >= 0, "a whole number >= 0", self.seed)
        preset = self.preset or ("standard" if "standard" in scenario.presets else next(iter(scenario.presets)))
        out = self.out or Path("results") / f"{scenario.id}-{preset}-{self.seed}.mp4"
        job = self._job(scenario.id, preset)
        with progress_bar(f"{scenario.id} {preset}, frames") as progress:
            failures = render_episode(job, out, frames=self.frames, scale=self.scale, progress=progress)
        print(out)
        for failure in failures:
            print(f"error: {failure}", file=sys.stderr)
        return 1 if failures else 0

    def _job(self, scenario: str, preset: str) -> Job:
        if self.link is not None and self.controller is None:
            raise ValueError(f"controller: expected a name, whose commands take the link {self.link!r}; got none")
        trackers = () if self.tracker is None else (self.tracker,)
        if self.controller is None:
            shown, link = suite_watching(scenario, self.tracker), None
        else:
            shown = suite_shown(scenario, preset, self.link)
            link = (self.link or "prompt") if shown.judges_controllers else None
        how: Any = {"controller": self.controller, "link": link, "renderer": self.renderer}
        return job_on(shown, scenario, preset, self.seed, trackers, repeats=1, **how)
