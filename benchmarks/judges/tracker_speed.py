"""Metrics of a tracker's speed, the same in every suite; see ``benchmarks.run.guards.times`` for the rows."""

from __future__ import annotations

from benchmarks.contract.suite import Metric

SPEED = (
    Metric(
        "ms_per_frame",
        "time of the tracker per frame: its CPU time or its wall time, whichever is larger",
        "ms",
        "lower",
        statistic="median",
    ),
    Metric(
        "frames_per_s",
        "frames a second of the tracker, at the larger of CPU time and wall time",
        "1/s",
        "higher",
        statistic="median",
    ),
    Metric(
        "cpu_ms_per_frame",
        "CPU time of the tracker per frame, of all its threads and processes",
        "ms",
        "lower",
        statistic="median",
    ),
    Metric(
        "wall_ms_per_frame",
        "wall time of the tracker per frame, with what it waits for; a loaded machine makes it larger, on Linux less, "
        "where its waiting for a core is left out: where it is far above the CPU time, measure on an idle one",
        "ms",
        "lower",
        statistic="median",
    ),
)
TIMES = tuple(metric.name for metric in SPEED)
"""Rows that differ from run to run."""
