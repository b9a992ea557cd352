"""Output of tables."""

from __future__ import annotations

import os

from rich.console import Console


def console_of(width: int = 118) -> Console:
    """Return a console as wide as the terminal or as ``COLUMNS`` says, or of ``width`` where neither tells."""
    console = Console()
    told = os.environ.get("COLUMNS", "")
    return console if console.is_terminal or (told.isdigit() and int(told) > 0) else Console(width=width)
