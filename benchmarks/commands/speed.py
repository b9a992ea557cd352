"""``frameout speed``: how fast pictures are made."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from rich.console import Console
from rich.table import Table

from benchmarks.commands.arguments import SEEDS, seed_range
from benchmarks.commands.progress import progress_bar
from benchmarks.records import write_beside
from benchmarks.speed import measure_scenario
from benchmarks.summary import SUMMARY_FILE_NAME
from scenarios import catalog


@dataclass(frozen=True)
class Speed:
    """Time finished frames with all truth against bare calls of PyBullet's TinyRenderer with shadows, on the
    same scene and size, in CPU time of one thread; and two processes against one.

    Attributes:
        preset: of every scenario.
        seeds: towns A:B.
        frames: finished frames timed in each.
        out: folder for summary.json; None writes nothing.
        json: print JSON instead of a table.
    """

    preset: str = "standard"
    seeds: Annotated[str, SEEDS] = "0:3"
    frames: int = 120
    out: Path | None = None
    json: bool = False

    def run(self) -> int:
        """Measure, print and write; return the exit status."""
        if self.frames < 8:
            raise ValueError(f"frames: expected a whole number >= 8, got {self.frames}")
        seeds = seed_range(self.seeds)
        if self.out is not None:
            self.out.mkdir(parents=True, exist_ok=True)
        entries: list[dict[str, Any]] = []
        for name in catalog.names():
            with progress_bar(f"{name} {self.preset}") as progress:
                entries += measure_scenario(name, self.preset, seeds, self.frames, progress)
        if self.out is not None:
            write_beside(self.out / SUMMARY_FILE_NAME, json.dumps(entries, indent=1) + "\n")
        if self.json:
            print(json.dumps(entries, indent=1))
        else:
            Console().print(_table(entries))
        return 0


def _table(entries: list[dict[str, Any]]) -> Table:
    table = Table(title="a finished frame by raster; TinyRenderer: a bare call with shadows")
    for column in ("scenario", "preset", "metric"):
        table.add_column(column)
    for column in ("mean", "95 % interval", "unit", "towns"):
        table.add_column(column, justify="right")
    for entry in entries:
        interval = f"{entry['ci_low']:.3g} – {entry['ci_high']:.3g}"
        numbers = (f"{entry['mean']:.3g}", interval, entry["unit"], str(entry["n"]))
        table.add_row(entry["scenario"], entry["preset"], entry["metric"], *numbers)
    return table
