"""Packages of extras."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.util import find_spec

from sim.checks import check

_DATA = ("blosc2", "fsspec", "pyarrow", "yaml")


def check_packages(names: Iterable[str], extra: str) -> None:
    """Raise ValueError, with the command that installs an extra, if packages of it are missing."""
    missing = [name for name in names if find_spec(name) is None]
    check("packages", not missing, f"{', '.join(missing)} to be installed (pip install 'frameout[{extra}]')", "none")


def needs_data() -> None:
    """Raise ValueError unless the packages of data sets are installed."""
    check_packages(_DATA, "data")
