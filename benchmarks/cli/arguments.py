"""What commands share: kinds of options, ``--modules``, the message about rows that are ignored."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from benchmarks.contract.rows import FILE_NAME, TEST_SPLIT, read
from benchmarks.contract.text import seed_range
from scenarios.field_values import at_commas
from sim.checks import check

# The help texts of these name the default themselves.
COUNT = tyro.conf.arg(metavar="N", help_behavior_hint="")
FILE = tyro.conf.arg(metavar="FILE", help_behavior_hint="")
ONE_NAME = tyro.conf.arg(metavar="NAME", help_behavior_hint="")
RATE = tyro.conf.arg(metavar="FLOAT", help_behavior_hint="")
SIZE = tyro.conf.arg(metavar="INT INT", help_behavior_hint="")
JSON = tyro.conf.arg(metavar="JSON", help_behavior_hint="")
VALUES = tyro.conf.arg(metavar="NAME VALUE …", help_behavior_hint="")
WORKERS = tyro.conf.arg(metavar="N", help_behavior_hint="(default: one per core)")
FOLDER = tyro.conf.arg(metavar="FOLDER", help_behavior_hint="")
_DEFAULT_IN_WORDS = tyro.conf.arg(help_behavior_hint="")


def _names(words: Sequence[str]) -> tuple[str, ...]:
    """Return names given as separate words or with commas between them, each once. A name may have commas in brackets:
    ``quick[weather=rain,traffic_cars=4]``.
    """
    return _some(dict.fromkeys(name for word in words for name in at_commas(word) if name))


def _some(values: Iterable[Any]) -> tuple[Any, ...]:
    """Return one value or more. Raises ValueError for none, which would count as an option that is not given."""
    found = tuple(values)
    if not found:
        raise ValueError("expected one value or more, got none")
    return found


def development_seeds(text: str) -> range:
    """Return development seeds A:B. Raises ValueError for others."""
    seeds = seed_range(text)
    if seeds.stop > TEST_SPLIT.start:
        raise ValueError(f"expected development seeds, below {TEST_SPLIT.start}, got {text!r}")
    return seeds


def seeds_text(seeds: range) -> str:
    """Return seeds as ``A:B``."""
    return f"{seeds.start}:{seeds.stop}"


def keywords_of(text: str) -> dict[str, Any]:
    """Return the keywords of ``--env-kwargs``. Raises ValueError for a text that is no object of JSON."""
    try:
        keywords = json.loads(text)
    except json.JSONDecodeError:
        keywords = None
    check("env_kwargs", isinstance(keywords, dict), "an object of JSON", repr(text))
    return dict(keywords)


def _kind(read_words: Callable[[list[str]], Any], metavar: str, nargs: Any, shown: Callable[[Any], list[str]]) -> Any:
    """Return how tyro reads the words of an option, and shows its default."""
    return PrimitiveConstructorSpec(nargs, metavar, read_words, lambda value: True, shown)


def _seeds_kind(read_seeds: Callable[[str], range]) -> Any:
    return _kind(lambda words: read_seeds(words[0]), "A:B", 1, lambda seeds: [seeds_text(seeds)] if seeds else [])


Names: TypeAlias = Annotated[tuple[str, ...], _DEFAULT_IN_WORDS, _kind(_names, "NAME …", "*", list)]
Values: TypeAlias = Annotated[tuple[str, ...], _DEFAULT_IN_WORDS, _kind(_some, "NAME.PARAMETER=VALUE,…", "*", list)]
Files: TypeAlias = Annotated[
    tuple[Path, ...], _DEFAULT_IN_WORDS, _kind(lambda words: _some(map(Path, words)), "FILE …", "*", list)
]
Processes: TypeAlias = tyro.conf.UseAppendAction[
    Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=COMMAND|FILE.toml", help_behavior_hint="")]
]
Settings: TypeAlias = tyro.conf.UseAppendAction[
    Annotated[tuple[str, ...], tyro.conf.arg(name="set", metavar="FIELD=VALUE", help_behavior_hint="")]
]
Seeds: TypeAlias = Annotated[range, _seeds_kind(seed_range)]
UsualSeeds: TypeAlias = Annotated[range | None, _DEFAULT_IN_WORDS, _seeds_kind(seed_range)]
DevelopmentSeeds: TypeAlias = Annotated[range, _seeds_kind(development_seeds)]
UsualDevelopmentSeeds: TypeAlias = Annotated[range | None, _DEFAULT_IN_WORDS, _seeds_kind(development_seeds)]


@dataclass(frozen=True, kw_only=True)
class WithModules:
    """A command that knows users' own trackers, controllers, scenarios, metrics and so on.

    Attributes:
        modules: your own Python modules, by name or as files (my_tracker.py), imported first; they register trackers,
            controllers, scenarios, metrics and so on.
    """

    modules: Names = ()


def report_ignored_rows(directory: Path, modules: Sequence[str]) -> None:
    """Report on stderr how many lines of a folder's rows belong to no whole block, if any; and which modules the rows
    name that are none of ``modules``: the metrics that they define are unknown.

    Raises:
        ValueError: if the directory holds no records.
    """
    contents = read(directory)
    broken, replaced = len(contents.broken), len(contents.replaced)
    if broken or replaced:
        which = f"{broken} that are no rows, {replaced} of episodes that were cut off or made again later"
        print(f"note: ignored {broken + replaced} lines of {directory / FILE_NAME}: {which}", file=sys.stderr)
    named = dict.fromkeys(name for rows in contents.blocks.values() for name in rows[0].get("modules", ()))
    if unnamed := [name for name in named if name not in modules]:
        why = "metrics, suites and scenes that they define are known with --modules " + " ".join(unnamed)
        print(f"note: the rows of {directory} were made with {', '.join(unnamed)}; {why}", file=sys.stderr)
