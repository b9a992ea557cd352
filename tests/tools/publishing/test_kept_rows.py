"""Published tables keep rows of an earlier commit of the present editions, and no others."""

from __future__ import annotations

import dataclasses
import itertools
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.contract.rows import FILE_NAME, BlockKey, read_blocks
from tests.tools.publishing.conftest import SMOKE, commit_all, contents, git, publish
from tools.publishing import durations, ledger
from tools.publishing.durations import duration_of
from tools.publishing.published import PublishedTable
from tools.publishing.table_runs import PaperRun, run_of
from trackers import registry

pytestmark = pytest.mark.usefixtures("smoke", "unmeasured")


def change_parameters(tracker: str, monkeypatch: pytest.MonkeyPatch, **values: float) -> None:
    changed = dataclasses.replace(registry.entry(tracker), overrides=values)
    monkeypatch.setitem(registry._ENTRIES, tracker, changed)


@pytest.mark.heavy
def test_rows_of_an_earlier_commit_of_the_present_editions_stay(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    first = git(checkout, "rev-parse", "--short=10", "HEAD")
    assert publish(out) == 0
    # What publishing wrote does not count as a change.
    assert publish(out) == 0
    assert contents()["commit"] == first
    before = read_blocks(out / "smoke")
    second = commit_all(checkout, "second")
    assert publish(out) == 0
    assert contents()["commit"] == second
    assert read_blocks(out / "smoke") == before
    # One contestant's parameters are others now: its rows alone are made anew.
    change_parameters("constant_velocity", monkeypatch, acceleration_px=2.5)
    commit_all(checkout, "third")
    assert publish(out) == 0
    after = read_blocks(out / "smoke")
    assert after.keys() == before.keys()
    for key, rows in after.items():
        assert (rows == before[key]) == (key.tracker != "constant_velocity")


def test_the_plan_counts_rows_of_other_editions_as_missing(
    checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    assert publish(out) == 0

    def missing() -> float:
        return duration_of(run_of(SMOKE), out, out / SMOKE.name, lambda done, of: None).missing

    assert missing() == 0.0
    change_parameters("constant_velocity", monkeypatch, acceleration_px=2.5)
    assert missing() > 0.0


def test_the_hours_of_a_paper_are_of_all_its_presets_and_varied_settings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = run_of(PublishedTable(name="b3", kind="paper", experiment="B3", seeds=range(8)))
    presets, trackers = run.experiment.presets, run.experiment.contestants
    assert len(presets) == 2
    row = {"controller": None, "seconds": 3.0}
    blocks = {
        BlockKey("stereo", "stereo-follow-v2", preset, "raster", "", tracker, seed): [row | {"tracker": tracker}]
        for preset, tracker, seed in itertools.product(presets, trackers, range(4))
    }
    monkeypatch.setattr(durations, "read_blocks", lambda folder: blocks)
    monkeypatch.setattr(PaperRun, "is_current", lambda *_: True)
    (tmp_path / FILE_NAME).touch()
    found = duration_of(run, tmp_path, tmp_path, lambda done, of: None)
    assert found.missing == 4
    made = run.experiment.robustness
    varied = len(made.trackers) * (len(made.settings) + len(made.rates)) * made.episodes
    assert varied > 0
    assert found.seed_s == pytest.approx(3.0 * (2 * len(trackers) + varied / 8))


def test_rows_of_contestants_and_seeds_that_a_table_lost_go(
    checkout: Path, tmp_path: Path, listed: Callable[..., None]
) -> None:
    out = tmp_path / "out"
    assert publish(out) == 0
    shutil.copytree(out / "smoke", out / "smoke/robustness")
    less = replace(SMOKE, trackers=("hold",), seeds=range(1, 3))
    assert duration_of(run_of(less), out, out / SMOKE.name, lambda done, of: None).missing == 1
    listed(less)
    commit_all(checkout, "second")
    assert publish(out) == 0
    assert {(key.tracker, key.seed) for key in read_blocks(out / "smoke")} == {("hold", 1), ("hold", 2)}
    assert {key.seed for key in read_blocks(out / "smoke/robustness")} == {1}
    assert {entry["tracker"] for entry in contents()["summary"]} == {"hold"}
    assert list((out / "smoke").glob("records.outdated-*"))


@pytest.mark.heavy
def test_a_new_folder_goes_on_from_the_committed_rows(
    checkout: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    listed: Callable[..., None],
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(ledger, "TEST_SPLIT", range(4))
    assert publish(tmp_path / "out") == 0
    commit_all(checkout, "published")
    runs = ledger.LEDGER.read_text()
    assert runs
    capsys.readouterr()
    assert publish(tmp_path / "another", "--dry-run") == 0
    (line,) = [line.split() for line in capsys.readouterr().out.splitlines() if "smoke" in line]
    assert line[:4] == ["smoke", "0:2", "0", "0.00"]
    assert publish(tmp_path / "another") == 0
    first, second = (read_blocks(tmp_path / name / "smoke") for name in ("out", "another"))
    assert {key: rows[0]["seconds"] for key, rows in first.items()} == {
        key: rows[0]["seconds"] for key, rows in second.items()
    }
    assert ledger.LEDGER.read_text() == runs
    # Of other seeds they are no beginning.
    listed(replace(SMOKE, seeds=range(1)))
    assert publish(tmp_path / "fewer") == 0
    assert {key.seed for key in read_blocks(tmp_path / "fewer" / "smoke")} == {0}
