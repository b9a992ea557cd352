"""Options of the test suite."""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that makes golden pictures anew."""
    parser.addoption("--new-golden", action="store_true", help="make the pictures in tests/golden anew")
