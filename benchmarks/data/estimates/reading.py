"""Kept estimates as tables, for metrics of one's own.

``frameout bench --keep-estimates`` leaves a row for each track that a tracker said on each frame; the columns and their
units are those of ``benchmarks.data.estimates.columns.SCHEMA``. The truth of the same frames is in the tables of a
data set of the same scenario, preset and seeds, and nothing has to be run::

    from benchmarks.data.sets.data_set import DataSet
    from benchmarks.data.estimates.reading import scan

    said = scan("results/mine").to_table(columns=["tracker", "seed", "frame", "repeat", "answer", "position_px"])
    said = said.to_pandas().query("answer == 'at once'")
    true = DataSet("sets/town").table("objects").to_pandas().query("names == 'target'")
    both = said.merge(true, on=["seed", "frame"], suffixes=("", "_true"))
    away_px = np.stack(both["position_px"]) - np.stack(both["position_px_true"])
    both["error_px"] = np.hypot(away_px[:, 0], away_px[:, 1])
    print(both.groupby("tracker")["error_px"].median())
"""

from __future__ import annotations

from pathlib import Path

import pyarrow.dataset

from benchmarks.contract.rows import ESTIMATES
from benchmarks.data.estimates.block_file import Facts, facts_of, paths_in
from benchmarks.data.estimates.columns import SCHEMA


def scan(directory: Path | str) -> pyarrow.dataset.Dataset:
    """Return all estimates of a result folder as an Arrow dataset, which reads chosen columns and rows only.

    Raises:
        ValueError: if there are none, or a file is cut off.
    """
    paths = [path for path, _ in facts_in(directory)]
    return pyarrow.dataset.dataset([str(path) for path in paths], schema=SCHEMA, format="parquet")


def facts_in(directory: Path | str) -> list[tuple[Path, Facts]]:
    """Return the files of a result folder's estimates and what each says of its block, e.g. where the tracker failed.

    Raises:
        ValueError: if there are none, or a file is cut off.
    """
    return [(path, facts_of(path)) for path in paths_in(Path(directory) / ESTIMATES)]
