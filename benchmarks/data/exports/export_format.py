"""What an export format declares of itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.data.exports.objects import Labels
from benchmarks.data.sets.data_set import DataSet


@dataclass(frozen=True)
class ExportFormat:
    """A file layout that programs of others read.

    Attributes:
        summary: what it is, in one line.
        needs: what a data set must hold, in one line.
        channels: that must be stored. packages: that writing needs, by their import names. extra: that installs them.
        note: for users of the files: source of the format, axes, units, what this export decides.
        write: writes a data set with labels into an empty folder. Raises ValueError for one that lacks what the format
            needs.
        data_files: pattern of the files of a ``{split}``, if the Hugging Face library ``datasets`` reads them; else ''.
        has_classes: whether it labels objects with classes, those too that only stand about.
        leaves_out: whether labels of what shows too little can be left out, see ``Labels``.
    """

    summary: str
    needs: str
    channels: tuple[str, ...]
    packages: tuple[str, ...]
    note: str
    write: Callable[[DataSet, Path, Labels], None]
    extra: str = "data"
    data_files: str = ""
    has_classes: bool = False
    leaves_out: bool = False
