"""Failures in one line, and those that a folder keeps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.contract.rows import BlockKey
from benchmarks.run.failures import FILE_NAME, Failure, ended_processes, read_failures, reason_of, write_failures
from benchmarks.run.own_inputs import own
from benchmarks.show import page
from benchmarks.show.page import write_report
from tests.benchmarks.named import run_named as run
from tests.benchmarks.run.test_experiment import TINY, mean_of
from tests.fakes_trackers import Raises, Still
from trackers import registry
from trackers.registry import NoParameters


class Wordless(Exception):
    """Its text raises."""

    def __str__(self) -> str:
        raise ValueError("no words")


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (RuntimeError("a bug\nin two lines"), "RuntimeError: a bug"),
        (RuntimeError(), "RuntimeError: "),
        (RuntimeError("\n\n  a bug"), "RuntimeError: a bug"),
        (RuntimeError("\x1b[31mred\x07\ud800"), "RuntimeError:  [31mred  "),
        (RuntimeError("x" * 10_000), "RuntimeError: " + "x" * 300),
        (Wordless(), "Wordless: (it has no text that can be read)"),
        (RuntimeError("a read-only disk"), "RuntimeError: a read-only disk"),
    ],
)
def test_the_first_line_that_can_be_printed(error: Exception, reason: str) -> None:
    assert reason_of(error) == reason
    reason_of(error).encode()


@pytest.mark.parametrize("grey", [False, True])
def test_who_draws_on_a_picture_is_told_to_copy_it(grey: bool) -> None:
    picture = np.zeros((8, 8, 3), np.uint8)
    image = own(np.broadcast_to(picture[..., :1], picture.shape) if grey else picture)
    with pytest.raises(cv2.error) as drawn:
        cv2.circle(image, (3, 3), 2, (1, 2, 3))
    with pytest.raises(ValueError, match="read-only") as assigned:
        image[0] = 1
    with pytest.raises(ValueError, match="WRITEABLE") as made_writeable:
        image.flags.writeable = True
    for error in (drawn, assigned, made_writeable):
        assert reason_of(error.value).endswith("read-only: change a copy, image = observation.image_rgb.copy()")
    assert "circle" in reason_of(drawn.value)


KEY = BlockKey("frame-out", "fake-town-v1", "tiny", "raster", "", "fake_raises", 3)
FAILURE = Failure("fake_raises", "fake-town-v1", "tiny", 3, 20, "RuntimeError: ä, a bug", place="mine.py, line 3")


def test_they_are_read_as_they_were_written(tmp_path: Path) -> None:
    failures = {KEY: [FAILURE, replace(FAILURE, tracker="fake_controller")], replace(KEY, seed=4): [FAILURE]}
    write_failures(tmp_path, failures)
    assert read_failures(tmp_path) == failures
    write_failures(tmp_path, {})
    assert not (tmp_path / FILE_NAME).exists()
    assert read_failures(tmp_path) == {}


@pytest.mark.heavy
def test_a_run_tells_what_failed_in_an_earlier_one(tmp_path: Path) -> None:
    raising = replace(TINY, trackers=("fake_raises", "fake_still"), seeds=range(2))
    first = run(raising, tmp_path)
    assert [(each.tracker, each.seed) for each in first.failures] == [("fake_raises", 0), ("fake_raises", 1)]
    again = run(raising, tmp_path)
    assert again.episodes == 0
    assert [replace(each, reason=first.failures[0].reason) for each in again.failures] == first.failures
    assert all(" (in an earlier run, whose rows are kept; to run it" in each.reason for each in again.failures)
    # Others in the same folder have none, and leave them there.
    assert run(replace(TINY, trackers=("fake_knowing",)), tmp_path).failures == []
    assert len(read_failures(tmp_path)) == 2


def test_rows_that_are_gone_take_their_failures_along(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    raising = replace(TINY, trackers=("fake_raises",), seeds=range(1))
    run(raising, tmp_path)
    (tmp_path / "records.jsonl").write_text("")
    monkeypatch.setattr(Raises, "misbehave", Still.misbehave)
    assert run(raising, tmp_path).failures == []
    assert run(raising, tmp_path).failures == []
    assert not (tmp_path / FILE_NAME).exists()


@pytest.mark.heavy
def test_a_tracker_that_ended_its_process_is_in_no_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To draw it would end this process too."""
    drawn: list[str] = []
    monkeypatch.setattr(page, "keep_event_picture", lambda *arguments: drawn.extend(arguments[3]))
    for tracker in ("fake_still", "fake_kills"):
        run(replace(TINY, trackers=(tracker,), seeds=range(1), workers=2), tmp_path / tracker)
        assert write_report(tmp_path / tracker).is_file()
    assert drawn == ["fake_still"]
    assert ended_processes(tmp_path / "fake_kills") == {"fake_kills"}


class _Unmade(Still):
    """Cannot be made."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        raise OSError("weights.pt not found")


def test_a_tracker_that_cannot_be_made_fails_on_the_first_frame(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "_ENTRIES", registry.entries())
    registry.register("unmade", role="external", summary="", suites=("frame-out",))(_Unmade)
    outcome = run(replace(TINY, trackers=("unmade", "fake_knowing"), seeds=range(1)), tmp_path)
    (failure,) = outcome.failures
    assert (failure.tracker, failure.frame, failure.reason) == ("unmade", 0, "OSError: weights.pt not found")
    assert failure.place.startswith("test_failures.py, line ")
    assert mean_of(outcome, "fake_knowing", "recovery_rate") == 1.0
