"""``frameout speed``: how fast pictures are made."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from rich import box
from rich.console import Console
from rich.table import Table

from benchmarks.commands.arguments import SEEDS, names, seed_range
from benchmarks.commands.progress import progress_bar
from benchmarks.experiment import make_folder
from benchmarks.records import write_beside
from benchmarks.speed import FRAMES_PER_BARE_CALL, measure_scenario
from benchmarks.summary import SUMMARY_FILE_NAME
from scenarios import catalog


@dataclass(frozen=True)
class Speed:
    """Time a finished frame with all its truth against a bare call of PyBullet's TinyRenderer on the same scene.

    One core, shadows on, CPU time of the thread; then frames a second as such, and what two processes make against one.
    Leave the machine alone meanwhile: processes that share its cores are measured too.

    Attributes:
        scenarios: catalogue ids (default: all).
        preset: whose picture size and scene.
        seeds: towns A to B - 1.
        frames: frames timed in each town.
        out: folder for summary.json.
        json: print JSON instead of a table.
    """

    scenarios: Annotated[tuple[str, ...], tyro.conf.Positional] = ()
    preset: str = "standard"
    seeds: Annotated[str, SEEDS] = "0:4"
    frames: int = 60
    out: Path = Path("results/speed")
    json: bool = False

    def run(self) -> int:
        """Measure; return the exit status."""
        if self.frames < FRAMES_PER_BARE_CALL:
            raise ValueError(f"frames: expected a whole number >= {FRAMES_PER_BARE_CALL}, got {self.frames}")
        make_folder(self.out)
        seeds = seed_range(self.seeds)
        chosen = [catalog.scenario(name) for name in names(self.scenarios) or catalog.names()]
        entries = []
        for scenario in chosen:
            if self.preset not in scenario.presets:
                raise ValueError(f"preset: expected one of {', '.join(scenario.presets)}; got {self.preset!r}")
            with progress_bar(f"speed of {scenario.id}") as progress:
                entries += measure_scenario(scenario.id, self.preset, seeds, self.frames, progress)
        write_beside(self.out / SUMMARY_FILE_NAME, json.dumps(entries, indent=1) + "\n")
        if self.json:
            print(json.dumps(entries, indent=1))
            return 0
        table = Table(title=f"speed over {len(seeds)} towns, 95 % intervals over them", box=box.SIMPLE_HEAD)
        for column in ("scenario", "preset", "metric", "unit"):
            table.add_column(column)
        for column in ("mean", "95 % interval"):
            table.add_column(column, justify="right")
        for entry in entries:
            interval = f"{entry['ci_low']:.2f} to {entry['ci_high']:.2f}"
            row = (entry["scenario"], entry["preset"], entry["metric"], entry["unit"])
            table.add_row(*row, f"{entry['mean']:.2f}", interval)
        Console(width=None if Console().is_terminal else 118).print(table)
        return 0
