"""``python -m tools speed``: time rendering and the envs."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd
import tyro

from benchmarks.cli.arguments import Names, Seeds
from benchmarks.learning.settings import EPISODES
from benchmarks.run.packages import needs_data
from benchmarks.run.result_folder import make_folder
from benchmarks.show.progress import progress_bar
from benchmarks.statistics.summary import SUMMARY_FILE_NAME
from scenarios import catalog
from scenarios.envs.pictureless.bank import is_playable
from scenarios.scenario import Scenario
from sim.checks import check, check_choice
from tools.speed.envs import SCENARIO, measure_env, measure_pictureless
from tools.speed.figures import FRAMES_PER_BARE_CALL, Figure, entries_of
from tools.speed.processes import measure_process
from tools.speed.rendering import measure_rendering
from trackers.atomic_file import write_atomic

Measure = Callable[[int], Mapping[str, Figure]]
"""Takes a seed."""


@dataclass(frozen=True)
class Speed:
    """Measure how fast frames are made: with all their truth, and the picture alone, against a bare call of PyBullet's
    TinyRenderer on the same scene, with shadows and without.

    Measured on one core, in CPU time of the thread; then frames a second, and the rate of two processes over that of
    one. If its scenario is chosen, the same for steps of frameout/RoadTownFollow-v3 with a tracker and pictures of 84 ×
    84: also the rate of four envs, two at a time over one at a time, beside two processes that only count, as the limit
    of the machine, steps a second with resets to new episodes counted, and the time of such a reset and of building a
    world. Then steps a second of the envs without pictures. Run
    nothing else meanwhile: other processes on the same cores change the figures.

    Attributes:
        scenarios: catalogue ids (default: the latest version of all that have the preset).
        preset: one of the scenarios'; it sets the size of the picture and the scene.
        seeds: episodes A to B - 1, or A alone.
        frames: number of timed frames in each episode.
        stored: instead make and write data sets with all channels, and print their CPU time a frame against a bare call
            with shadows, and time and size of each channel (pip install 'frameout[data]').
        processes: instead time a tracker that does nothing in a process of its own, against the same one in this:
            wall time a frame, and CPU time of both processes.
        out: folder for summary.json.
    """

    scenarios: tyro.conf.Positional[Names] = ()
    preset: str = "standard"
    seeds: Seeds = range(4)
    frames: int = 60
    stored: bool = False
    processes: bool = False
    out: Path = Path("results/speed")
    resumes = False

    def run(self) -> int:
        """Measure; return the exit status."""
        enough = self.frames >= FRAMES_PER_BARE_CALL
        check("frames", enough, f"a whole number >= {FRAMES_PER_BARE_CALL}", self.frames)
        if self.stored:
            needs_data()
        latest = dict.fromkeys(map(catalog.unversioned, catalog.names()))
        known = [catalog.scenario(name) for name in self.scenarios or latest]
        chosen = [scenario for scenario in known if self.preset in scenario.presets] or known
        for scenario in chosen:
            check_choice("preset", self.preset, scenario.presets)
        make_folder(self.out)
        entries = []
        for scenario in chosen:
            for subject, measure in self._measures(scenario):
                measured = []
                with progress_bar(f"speed of {scenario.id}, {subject}") as progress:
                    for done, seed in enumerate(self.seeds):
                        progress(done, len(self.seeds))
                        measured.append(measure(seed))
                entries += entries_of(scenario.id, self.preset, subject, self.seeds, measured)
        write_atomic(self.out / SUMMARY_FILE_NAME, json.dumps(entries, indent=1) + "\n")
        columns = ["scenario", "preset", "metric", "unit", "mean", "ci_low", "ci_high"]
        print(pd.DataFrame(entries)[columns].to_string(index=False, float_format="{:.2f}".format))
        return 0

    def _measures(self, scenario: Scenario) -> Iterator[tuple[str, Measure]]:
        """Yield what is measured in a scenario, and how."""
        if self.stored:
            # After the check that they are installed, since it imports these packages.
            from tools.speed.storing import measure_storing

            yield "data set", partial(measure_storing, scenario.id, self.preset, self.frames)
            return
        if self.processes:
            yield "process", partial(measure_process, scenario.id, self.preset, self.frames)
            return
        yield "raster", partial(measure_rendering, scenario.id, self.preset, self.frames)
        if scenario.id == SCENARIO:
            yield "env", partial(measure_env, self.preset, self.frames)
        if is_playable(scenario.id, scenario.presets[self.preset]):
            for env_id, (followed, _) in catalog.envs().items():
                if followed == scenario.id:
                    yield "env", partial(measure_pictureless, env_id, self.preset, EPISODES)
