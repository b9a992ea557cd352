"""Runs trackers through scenarios: suites, judges, metrics and rows.

Importing this imports no suite: a public name is loaded on first access.
"""

import importlib
from typing import Any

_HOMES = {
    "bench": "benchmarks.run.bench",
    "ContestantWarning": "benchmarks.run.outcome",
    "DataSet": "benchmarks.data_sets.data_set",
    "Results": "benchmarks.report.results",
    "Metric": "benchmarks.suites.metric",
    "RowMeaning": "benchmarks.suites.metric",
    "Scene": "benchmarks.suites.registry",
    "Suite": "benchmarks.suites.registry",
    "add_metric": "benchmarks.suites.registry",
    "add_scene": "benchmarks.suites.registry",
    "register_suite": "benchmarks.suites.registry",
    "suite": "benchmarks.suites.registry",
    "Ending": "benchmarks.suites.judging",
    "Judge": "benchmarks.suites.judging",
    "Score": "benchmarks.suites.judging",
    "ScoreSheet": "benchmarks.suites.judging",
    "read_rows": "benchmarks.run.records",
    "TrackTable": "benchmarks.track_files.table",
    "read_tracks": "benchmarks.track_files.reading",
    "write_tracks": "benchmarks.track_files.writing",
}
"""Public name -> module that defines it."""
__all__ = tuple(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if name == "DataSet":
        _needs_data()
    home = importlib.import_module(_HOMES[name])
    return getattr(home, name, home)


def _needs_data() -> None:
    try:
        importlib.import_module("benchmarks.run.packages").needs_data()
    except ValueError as error:
        raise ImportError(str(error)) from None


def __dir__() -> list[str]:
    return [*globals(), *__all__]
