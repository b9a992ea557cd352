"""Writes tracks as the files of tracking programs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.contract.track_table import TrackTable


def write_tracks(table: TrackTable, folder: Path, program: str) -> list[Path]:
    """Write tracks into a folder, as files of ``trex``, ``trex-csv``, ``idtracker.ai`` or ``idtracker``; return them.

    Places are written as they are, in the table's unit; frames before the first one are empty rows, but those of TRex,
    which are from the first to the last tracked one of each animal. Without a frame rate there is no time.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if program.startswith("trex"):
        return [_write_animal(table, folder, k, program) for k in range(len(table.names))]
    count = table.first_frame + len(table.position)
    whole = np.full((count, *table.position.shape[1:]), np.nan)
    whole[table.first_frame :] = table.position
    x, y = ("x", "y") if program == "idtracker.ai" else ("X", "Y")
    columns = {f"{axis}{k + 1}": whole[:, k, at] for k in range(len(table.names)) for at, axis in enumerate((x, y))}
    if program == "idtracker":
        columns |= {f"ProbId{k + 1}": np.full(count, np.nan) for k in range(len(table.names))}
        return [_write(folder / f"{table.name}.txt", columns, "\t")]
    time = {} if table.rate_hz is None else {"time": np.arange(count) / table.rate_hz}
    attributes = folder / "attributes.json"
    attributes.write_text(json.dumps({"frames_per_second": table.rate_hz, "identities_labels": list(table.names)}))
    return [_write(folder / "trajectories.csv", time | columns, ","), attributes]


def _write_animal(table: TrackTable, folder: Path, number: int, program: str) -> Path:
    tracked = np.flatnonzero(np.isfinite(table.position[:, number, 0]))
    position = table.position[tracked[0] : tracked[-1] + 1, number]
    frame = np.arange(tracked[0], tracked[-1] + 1.0) + table.first_frame
    missing = ~np.isfinite(position[:, 0])
    x, y = np.where(missing[:, None], np.inf, position).T
    arrays = {"frame": frame, "missing": missing.astype(float)}
    arrays |= {} if table.rate_hz is None else {"time": frame / table.rate_hz}
    path = folder / f"{table.name}_id{number}.{'npz' if program == 'trex' else 'csv'}"
    if program == "trex":
        np.savez(path, **arrays, **{"X#wcentroid": x, "Y#wcentroid": y})  # type: ignore[arg-type]
        return path
    return _write(path, arrays | {f"X#wcentroid ({table.unit})": x, f"Y#wcentroid ({table.unit})": y}, ",")


def _write(path: Path, columns: dict[str, np.ndarray], separator: str) -> Path:
    pd.DataFrame(columns).to_csv(path, sep=separator, index=False, na_rep="nan", float_format="%.8g")
    return path
