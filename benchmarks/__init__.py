"""Runs trackers through scenarios: suites, judges, metrics and rows.

Importing this imports no suite: a public name is loaded on first access.
"""

import importlib
from typing import Any

_HOMES = {
    "bench": "benchmarks.cli.bench_function",
    "score": "benchmarks.cli.score_function",
    "generate": "benchmarks.cli.data_functions",
    "verify": "benchmarks.cli.data_functions",
    "split": "benchmarks.cli.data_functions",
    "merge": "benchmarks.cli.data_functions",
    "export": "benchmarks.cli.data_functions",
    "data_sets": "benchmarks.data.sets.data_set",
    "TrackerWarning": "benchmarks.run.outcome",
    "DataSet": "benchmarks.data.sets.data_set",
    "Results": "benchmarks.show.results",
    "Showing": "benchmarks.show.showing",
    "register_showing": "benchmarks.show.showing",
    "Metric": "benchmarks.contract.metric",
    "Quantity": "benchmarks.contract.metric",
    "Mean": "benchmarks.contract.metric",
    "Statistic": "benchmarks.contract.metric",
    "Scene": "benchmarks.contract.suite",
    "Suite": "benchmarks.contract.suite",
    "add_metric": "benchmarks.contract.suite",
    "add_scene": "benchmarks.contract.suite",
    "register_suite": "benchmarks.contract.suite",
    "suite": "benchmarks.contract.suite",
    "Ending": "benchmarks.contract.judging",
    "Judge": "benchmarks.contract.judging",
    "Score": "benchmarks.contract.judging",
    "ScoreSheet": "benchmarks.contract.judging",
    "read_rows": "benchmarks.contract.rows",
    "TrackTable": "benchmarks.contract.track_table",
    "read_tracks": "benchmarks.data.tracks",
}
"""Public name -> module that defines it."""
__all__ = tuple(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if _HOMES[name].endswith(("data_functions", "data_set")):
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
