"""The command line of the project's own tools."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.cli.main import main
from tools.__main__ import TOOLS


def tools(words: Sequence[str]) -> int:
    """Run ``python -m tools`` with these words; return the exit status."""
    return main(words, TOOLS)
