"""``python -m tools speed``: time rendering and the envs."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from rich import box
from rich.table import Table

from benchmarks.cli.arguments import COUNT, NAMES, SEEDS, check_unset, names, seed_range
from benchmarks.cli.with_modules import WithModules
from benchmarks.contract.text import counted
from benchmarks.learning.training import EPISODES
from benchmarks.run.packages import needs_data
from benchmarks.run.result_folder import make_folder
from benchmarks.show.progress import console_of, progress_bar
from benchmarks.show.tables import NO_NUMBER
from benchmarks.statistics.summary import SUMMARY_FILE_NAME
from scenarios import catalog
from scenarios.envs.pictureless.bank import is_playable
from scenarios.scenario import Scenario
from sim.checks import check, check_choice
from tools.speed.env_stepping import ENV_ID, SCENARIO, measure_env
from tools.speed.pictureless import measure_pictureless
from tools.speed.rendering import FRAMES_PER_BARE_CALL, measure_scenario
from tools.speed.resets import measure_resets
from tools.speed.soak import LARGEST_GROWTH, SoakSample, growth, soak
from trackers.atomic_file import write_atomic

_QUICK_SEEDS, _QUICK_FRAMES = "0:1", 16
_SOAKED_ENVS = 4
_FEWEST_SOAKED_STEPS = 1000

Entry = dict[str, Any]


@dataclass(frozen=True)
class Speed(WithModules):
    """Measure how fast frames are made: with all their truth, and the picture alone, against a bare call of PyBullet's
    TinyRenderer on the same scene, with shadows and without.

    Measured on one core, in CPU time of the thread; then frames a second, and the rate of two processes over that of
    one. If its scenario is chosen, the same for steps of frameout/RoadTownFollow-v2 with a tracker and pictures of 84 ×
    84: also the rate of four envs, two at a time over one at a time, beside two processes that only count, as the limit
    of the machine, and the time of a reset to another episode, and to the same one again. Then steps a second of the
    envs without pictures. Run nothing else meanwhile: other processes on the same cores change the figures.

    Attributes:
        scenarios: catalogue ids (default: the latest version of all that have the preset).
        preset: one of the scenarios'; it sets the size of the picture and the scene.
        seeds: episodes A to B - 1, or A alone.
        frames: number of timed frames in each episode.
        stored: instead make and write data sets with all channels, and print their CPU time a frame against a bare call
            with shadows, and time and size of each channel (pip install 'frameout[data]').
        resets: instead measure the throughput of the env with resets and without, as `frameout train --pictures`
            trains, and their ratio; for every seed as many episodes as there are between two new worlds, and of each
            the given number of frames.
        quick: time 16 frames of episode 0 alone: a rough figure within a minute or two.
        soak: instead make this number of steps in four envs side by side, and print the memory in use.
        out: folder for summary.json.
        json: print JSON instead of a table.
    """

    scenarios: Annotated[tuple[str, ...], tyro.conf.Positional, NAMES] = ()
    preset: str = "standard"
    seeds: Annotated[str, SEEDS] = "0:4"
    frames: int = 60
    stored: bool = False
    resets: bool = False
    quick: bool = False
    soak: Annotated[int | None, COUNT] = None
    out: Path = Path("results/speed")
    json: bool = False
    resumes = False

    def run(self) -> int:
        """Measure; return the exit status."""
        if self.soak is not None:
            others = ("scenarios", "seeds", "frames", "stored", "resets", "quick", "out", "json")
            check_unset(self, others, "with --soak, which makes steps and no table")
            return self._soak(self.soak)
        if self.quick:
            check_unset(self, ("seeds", "frames"), "with --quick, which has its own")
        enough = self.frames >= FRAMES_PER_BARE_CALL
        check("frames", enough, f"a whole number >= {FRAMES_PER_BARE_CALL}", self.frames)
        check("resets", not (self.resets and self.stored), "one of --stored, --resets", "both")
        if self.stored:
            needs_data()
        seeds = seed_range(_QUICK_SEEDS if self.quick else self.seeds)
        frames = _QUICK_FRAMES if self.quick else self.frames
        latest = dict.fromkeys(map(catalog.unversioned, catalog.names()))
        known = [catalog.scenario(name) for name in names(self.scenarios) or latest]
        chosen = [scenario for scenario in known if self.preset in scenario.presets] or known
        for scenario in chosen:
            check_choice("preset", self.preset, scenario.presets)
        make_folder(self.out)
        measured = self._stored if self.stored else self._resets if self.resets else self._rendering
        entries = [entry for scenario in chosen for entry in measured(scenario, seeds, frames)]
        write_atomic(self.out / SUMMARY_FILE_NAME, json.dumps(entries, indent=1) + "\n")
        if self.json:
            print(json.dumps(entries, indent=1))
        else:
            console_of().print(_table(entries, len(seeds)))
        return 0

    def _stored(self, scenario: Scenario, seeds: range, frames: int) -> list[Entry]:
        """Measure data sets of a scenario."""
        # After the check that they are installed, since it imports these packages.
        from tools.speed.storing import measure_storing

        return measure_storing(scenario.id, self.preset, seeds, frames)

    def _resets(self, scenario: Scenario, seeds: range, frames: int) -> list[Entry]:
        """Measure the throughput of a scenario's envs with resets."""
        env_ids = _env_ids(scenario)
        check("resets", bool(env_ids) or not self.scenarios, "scenarios with an env", scenario.id)
        entries = []
        for env_id in env_ids:
            with progress_bar(f"throughput of {env_id}") as progress:
                entries += measure_resets(env_id, self.preset, seeds, frames, progress)
        return entries

    def _rendering(self, scenario: Scenario, seeds: range, frames: int) -> list[Entry]:
        """Measure pictures of a scenario, and steps of its envs."""
        with progress_bar(f"speed of {scenario.id}") as progress:
            entries = measure_scenario(scenario.id, self.preset, seeds, frames, progress)
        if scenario.id == SCENARIO:
            with progress_bar(f"speed of {ENV_ID}") as progress:
                entries += measure_env(self.preset, seeds, frames, progress)
        if is_playable(scenario.id, scenario.presets[self.preset]):
            for env_id in _env_ids(scenario):
                entries += measure_pictureless(env_id, self.preset, seeds, EPISODES)
        return entries

    def _soak(self, steps: int) -> int:
        """Soak and print samples; return 1 if memory grew by more than is allowed."""
        check("soak", Path("/proc/self/statm").exists(), "Linux, which tells the memory in use", sys.platform)
        check("soak", steps >= _FEWEST_SOAKED_STEPS, f"a whole number >= {_FEWEST_SOAKED_STEPS}", steps)
        samples = soak(self.preset, steps, _SOAKED_ENVS, _print_sample)
        grown = growth(samples)
        print(f"mean memory in the last fifth of the steps against the second: {grown:+.1%}")
        return int(grown > LARGEST_GROWTH)


def _env_ids(scenario: Scenario) -> list[str]:
    """Return the envs of a scenario."""
    return [env_id for env_id, (followed, _) in catalog.envs().items() if followed == scenario.id]


def _table(entries: Sequence[Entry], seed_count: int) -> Table:
    """Return the figures as a table."""
    intervals = ", 95 % intervals over them" if seed_count > 1 else ""
    table = Table(title=f"speed over {counted(seed_count, 'seed')}{intervals}", box=box.SIMPLE_HEAD)
    for column in ("scenario", "preset", "metric", "unit"):
        table.add_column(column)
    for column in ("mean", "95 % interval"):
        table.add_column(column, justify="right")
    for entry in entries:
        interval = f"{entry['ci_low']:.2f} to {entry['ci_high']:.2f}" if seed_count > 1 else NO_NUMBER
        row = (entry["scenario"], entry["preset"], entry["metric"], entry["unit"])
        table.add_row(*row, f"{entry['mean']:.2f}", interval)
    return table


def _print_sample(sample: SoakSample) -> None:
    held = " ".join(f"{each:.0f}" for each in sample.rss_mib)
    done = f"{sample.steps} steps, {sample.episodes} episodes, {sample.seconds:.0f} s"
    print(f"{done}: this process and those of the envs hold {held} MiB", flush=True)
