"""Output on a terminal: tables as wide as it is; progress on stderr, a bar there, lines in a log file."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from benchmarks.run.experiment import Progress as Report

_LINE_EVERY_S = 30.0
"""Least time between two lines of a log, but for the last one."""


def console_of(width: int = 118) -> Console:
    """Return a console as wide as the terminal or as ``COLUMNS`` says, or of ``width`` where neither is known."""
    console = Console()
    columns = os.environ.get("COLUMNS", "")
    return console if console.is_terminal or (columns.isdigit() and int(columns) > 0) else Console(width=width)


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """Show progress until the context ends.

    Yields a function to be called with (done, of); its first call shows the bar. Another ``of``, or
    fewer ``done``, begins a next part.
    """
    console = Console(stderr=True)
    with _bar(title, console) if console.is_terminal or console.is_jupyter else _lines(title) as report:
        yield report


@contextmanager
def _bar(title: str, console: Console) -> Iterator[Report]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    progress = Progress(*columns, console=console)
    task = progress.add_task(title, total=None, start=False)

    def report(done: int, of: int) -> None:
        progress.start()
        progress.start_task(task)
        progress.update(task, completed=done, total=of)

    try:
        yield report
    finally:
        if progress.live.is_started:
            progress.stop()


@contextmanager
def _lines(title: str) -> Iterator[Report]:
    began_s = part_s = printed_s = time.monotonic()
    first = 0
    printed: tuple[int, int] | None = None
    now: tuple[int, int] | None = None

    def report(done: int, of: int) -> None:
        nonlocal first, part_s, printed_s, printed, now
        if now is None or of != now[1] or done < now[0]:
            # A next part begins, with a pace of its own.
            first, part_s = done, began_s if now is None else time.monotonic()
        now = (done, of)
        if time.monotonic() - printed_s >= _LINE_EVERY_S:
            printed_s, printed = time.monotonic(), now
            show(done, of)

    def show(done: int, of: int) -> None:
        now_s, made = time.monotonic(), done - first
        left = f", about {_clock((now_s - part_s) * (of - done) / made)} left" if made and done < of else ""
        print(f"{title}: {done} of {of}, {_clock(now_s - began_s)} passed{left}", file=sys.stderr, flush=True)

    try:
        yield report
    finally:
        if now is not None and now != printed:
            show(*now)


def _clock(seconds: float) -> str:
    return str(timedelta(seconds=round(seconds)))
