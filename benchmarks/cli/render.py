"""``frameout render``: write an episode as a video."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from benchmarks.cli.arguments import COUNT, FILE, FOLDER, ONE_NAME, RATE, Processes, Settings, WithModules
from benchmarks.cli.bench_function import refuse
from benchmarks.contract.judging import check_no_layout
from benchmarks.contract.suite import DEFAULT, suite
from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.data.sequence_names import set_name
from benchmarks.run.jobs import Job
from benchmarks.run.process_trackers import process_trackers
from benchmarks.run.selection import job_on, tracker_named
from benchmarks.show.progress import progress_bar
from benchmarks.show.showing import suite_shown, suite_watching
from benchmarks.show.video.episode_video import render_episode
from scenarios import catalog
from scenarios.field_values import with_values
from sim.checks import check, check_choice


@dataclass(frozen=True)
class Render(WithModules):
    """Write one episode as an MP4: the camera's picture, the truth, and a tracker's estimate.

    A road town is shown in a larger view; a followed person beside a view from above. Of a
    tracker of many targets all tracks are drawn, with their identities; with a controller only the one that it steers
    by. With --controller the video is of what the suite follow scores: the controller is tuned, and its commands go
    through the link. In a preset in closed loop (see `frameout list`) it is of what `bench` scores trackers on: the
    controller is as written and has no link, unless you name a link.

    With --real it is of a real sequence, as `bench --real` scores it: the picture amid what the camera saw before, the
    true boxes, and the estimate with its path.

    Attributes:
        scenario: catalogue id, see `frameout list`; without a version the latest.
        preset: one of the scenario's (default: standard, or its first).
        settings: another value of one of its fields, FIELD=VALUE, see `generate`.
        seed: of the episode, a whole number >= 0.
        tracker: name of the tracker to draw, see `frameout list`, or of one of --process (default: the first of these,
            else truth only).
        process: a tracker in a process of its own, NAME=COMMAND, or a TOML file with a table for each of several.
        controller: name of the controller that steers by the tracker's estimate (default: a set path).
        link: how the controller's commands reach the carrier: prompt, delayed, noisy or late (default: prompt; on a
            preset in closed loop none).
        renderer: raster or pybullet.
        frames: number of frames (default: the whole episode).
        scale: size of the larger view over that of the camera's picture, 1 to 8.
        real: folder of real sequences or of one, as of `bench --real`; in place of scenario, preset and seed.
        sequence: name of the real sequence; needed if there are several.
        layout, target, rate_hz: how it is read, see `bench`.
        out: the file (default: results/SCENARIO-PRESET-SEED.mp4, or SEQUENCE.mp4).
    """

    scenario: Annotated[str, tyro.conf.Positional] = catalog.DEFAULT
    preset: Annotated[str | None, ONE_NAME] = None
    settings: Settings = ()
    seed: int = 0
    tracker: Annotated[str | None, ONE_NAME] = None
    process: Processes = ()
    controller: Annotated[str | None, ONE_NAME] = None
    link: Annotated[str | None, ONE_NAME] = None
    renderer: str = "raster"
    frames: Annotated[int | None, COUNT] = None
    scale: float = 2.0
    real: Annotated[Path | None, FOLDER] = None
    sequence: Annotated[str, ONE_NAME] = ""
    layout: Annotated[str, ONE_NAME] = ""
    target: Annotated[str | None, ONE_NAME] = None
    rate_hz: Annotated[float | None, RATE] = None
    out: Annotated[Path | None, FILE] = None
    resumes = False

    def run(self) -> int:
        """Write it; return the exit status."""
        job, name = self._simulated_job() if self.real is None else self._real_job(self.real)
        out = self.out or Path("results") / f"{name}.mp4"
        with progress_bar(f"{name}, frames") as progress:
            failures = render_episode(job, out, frames=self.frames, scale=self.scale, progress=progress)
        print(out)
        for failure in failures:
            print(f"error: {failure}", file=sys.stderr)
        return 1 if failures else 0

    @property
    def _trackers(self) -> dict[str, TrackerSpec]:
        added = process_trackers(self.process, Job.limit_s)
        name = self.tracker or next(iter(added), None)
        return {} if name is None else {name: added.get(name) or tracker_named(name)}

    def _real_job(self, real: Path) -> tuple[Job, str]:
        from benchmarks.data.real import real_episodes  # It imports the readers of all layouts.

        refuse("none for a real sequence, whose camera nobody steers", controller=self.controller, link=self.link)
        others = {name: getattr(self, name) for name in ("scenario", "preset", "settings", "seed", "renderer")}
        named = {name: value for name, value in others.items() if value != getattr(Render, name)}
        refuse("none for a real sequence, which is no episode", **named)
        judging = suite(DEFAULT)
        episodes, unusable = real_episodes(judging, [real], self.layout, self.target, self.rate_hz)
        for line in unusable:
            print(f"note: {line}", file=sys.stderr)
        names = [each.sequence for each in episodes]
        if self.sequence or len(names) > 1:
            check_choice("sequence", self.sequence, names)
        episode = episodes[names.index(self.sequence) if self.sequence else 0]
        trackers = self._trackers
        return Job(judging, episode, trackers, self.modules, repeats=1), "-".join([episode.sequence, *trackers])

    def _simulated_job(self) -> tuple[Job, str]:
        check_no_layout(self.layout, self.target, self.rate_hz)
        check("sequence", not self.sequence, "none without --real", repr(self.sequence))
        scenario = catalog.scenario(self.scenario)
        check("seed", self.seed >= 0, "a whole number >= 0", self.seed)
        usual = "standard" if "standard" in scenario.presets else next(iter(scenario.presets))
        preset = with_values(self.preset or usual, self.settings)
        steered = self.link is None or self.controller is not None
        check("controller", steered, f"a name, whose commands take the link {self.link!r}", "none")
        trackers = self._trackers
        if self.controller is None:
            shown, link = suite_watching(scenario.id, *trackers), None
        else:
            shown = suite_shown(scenario.id, preset, self.link)
            link = (self.link or "prompt") if shown.judges_controllers else None
        how: Any = {"controller": self.controller, "link": link, "renderer": self.renderer}
        job = job_on(shown, scenario.id, preset, self.seed, trackers, repeats=1, **how)
        return job, f"{set_name(scenario.id, preset)}-{self.seed}"
