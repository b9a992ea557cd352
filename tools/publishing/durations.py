"""How long published tables will take on this machine."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.contract.rows import FILE_NAME, read_blocks
from benchmarks.run.experiment import Progress
from tools.publishing.table_files import read_rows_of, seconds_by_contestant
from tools.publishing.table_runs import TableRun
from trackers.atomic_file import write_atomic

_MEASURED = "seconds-of-a-seed.json"
_ROWS = "its rows so far"
_ENOUGH_SEEDS = 3
"""With as many begun, the first one has rows of all contestants."""


@dataclass(frozen=True)
class Duration:
    """The time that a table takes.

    Attributes:
        seed_s: one seed with all contestants on one core; NaN if it cannot be foretold.
        missing: number of seeds that are not made yet, parts of them counted.
        source: where ``seed_s`` comes from.
    """

    seed_s: float
    missing: float
    source: str

    def hours(self, workers: int) -> float:
        """Return the hours left on so many cores."""
        return self.seed_s * self.missing / max(workers, 1) / 3600.0


def duration_of(run: TableRun, out: Path, folder: Path, progress: Progress) -> Duration:
    """Return how long a table takes: by its rows so far (a new folder's: the committed ones), else as measured before,
    else by a few frames.

    Args:
        out: folder of all tables, which keeps what was measured. folder: of this table.
        progress: of the measurement.
    """
    if folder.is_dir():
        found = read_blocks(folder) if (folder / FILE_NAME).is_file() else {}
    else:
        found = read_rows_of(run.table.name)
    blocks = {key: rows for key, rows in found.items() if run.is_current(key, rows)}
    missing = len(run.table.seeds) - len(blocks) / run.blocks_of_seed
    if missing <= 0:
        return Duration(0.0, 0.0, _ROWS)
    seconds = seconds_by_contestant(blocks)
    if seconds and len({key.seed for key in blocks}) >= _ENOUGH_SEEDS:
        blocks_of_seed = run.blocks_of_seed + run.varied_blocks / len(run.table.seeds)
        return Duration(float(np.mean(list(seconds.values()))) * blocks_of_seed, missing, _ROWS)
    return Duration(_measured(run, out, progress), missing, "a few frames")


def _measured(run: TableRun, out: Path, progress: Progress) -> float:
    file = out / _MEASURED
    known: dict[str, float] = json.loads(file.read_text()) if file.is_file() else {}
    if run.command not in known:
        known[run.command] = round(run.seconds_of_seed(progress), 3)
        write_atomic(file, json.dumps(known, indent=1) + "\n")
    return known[run.command]
