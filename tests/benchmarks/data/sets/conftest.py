"""Data sets that several tests read."""

from __future__ import annotations

import pytest

from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.sets.hand_made import write_set
from tests.benchmarks.data.sets.small import made, tiny


@pytest.fixture(scope="session")
def hand_made(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    """The set of ``hand_made``."""
    return write_set(tmp_path_factory.mktemp("set"))


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    """Return a whole data set of ``small``, which no test changes."""
    return made(tiny(), tmp_path_factory.mktemp("data") / "set")
