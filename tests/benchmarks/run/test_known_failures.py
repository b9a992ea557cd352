"""Failures outlive the run that found them, and no longer than the rows that they are about."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.run.experiment import run
from benchmarks.run.failures import Failure
from benchmarks.run.known_failures import FILE_NAME, read_failures, write_failures
from benchmarks.run.records import BlockKey
from tests.benchmarks.run.test_experiment import TINY, mean_of
from tests.fakes_trackers import Still
from trackers import registry
from trackers.registry import NoParameters

KEY = BlockKey("frame-out", "fake-town-v1", "tiny", "raster", "", "fake_raises", 3)
FAILURE = Failure("fake_raises", "fake-town-v1", "tiny", 3, 20, "RuntimeError: ä, a bug", place="mine.py, line 3")


def test_they_are_read_as_they_were_written_and_broken_lines_are_left_out(tmp_path: Path) -> None:
    failures = {KEY: [FAILURE, replace(FAILURE, tracker="fake_controller")], replace(KEY, seed=4): [FAILURE]}
    write_failures(tmp_path, failures)
    file = tmp_path / FILE_NAME
    file.write_text(file.read_text() + '3\n{"tracker": "x"}\n{"block": {}, "tr')
    assert read_failures(tmp_path) == failures
    write_failures(tmp_path, {})
    assert not file.exists()
    assert read_failures(tmp_path) == {}


def test_a_run_tells_what_failed_in_an_earlier_one(tmp_path: Path) -> None:
    raising = replace(TINY, trackers=("fake_raises", "fake_still"), seeds=range(2))
    first = run(raising, tmp_path)
    assert [(each.tracker, each.seed) for each in first.failures] == [("fake_raises", 0), ("fake_raises", 1)]
    again = run(raising, tmp_path)
    assert (again.episodes, again.failures) == (0, first.failures)
    # Others in the same folder have none, and leave them there.
    assert run(replace(TINY, trackers=("fake_knowing",)), tmp_path).failures == []
    # Rows that are gone take theirs along.
    (tmp_path / "records.jsonl").write_text("")
    assert run(replace(raising, trackers=("fake_still",)), tmp_path).failures == []
    assert run(raising, tmp_path).failures == first.failures
    assert len(read_failures(tmp_path)) == 2


class _Unmade(Still):
    """Cannot be made."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        raise OSError("weights.pt not found")


class _UnmadeOfMany(_Unmade):
    """Cannot be made, and would follow many."""

    def start(self, background: object, camera: object) -> None:
        """Never called."""


@pytest.mark.parametrize("kind", [_Unmade, _UnmadeOfMany])
def test_a_tracker_that_cannot_be_made_fails_on_the_first_frame(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: type
) -> None:
    monkeypatch.setattr(registry, "_ENTRIES", dict(registry._ENTRIES))
    registry.register("unmade", role="external", summary="", suites=("frame-out",))(kind)
    outcome = run(replace(TINY, trackers=("unmade", "fake_knowing"), seeds=range(1)), tmp_path)
    (failure,) = outcome.failures
    assert (failure.tracker, failure.frame, failure.reason) == ("unmade", 0, "OSError: weights.pt not found")
    assert failure.place.startswith("test_known_failures.py, line ")
    assert mean_of(outcome, "fake_knowing", "recovery_rate") == 1.0
