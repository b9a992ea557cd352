"""A table beside text files of labels: what their format has no place for, a row for each line."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.data.exports.labels import ATTRIBUTES, Instance, Labels

SIDECAR = "objects.csv"


class Sidecar:
    """The rows of ``objects.csv``: file, line (from 1), class, and ``Instance.attributes``."""

    def __init__(self, labels: Labels, *more: str) -> None:
        """``more``: further columns."""
        self._labels, self._columns = labels, ["file", "line", "class", *ATTRIBUTES, *more]
        self._rows: list[dict[str, Any]] = []

    def add(self, file: str, line: int, instance: Instance, more: Mapping[str, Any] | None = None) -> None:
        """Add a row; ``more``: the values of the further columns."""
        row = {"file": file, "line": line, "class": self._labels.names[instance.class_number]}
        self._rows.append(row | instance.attributes() | dict(more or {}))

    def write(self, folder: Path) -> None:
        """Write the table into a folder."""
        table = pd.DataFrame(self._rows, columns=self._columns)
        table.to_csv(folder / SIDECAR, index=False, lineterminator="\n")
