"""The option ``--modules``, the same in every command that has it; ``benchmarks.cli.main`` loads what it names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from benchmarks.cli.arguments import NAMES


@dataclass(frozen=True, kw_only=True)
class WithModules:
    """A command that knows users' own trackers, controllers, scenarios, metrics and so on.

    Attributes:
        modules: your own Python modules, by name or as files (my_tracker.py), imported first; they register trackers,
            controllers, scenarios, metrics and so on.
    """

    modules: Annotated[tuple[str, ...], NAMES] = ()
