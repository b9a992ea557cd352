"""Progress with an estimate of the time left, on stderr."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

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


@contextmanager
def progress_bar(title: str) -> Iterator[Report]:
    """Show a progress bar until the context ends.

    Yields a function to be called with (done, of); its first call shows the bar.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    progress = Progress(*columns, console=Console(stderr=True))
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
