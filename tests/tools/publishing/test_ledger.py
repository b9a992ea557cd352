"""Published commands on the test split are counted, once for each commit, and only as they were committed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.cli.bench import Bench
from tests.tools.publishing.conftest import git
from tools.publishing import ledger

TEST_SEEDS = range(9_999, 10_001)


def publish(command: str = "frameout bench stereo", why: str = "a table", seeds: range = TEST_SEEDS) -> None:
    with ledger.recorded(command, seeds, why):
        pass


def test_a_command_counts_once_for_each_commit(checkout: Path) -> None:
    publish()
    publish(why="stopped, and gone on with")
    publish("frameout paper A2")
    first = git(checkout, "rev-parse", "--short=10", "HEAD")
    git(checkout, "commit", "--quiet", "--all", "-m", "second")
    publish(why="made anew")
    runs = ledger.published_runs()
    assert [entry["why"] for entry in runs["frameout bench stereo"]] == ["a table", "made anew"]
    assert runs["frameout paper A2"] == [
        {"command": "frameout paper A2", "commit": first, "split": "test", "seeds": "9999:10001", "why": "a table"}
    ]
    assert len(ledger.LEDGER.read_text().splitlines()) == 3


def test_a_run_that_was_stopped_or_refused_is_not_counted(checkout: Path) -> None:
    with pytest.raises(KeyboardInterrupt), ledger.recorded("frameout bench", TEST_SEEDS, "a table"):
        raise KeyboardInterrupt
    assert ledger.published_runs() == {}


def test_without_a_reason_nothing_is_counted(checkout: Path) -> None:
    publish(why="")
    assert ledger.published_runs() == {}


def test_only_code_as_committed_is_published(checkout: Path) -> None:
    publish()
    publish("frameout paper A2")
    (checkout / "benchmarks/module.py").write_text("changed = True\n")
    with pytest.raises(ValueError, match=r"publish: expected committed code, .* benchmarks/module.py"):
        publish("frameout paper A3")


def test_outside_a_checkout_nothing_is_published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Installed somewhere within another repository, too, which does not know the ledger."""
    git(tmp_path, "init", "--quiet")
    monkeypatch.setattr(ledger, "LEDGER", tmp_path / "test_split_runs.jsonl")
    with pytest.raises(ValueError, match="publish: expected a checkout"):
        publish()


def test_development_seeds_are_not_published(checkout: Path) -> None:
    with pytest.raises(ValueError, match="publish: expected seeds of the test split, 10000:20000, got 0:5"):
        publish(seeds=range(5))


def test_a_command_is_told_by_what_changes_figures() -> None:
    bench = Bench(("stereo",), trackers=("a", "b"), quick=True, limit_s=2.0, out=Path("x"), workers=3)
    assert ledger.command_of("bench", bench, "suites") == "frameout bench stereo --trackers a b --quick --limit-s 2.0"


def test_the_ledger_of_this_repository_can_be_read() -> None:
    keys = {"command", "commit", "split", "seeds", "why"}
    entries = [json.loads(line) for line in ledger.LEDGER.read_text().splitlines()]
    assert all(set(entry) == keys for entry in entries)
