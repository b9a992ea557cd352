"""A small repository with a ledger, and a published table of the plain scene on development seeds."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.plain_scene import belt
from tests.tools.command import tools
from tools.publishing import ledger, tables
from tools.publishing.tables import BenchTable, PublishedTable

SMOKE = BenchTable(
    name="smoke",
    suite="belt",
    scenario=belt.CONVEYOR.id,
    preset="quick",
    trackers=("hold", "constant_velocity"),
    seeds=range(2),
)


def git(folder: Path, *arguments: str) -> str:
    author = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    done = subprocess.run(["git", *author, *arguments], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def commit_all(folder: Path, message: str) -> str:
    """Commit everything; return the commit."""
    git(folder, "add", ".")
    git(folder, "commit", "--quiet", "--allow-empty", "-m", message)
    return git(folder, "rev-parse", "--short=10", "HEAD")


def publish(out: Path, *more: str) -> int:
    """Run the command; return its exit status."""
    return tools(["publish", "--workers", "0", "--out", str(out), *more])


def recorded() -> list[dict[str, str]]:
    """Return the entries of the ledger."""
    return [json.loads(line) for line in ledger.LEDGER.read_text().splitlines()]


def contents(name: str = "smoke") -> dict[str, Any]:
    """Return the committed JSON of a table."""
    found: dict[str, Any] = json.loads((ledger.TABLES_FOLDER / f"{name}.json").read_text())
    return found


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with a module and an empty ledger, where that of ours is looked for."""
    root = tmp_path / "checkout"
    file = root / "tools/publishing/test_split_runs.jsonl"
    file.parent.mkdir(parents=True)
    file.touch()
    (root / "benchmarks").mkdir()
    (root / "benchmarks/module.py").touch()
    git(root, "init", "--quiet")
    commit_all(root, "first")
    monkeypatch.setattr(ledger, "LEDGER", file)
    monkeypatch.setattr(ledger, "TABLES_FOLDER", file.with_name("tables"))
    monkeypatch.setattr(ledger, "TEMPLATE", file.with_name("RESULTS.template.md"))
    monkeypatch.setattr(ledger, "RESULTS", root / "RESULTS.md")
    return root


@pytest.fixture
def listed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Return a function that puts tables in the place of the published ones."""
    return lambda *listed: monkeypatch.setattr(tables, "TABLES", listed)


@pytest.fixture
def smoke(listed: Callable[..., None]) -> PublishedTable:
    """The only published table."""
    listed(SMOKE)
    return SMOKE
