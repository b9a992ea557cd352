"""A fault of a user's own code in a worker is told in one line; one of the program keeps its traceback."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from joblib.externals.loky import get_reusable_executor

from benchmarks.cli.main import main, workers_fault
from benchmarks.cli.report import Report
from benchmarks.run.workers import in_processes

OWN = """
def divide(number):
    return 1 / number
"""


def fault_of(function: Callable[[Any], object], given: object, kind: type[Exception]) -> Exception:
    with pytest.raises(kind) as found:
        list(in_processes(function, [given], 1))
    return found.value


@pytest.fixture(autouse=True)
def _workers_of_this_test() -> Iterator[None]:
    """Workers know the path of modules that was set when they began."""
    get_reusable_executor().shutdown(wait=True)
    yield
    get_reusable_executor().shutdown(wait=True)


def test_the_users_line_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "dividing.py").write_text(OWN)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    from dividing import divide  # type: ignore[import-not-found]

    fault = fault_of(divide, 0, ZeroDivisionError)
    told = "dividing.py, line 3: ZeroDivisionError: division by zero"
    assert workers_fault(fault) == told

    def fails(command: Report) -> int:
        raise fault

    monkeypatch.setattr(Report, "run", fails)
    assert main(["report", "folder", "--modules", "dividing"]) == 1
    assert capsys.readouterr().err == f"error: {told}\n"
    # Whoever has no module of his own has met a fault of the program.
    with pytest.raises(ZeroDivisionError):
        main(["report", "folder"])


def test_without_a_users_line_nothing_is_told() -> None:
    assert workers_fault(fault_of(Path.read_text, Path("nowhere.txt"), FileNotFoundError)) is None


def test_an_error_of_this_process_is_not_told() -> None:
    assert workers_fault(ValueError("here")) is None
