"""``frameout compare`` in a folder with rows of several suites."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import pytest

from benchmarks.cli.main import main
from benchmarks.run.result_folder import append_block
from tests.benchmarks.fake_rows import rows_of, write_rows


@dataclass
class Told:
    """What ``compare`` printed and returned."""

    status: int
    out: str
    error: str


@pytest.fixture
def compare(tmp_path: Path, capsys: pytest.CaptureFixture[str]):  # type: ignore[no-untyped-def]
    """Return a call of the command in a folder where ``sharp`` and ``blunt`` have rows of a second suite too."""
    write_rows(tmp_path)
    for name in ("sharp", "blunt"):
        append_block(tmp_path, [{**row, "suite": "stereo"} for row in rows_of(name, 10_008)])

    def call(*words: str) -> Told:
        status = main(["compare", *words, "--directory", str(tmp_path)])
        return Told(status, *capsys.readouterr())

    return call


@pytest.mark.heavy
def test_the_suite_is_asked_for_where_both_have_rows_of_several(compare) -> None:  # type: ignore[no-untyped-def]
    told = compare("sharp", "blunt")
    assert (told.status, told.out) == (2, "")
    assert told.error == "error: suite: expected one of frame-out, stereo, as both have rows of them, got none\n"
    told = compare("sharp", "blunt", "--suite", "fish")
    assert (told.status, told.error) == (2, "error: suite: expected one of frame-out, stereo; got 'fish'\n")
    told = compare("sharp", "blunt", "--suite", "frame-out", "--metric", "recovered", "--json")
    assert (told.status, told.error) == (0, "")
    # The other suite's rows are of one more episode.
    assert {entry["n"] for entry in json.loads(told.out) if entry["frame_outs"] == "all"} == {8}


def test_one_suite_in_common_is_the_one(compare) -> None:  # type: ignore[no-untyped-def]
    told = compare("sharp", "hold")
    assert (told.status, told.error) == (0, "")
    assert "recovered" in told.out


def test_only_episodes_that_both_have_run_count(compare, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    """Episodes of two presets have the same seeds."""
    before = compare("sharp", "hold", "--json")
    for seed in range(10_000, 10_008):
        append_block(tmp_path, [{**row, "tracker": "sharp", "preset": "hard"} for row in rows_of("blunt", seed)])
        append_block(tmp_path, [{**row, "tracker": "late", "preset": "hard"} for row in rows_of("blunt", seed)])
    assert compare("sharp", "hold", "--json") == before
    told = compare("late", "hold")
    assert told.status == 2
    assert told.error == "error: second: expected a tracker with episodes that late ran on, got 'hold'\n"
