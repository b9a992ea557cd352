"""Options of the test suite."""

from __future__ import annotations

from pathlib import Path

import pytest

import sim
import trackers
from sim.render.compilation import forget_stale_kernels


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that makes golden pictures anew."""
    parser.addoption("--new-golden", action="store_true", help="make the pictures in tests/golden anew")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the file that takes longest: were it the last, one worker would wait for the other."""
    items.sort(key=lambda item: item.path.name != "test_contributing.py")


def pytest_configure() -> None:
    """Tests run the kernels as they are written now."""
    for package in (sim, trackers):
        forget_stale_kernels(Path(package.__file__).parent)
