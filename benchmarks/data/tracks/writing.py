"""Writes tracks as the files of tracking programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks.text_files import write_idtracker, write_idtracker_ai
from benchmarks.data.tracks.trex_files import write_trex, write_trex_csv
from sim.checks import check

_WRITERS: Mapping[str, Callable[[TrackTable, Path], list[Path]]] = {
    "trex": write_trex,
    "trex-csv": write_trex_csv,
    "idtracker.ai": write_idtracker_ai,
    "idtracker": write_idtracker,
}


def write_tracks(table: TrackTable, folder: Path, program: str) -> list[Path]:
    """Write tracks into a folder, as files of ``trex``, ``trex-csv``, ``idtracker.ai`` or ``idtracker``; return them.

    Places are written as they are, in the table's unit. Raises ValueError for another program.
    """
    check("program", program in _WRITERS, f"one of {', '.join(_WRITERS)}", repr(program))
    folder.mkdir(parents=True, exist_ok=True)
    return _WRITERS[program](table, folder)
