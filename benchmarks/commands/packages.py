"""The packages of data sets, which commands name if they are missing."""

from __future__ import annotations

from benchmarks.run.packages import check_packages

_DATA = ("blosc2", "fsspec", "pyarrow")


def needs_data() -> None:
    """Raise ValueError unless the packages of data sets are installed."""
    check_packages(_DATA, "data")
