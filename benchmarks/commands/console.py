"""Output of tables."""

from __future__ import annotations

import os

from rich.console import Console


def console_of(width: int = 118) -> Console:
    """Return a console as wide as the terminal or as ``COLUMNS`` says, or of ``width`` where neither tells."""
    console = Console()
    return console if console.is_terminal or "COLUMNS" in os.environ else Console(width=width)
