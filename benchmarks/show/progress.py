"""Output on a terminal: tables as wide as it is; progress on stderr, a bar there, lines in a log file."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from benchmarks.run.experiment import Progress as Report

_LINE_EVERY_S = 30.0
"""Least time between two lines of a log, but for the last one."""


def console_of(width: int = 118) -> Console:
    """Return a console as wide as the terminal or as ``COLUMNS`` says, or of ``width`` where neither is known."""
    is_known = Console().is_terminal or os.environ.get("COLUMNS", "").isdigit()
    return Console(width=None if is_known else width)


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """Show progress until the context ends; yields a function to be called with (done, of), first when work begins."""
    console = Console(stderr=True)
    with _bar(title, console) if console.is_terminal or console.is_jupyter else _lines(title) as report:
        yield report


@contextmanager
def _bar(title: str, console: Console) -> Iterator[Report]:
    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    with Progress(TextColumn("{task.description}"), *columns, console=console) as progress:
        task = progress.add_task(title, total=None, visible=False)
        yield lambda done, of: progress.update(task, completed=done, total=of, visible=True)


@contextmanager
def _lines(title: str) -> Iterator[Report]:
    began_s = printed_s = time.monotonic()
    line = ""

    def report(done: int, of: int) -> None:
        nonlocal line, printed_s
        now_s = time.monotonic()
        line = f"{title}: {done} of {of}, {timedelta(seconds=round(now_s - began_s))} passed"
        if now_s - printed_s >= _LINE_EVERY_S:
            print(line, file=sys.stderr, flush=True)
            line, printed_s = "", now_s

    try:
        yield report
    finally:
        if line:
            print(line, file=sys.stderr, flush=True)
