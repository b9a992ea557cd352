"""Rows of a paper's experiment, typed in."""

from __future__ import annotations

from typing import Any

from benchmarks.contract.rows import Row
from benchmarks.papers.experiment import PaperExperiment
from trackers import registry


def row(experiment: PaperExperiment, tracker: str, metric: str, value: Any, seed: int = 0, **more: Any) -> Row:
    """Return a row of an experiment."""
    heading = {name: getattr(experiment, name) for name in ("suite", "scenario", "preset", "controller")}
    heading |= {"tracker": tracker, "role": registry.entry(tracker).role, "renderer": "raster", "seed": seed}
    return {**heading, "repeat": 0, "metric": metric, "value": value, "weight": 1.0, "frame_out": None, **more}
