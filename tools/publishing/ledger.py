"""The ledger of published runs on the test split, and the commit that they are published at."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from benchmarks.contract.rows import TEST_SPLIT

LEDGER = Path(__file__).with_name("test_split_runs.jsonl")
TABLES_FOLDER = LEDGER.with_name("tables")
"""A committed file for each published table, see ``table_files``."""
TEMPLATE = LEDGER.with_name("RESULTS.template.md")
RESULTS = LEDGER.parents[2] / "RESULTS.md"
PACKAGES = ("sim", "trackers", "scenarios", "benchmarks", "tools")


def record(command: str, at: str, seeds: range, why: str) -> None:
    """Add a line to the ledger for a run that made rows, if one of its seeds is of the test split.

    A run is one command at one commit, ``at``: repeating it adds no line.
    """
    entry = {"command": command, "commit": at, "split": "test", "seeds": f"{seeds.start}:{seeds.stop}", "why": why}
    known = {(each["command"], each["commit"]) for each in map(json.loads, LEDGER.read_text().splitlines())}
    if seeds.start < TEST_SPLIT.stop and seeds.stop > TEST_SPLIT.start and (command, at) not in known:
        with LEDGER.open("a") as file:
            file.write(json.dumps(entry) + "\n")


def commit() -> str:
    """Return the commit of the checkout. Raises ValueError without one, and for code that is not committed."""
    _git("ls-files", "--error-unmatch", LEDGER.name, expected="a checkout of the repository, got none")
    if changed := uncommitted():
        raise ValueError(f"publish: expected committed code, got changes in {changed}")
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
    done = subprocess.run(["git", *arguments], cwd=LEDGER.parent, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ValueError(f"publish: expected {expected}")
    return done.stdout.strip()
