"""The ledger of published runs on the test split: command, commit and reason."""

from __future__ import annotations

import dataclasses
import json
import shlex
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.contract.rows import TEST_SPLIT
from sim.checks import check

LEDGER = Path(__file__).with_name("test_split_runs.jsonl")
TABLES_FOLDER = LEDGER.with_name("tables")
"""A committed file for each published table, see ``table_files``."""
TEMPLATE = LEDGER.with_name("RESULTS.template.md")
RESULTS = LEDGER.parents[2] / "RESULTS.md"
PACKAGES = ("sim", "trackers", "scenarios", "benchmarks", "tools")
_WITHOUT_EFFECT = {"out", "workers", "backend", "json", "csv", "metric", "plot"}
"""Options that change no figure and are left out of commands."""


@contextmanager
def recorded(command: str, seeds: range, why: str, ran: Callable[[], bool] = lambda: True) -> Iterator[None]:
    """Record a run on the test split in the ledger after its end, if ``why`` gives a reason to publish it.

    A run is one command at one commit: repeating it adds no line. Nor does a
    command that is in the ledger and for which nothing ``ran`` this time, asked at the end.

    Raises:
        ValueError: before a run to be published, for other seeds or without a clean checkout.
    """
    on_test_split = seeds.start < TEST_SPLIT.stop and seeds.stop > TEST_SPLIT.start
    text = f"{seeds.start}:{seeds.stop}"
    check("publish", not why or on_test_split, "seeds of the test split, 10000:20000", text)
    entry = {"command": command, "commit": commit(), "split": "test", "seeds": text, "why": why} if why else None
    yield
    if entry is not None:
        known = any(_same(entry, each) for each in _entries())
        if not known and (ran() or command not in published_runs()):
            with LEDGER.open("a") as file:
                file.write(json.dumps(entry) + "\n")


def published_runs() -> dict[str, list[dict[str, str]]]:
    """Return the ledger's entries by command, the oldest first."""
    runs: dict[str, list[dict[str, str]]] = {}
    for entry in _entries():
        runs.setdefault(entry["command"], []).append(entry)
    return runs


def command_of(name: str, options: Any, positional: str) -> str:
    """Return the command line of a command's dataclass: its options other than defaults that change figures."""
    words = ["frameout", name, *_texts(getattr(options, positional))]
    for each in dataclasses.fields(options):
        value = getattr(options, each.name)
        if each.name not in {positional, *_WITHOUT_EFFECT} and value != each.default:
            words += [f"--{each.name.replace('_', '-')}", *_texts(value)]
    return shlex.join(words)


def _texts(value: Any) -> list[str]:
    if value is True:
        return []
    return [str(each) for each in value] if isinstance(value, tuple) else [str(value)]


def _entries() -> list[dict[str, str]]:
    return [json.loads(line) for line in LEDGER.read_text().splitlines()] if LEDGER.is_file() else []


def _same(first: dict[str, str], second: dict[str, str]) -> bool:
    return all(first[key] == second[key] for key in ("command", "commit"))


def commit() -> str:
    """Return the commit of the checkout. Raises ValueError without one, and for code that is not committed."""
    _git("ls-files", "--error-unmatch", LEDGER.name, expected="a checkout of the repository, got none")
    changed = uncommitted()
    check("publish", not changed, "committed code", f"changes in {changed}")
    return _git("rev-parse", "--short=10", "HEAD", expected="a commit")


def uncommitted() -> str:
    """Return the first changed or new file of our packages, "" if all is as committed.

    What publishing itself writes does not count: the ledger, the tables, and the prose around them.
    Raises ValueError outside a checkout.
    """
    root = _git("rev-parse", "--show-toplevel", expected="a checkout")
    packages = [f"{root}/{name}" for name in PACKAGES]
    written = [f":!{name}" for name in (LEDGER.name, TABLES_FOLDER.name, TEMPLATE.name)]
    changes = _git("status", "--porcelain", "--untracked-files=all", "--", *packages, *written, expected="a commit")
    return changes.splitlines()[0].split(maxsplit=1)[1] if changes else ""


def _git(*arguments: str, expected: str) -> str:
    try:
        done = subprocess.run(["git", *arguments], cwd=LEDGER.parent, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        raise ValueError("publish: expected git to name the commit, got none on PATH") from None
    if done.returncode:
        raise ValueError(f"publish: expected {expected}")
    return done.stdout.strip()
