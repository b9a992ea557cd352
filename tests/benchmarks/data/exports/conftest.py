"""One data set and one export a format for all tests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from benchmarks.data.exports.exporter import export
from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.exports.painted_scene import painted_data_set


@pytest.fixture(scope="package")
def data(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    """Two episodes, seeds 3 and 4."""
    return painted_data_set(tmp_path_factory.mktemp("painted") / "set")


@pytest.fixture(scope="package")
def exported(data: DataSet, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Return the folder of an export by its name, made once."""

    @cache
    def folder(name: str) -> Path:
        out = tmp_path_factory.mktemp(name) / "out"
        export(data, name, out)
        return out

    return folder
