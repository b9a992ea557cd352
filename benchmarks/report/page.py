"""One self-contained HTML page, made from rows alone."""

from __future__ import annotations

from pathlib import Path


def write_report(directory: Path) -> Path:
    """Make ``directory/report.html`` from ``records.jsonl`` and ``summary.json`` in ``directory``; return its path.

    Pictures that lie in ``directory/pictures`` (contact sheets, written by the bench) are embedded.

    Raises:
        ValueError: if the folder holds no results.
    """
    raise NotImplementedError
