"""Files of what a tracker answered on footage: MOT text, CSV or Parquet, by the ending.

MOT text is that of MOT Challenge (https://motchallenge.net, Milan et al. 2016, arXiv 1603.00831): frame, identity,
left, top, width, height, confidence, -1, -1, -1. Frames, identities and pixels are counted from 1. It has boxes alone:
an estimate without one has a box of the size of the first one about its place.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.run.packages import check_packages
from benchmarks.run.result_folder import check_file
from sim.checks import check
from trackers.atomic_file import write_atomic
from trackers.types import Answer, Estimate, Track

ENDINGS = (".txt", ".csv", ".parquet")
_COLUMNS = {
    "frame": "int64",
    "time_s": "float64",
    "identity": "int64",
    "x_px": "float64",
    "y_px": "float64",
    "x_min_px": "float64",
    "y_min_px": "float64",
    "x_max_px": "float64",
    "y_max_px": "float64",
    "in_view_probability": "float64",
    "confidence": "float64",
    "kind": "str",
}


class Answers:
    """Keeps the answers of a tracker, one row for each estimate, and writes them."""

    def __init__(self, file: Path, box_xyxy: NDArray[np.float64] | None) -> None:
        """``box_xyxy``: (4,) the target's first box, None for a tracker of many.

        Raises:
            ValueError: for a file of another ending, or one that cannot be written.
        """
        check("estimates", file.suffix in ENDINGS, f"a file that ends in {', '.join(ENDINGS)}", repr(str(file)))
        if file.suffix == ".parquet":
            check_packages(["pyarrow"], "data")
        check_file(file, "estimates")
        self._file = file
        self._half_px = None if box_xyxy is None else 0.5 * (box_xyxy[2:] - box_xyxy[:2])
        self._rows: list[tuple[Any, ...]] = []

    def keep(self, frame: int, time_s: float, answer: Answer) -> None:
        """Keep an answer; of a tracker of one target the identity is 0, and NaN is kept where it does not know."""
        tracks = (Track(0, answer),) if isinstance(answer, Estimate) else answer
        for each in tracks:
            it = each.estimate
            box = (np.nan,) * 4 if it.box_xyxy is None else it.box_xyxy
            sure = it.in_view_probability, each.confidence
            self._rows.append((frame, time_s, each.identity, *it.position_px, *box, *sure, each.kind))

    def write(self) -> None:
        """Write the file, whole or not at all."""
        table = pd.DataFrame(self._rows, columns=list(_COLUMNS)).astype(_COLUMNS)
        if self._file.suffix == ".parquet":
            buffer = io.BytesIO()
            table.to_parquet(buffer, index=False)
            write_atomic(self._file, buffer.getvalue())
        else:
            is_mot = self._file.suffix == ".txt"
            shown = self._mot(table) if is_mot else table
            text = shown.to_csv(index=False, header=not is_mot, float_format="%.3f", lineterminator="\n")
            write_atomic(self._file, text)

    def _mot(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the columns of MOT text: a row for each estimate that has a box or a first one."""
        place = table[["x_px", "y_px"]].to_numpy()
        corners = table[["x_min_px", "y_min_px", "x_max_px", "y_max_px"]].to_numpy()
        if self._half_px is not None:
            about = np.hstack([place - self._half_px, place + self._half_px])
            corners = np.where(np.isfinite(corners), corners, about)
        known = np.isfinite(np.hstack([place, corners])).all(axis=1)
        left, top, right, bottom = corners[known].T
        sure = table["confidence"].fillna(table["in_view_probability"]).fillna(1.0)
        keys = table.loc[known, ["frame", "identity"]] + 1
        numbers = {"left": left + 1, "top": top + 1, "width": right - left, "height": bottom - top, "sure": sure[known]}
        return keys.assign(**numbers, x=-1, y=-1, z=-1)
