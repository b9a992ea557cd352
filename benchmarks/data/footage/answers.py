"""Files of what a tracker answered on footage: MOT text, CSV or Parquet, by the ending.

MOT text is that of ``mot_text.rows_at``.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from benchmarks.data.mot_text import FIRST, first_box, rows_at
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

    def __init__(self, file: Path) -> None:
        """Check the file.

        Raises:
            ValueError: for a file of another ending, or one that cannot be written.
        """
        check("estimates", file.suffix in ENDINGS, f"a file that ends in {', '.join(ENDINGS)}", repr(str(file)))
        if file.suffix == ".parquet":
            check_packages(["pyarrow"], "data")
        check_file(file, "estimates")
        self._file = file
        self._rows: list[tuple[Any, ...]] = []
        self._lines: list[str] = []
        self._first_box: NDArray[np.float64] | None = None

    def keep(self, frame: int, time_s: float, answer: Answer) -> None:
        """Keep an answer; of a tracker of one target the identity is 0, and NaN is kept where it does not know."""
        if self._file.suffix == ".txt":
            # Rows alone: answers may hold masks and particles, and footage goes on for hours.
            self._first_box = first_box([answer]) if self._first_box is None else self._first_box
            self._lines += rows_at(frame + FIRST, answer, self._first_box)
            return
        tracks = (Track(0, answer),) if isinstance(answer, Estimate) else answer
        for each in tracks:
            it = each.estimate
            box = (np.nan,) * 4 if it.box_xyxy is None else it.box_xyxy
            sure = it.in_view_probability, each.confidence
            self._rows.append((frame, time_s, each.identity, *it.position_px, *box, *sure, each.kind))

    def write(self) -> None:
        """Write the file, whole or not at all."""
        if self._file.suffix == ".txt":
            write_atomic(self._file, "".join(f"{row}\n" for row in self._lines))
            return
        table = pd.DataFrame(self._rows, columns=list(_COLUMNS)).astype(_COLUMNS)
        if self._file.suffix == ".csv":
            write_atomic(self._file, table.to_csv(index=False, float_format="%.3f", lineterminator="\n"))
        else:
            buffer = io.BytesIO()
            table.to_parquet(buffer, index=False)
            write_atomic(self._file, buffer.getvalue())
