"""Output of tables."""

from __future__ import annotations

from rich.console import Console


def console_of(width: int = 118) -> Console:
    """Return a console as wide as the terminal, or of ``width`` where the output is not one."""
    console = Console()
    return console if console.is_terminal else Console(width=width)
