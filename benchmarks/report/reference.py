"""The page of definitions: every metric, observation feature, reward term and key of ``info``, made from the code."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.report.tables import column_of
from benchmarks.report.templates import page_environment
from benchmarks.results.ledger import published_runs
from benchmarks.run.guards import GuardedContestant
from benchmarks.scores.pooling import pooled
from benchmarks.scores.statistics import Comparison, bootstrap_interval
from benchmarks.suites.registry import Metric, Suite, suites
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.reward import Reward
from scenarios.envs.settings import FollowSettings
from scenarios.envs.truth_info import INFO
from scenarios.truth import Truth
from trackers.belief import features as belief_features
from trackers.papers import PAPERS

_ROOT = Path(__file__).resolve().parents[2]
_TIMES = {GuardedContestant.scores: ("ms_per_frame", "frames_per_s")}
"""Rows that every suite has."""


def reference_page() -> str:
    """Return the page as Markdown."""
    environment = page_environment("report", autoescape=False)
    environment.filters |= {"cell": _cell, "words": _words, "place": _place, "goal": lambda m: column_of(m).goal}
    return environment.get_template("reference.md.jinja").render(
        suites=suites().values(),
        metrics_of=metrics_of,
        definitions_of=definitions_of,
        statistics=(pooled, bootstrap_interval, Comparison),
        features=belief_features,
        reward=Reward,
        weights=asdict(Reward()),
        info=INFO,
        truth=Truth,
        env=(FollowEnv, FollowSettings),
        papers=PAPERS.values(),
        runs=published_runs(),
    )


def metrics_of(suite: Suite) -> list[Metric]:
    """Return the metrics of a suite's summary, then those of only its events and facts."""
    found: dict[str, Metric] = {}
    for metric in (*suite.metrics, *suite.events.compared, *(suite.facts.columns if suite.facts else ())):
        found.setdefault(metric.name, metric)
    return list(found.values())


def definitions_of(suite: Suite) -> Mapping[Any, tuple[str, ...]]:
    """Return the definitions of a suite's rows: function, class or module -> names of rows."""
    return {**suite.definitions, **_TIMES}


def _cell(text: str) -> str:
    """Return text escaped for the cell of a table."""
    return text.replace("|", "\\|")


def _words(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").replace("``", "`")


def _place(thing: Any) -> str:
    """Return the place of a definition, as ``benchmarks/suites/stereo/metrics/people.py: on_other``."""
    code = getattr(thing, "fget", thing)
    file = Path(inspect.getfile(code)).resolve()
    path = file.relative_to(_ROOT).as_posix() if file.is_relative_to(_ROOT) else file.name
    return path if inspect.ismodule(code) else f"{path}: {code.__qualname__}"
