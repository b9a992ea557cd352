"""Options of the test suite."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from benchmarks.run.arithmetic import missing_settings

# Before NumPy is imported, as `benchmarks.cli.main` does it: workers of the suite would wait for each other's threads.
os.environ.update(missing_settings(os.environ))
# Tables have the width that they have without a terminal, whatever started the suite.
os.environ.pop("COLUMNS", None)

import sim
from benchmarks.run.stale_kernels import forget_stale_kernels
from sim.render.compilation import forget_stale_kernels as forget_stale_kernels_of


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that makes golden pictures anew."""
    parser.addoption("--new-golden", action="store_true", help="make the pictures in tests/golden anew")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the canaries first, which compile most kernels, while another process tests what has few."""
    items.sort(key=lambda item: "canaries" not in item.path.parts)


def pytest_configure(config: pytest.Config) -> None:
    """Tests run the kernels as they are written now, and xdist keeps the order of files, which else goes by size."""
    # How long an example takes depends on what else runs here.
    settings.register_profile("untimed", deadline=None)
    settings.load_profile("untimed")
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False
    forget_stale_kernels()
    forget_stale_kernels_of(Path(sim.__file__).parent)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A Chromium without a window; tests that ask for it are skipped where there is none."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    with playwright.sync_playwright() as started:
        own = started.chromium.executable_path
        found = own if Path(own).exists() else next(filter(None, map(shutil.which, names)), None)
        if found is None:
            pytest.skip("no Chromium is installed")
        browser = started.chromium.launch(executable_path=found)
        yield browser
        browser.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Any:
    """Skip a test whose fixtures ask for PyBullet where there is none; see ``sim.bullet``."""
    try:
        return (yield)
    except ImportError as error:
        _skip_without_pybullet(error)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Any:
    """Skip a test that asks for PyBullet where there is none."""
    try:
        return (yield)
    except ImportError as error:
        _skip_without_pybullet(error)


def _skip_without_pybullet(error: ImportError) -> None:
    if error.name != "pybullet":
        raise error
    pytest.skip(str(error))
