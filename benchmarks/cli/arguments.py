"""What commands share: lists of names, ranges of seeds, ``--modules``, the message about rows that are ignored."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.contract.rows import FILE_NAME, TEST_SPLIT, read
from sim.checks import check

# The help texts of these name the default themselves.
COUNT = tyro.conf.arg(metavar="N", help_behavior_hint="")
FILES = tyro.conf.arg(metavar="FILE …", help_behavior_hint="")
FILE = tyro.conf.arg(metavar="FILE", help_behavior_hint="")
ONE_NAME = tyro.conf.arg(metavar="NAME", help_behavior_hint="")
RATE = tyro.conf.arg(metavar="FLOAT", help_behavior_hint="")
SIZE = tyro.conf.arg(metavar="INT INT", help_behavior_hint="")
VALUES = tyro.conf.arg(metavar="NAME VALUE …", help_behavior_hint="")
WORKERS = tyro.conf.arg(metavar="N", help_behavior_hint="(default: one per core)")
NAMES = tyro.conf.arg(metavar="NAME …", help_behavior_hint="")
SEEDS = tyro.conf.arg(metavar="A:B")
USUAL_SEEDS = tyro.conf.arg(metavar="A:B", help_behavior_hint="")
FOLDER = tyro.conf.arg(metavar="FOLDER", help_behavior_hint="")


def check_unset(command: object, parameters: Iterable[str], why: str) -> None:
    """Raise ValueError if one of a command's parameters is not left at its default; ``why`` comes after "none"."""
    for name in parameters:
        value, default = getattr(command, name), getattr(type(command), name)
        check(name, value == default, f"none {why}", repr(value))


def names(given: Sequence[str]) -> tuple[str, ...]:
    """Return names given as separate words or with commas between them, each once."""
    return tuple(dict.fromkeys(name for word in given for name in word.split(",") if name))


def seed_range(text: str, parameter: str = "seeds") -> range:
    """Return the half-open range of ``A:B``, or of one seed ``A``.

    Raises:
        ValueError: for anything else.
    """
    match = re.fullmatch(r"(\d+)(?::(\d+))?", text)
    first, end = (0, 0) if match is None else (int(match[1]), int(match[2] or int(match[1]) + 1))
    if first >= end:
        raise ValueError(f"{parameter}: expected A:B with 0 <= A < B, or one seed, got {text!r}")
    return range(first, end)


def development_seeds(text: str, parameter: str = "seeds") -> range:
    """Return development seeds A:B. Raises ValueError for others."""
    seeds = seed_range(text, parameter)
    check(parameter, seeds.stop <= TEST_SPLIT.start, f"development seeds, below {TEST_SPLIT.start}", repr(text))
    return seeds


@dataclass(frozen=True, kw_only=True)
class WithModules:
    """A command that knows users' own trackers, controllers, scenarios, metrics and so on.

    Attributes:
        modules: your own Python modules, by name or as files (my_tracker.py), imported first; they register trackers,
            controllers, scenarios, metrics and so on.
    """

    modules: Annotated[tuple[str, ...], NAMES] = ()


def report_ignored_rows(directory: Path) -> None:
    """Report on stderr how many lines of a folder's rows belong to no whole block, if any.

    Raises:
        ValueError: if the directory holds no records.
    """
    contents = read(directory)
    broken, replaced = len(contents.broken), len(contents.replaced)
    if broken or replaced:
        which = f"{broken} that are no rows, {replaced} of episodes that were cut off or made again later"
        print(f"note: ignored {broken + replaced} lines of {directory / FILE_NAME}: {which}", file=sys.stderr)
