"""Metrics of a tracker's CPU time, the same in every suite; see ``benchmarks.run.guards`` for the rows."""

from __future__ import annotations

from benchmarks.suites.registry import Metric

CPU_TIME = (
    Metric("ms_per_frame", "CPU time of the tracker per frame on one core", "ms", "lower", statistic="median"),
    Metric("frames_per_s", "frames a second of the tracker on one core", "1/s", "higher", statistic="median"),
)
