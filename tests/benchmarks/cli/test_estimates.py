"""Estimates from the command line: kept by ``bench``, judged again by ``report``, and then compared."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli.main import main

pytestmark = pytest.mark.usefixtures("fake_suite")


def bench(out: Path, *more: str) -> int:
    """Run a small bench in this process."""
    trackers = ["--trackers", "fake_knowing", "fake_raises"]
    return main(["bench", "--workers", "0", "--seeds", "0:1", *trackers, "--out", str(out), *more])


@pytest.mark.heavy
def test_summary_and_comparisons_are_made_from_estimates_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bench(tmp_path, "--keep-estimates") == 1
    made = {name: json.loads((tmp_path / name).read_text()) for name in ("summary.json", "comparisons.json")}
    for path in tmp_path.iterdir():
        if path.name == "estimates":
            assert len(list(path.iterdir())) == 2
        elif path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    modules = ["--modules", "tests.fakes_scenario"]
    assert main(["report", str(tmp_path), "--from-estimates", "--workers", "0", *modules]) == 0
    out, err = capsys.readouterr()
    assert str(tmp_path / "report.html") in out
    assert "note: judged again: no episodes with the same rows, 2 episodes with new ones" in err
    assert {name: json.loads((tmp_path / name).read_text()) for name in made} == made
    assert main(["compare", "fake_knowing", "fake_raises", "--directory", str(tmp_path)]) == 0
    assert "fake_raises" in capsys.readouterr().out
    assert main(["report", str(tmp_path), "--from-estimates", "--workers", "0"]) == 0
    assert "note: judged again: 2 episodes with the same rows, no episodes with new ones" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["bench", "--keep-estimates"],
            "packages: expected no_such_package to be installed (pip install 'frameout[data]')",
        ),
        (
            ["report", "OUT", "--from-estimates"],
            "packages: expected no_such_package to be installed (pip install 'frameout[data]')",
        ),
        (["report", "OUT", "--data", "set"], "data: expected none without --from-estimates, got 'set'"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("benchmarks.run.packages._DATA", ("no_such_package",))
    given: list[Any] = [str(tmp_path) if word == "OUT" else word for word in words]
    assert main(given) == 2
    err = capsys.readouterr().err
    assert said in err
    assert len(err.splitlines()) == 1


@pytest.mark.heavy
def test_a_folder_without_estimates_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bench(tmp_path) == 1
    assert main(["report", str(tmp_path), "--from-estimates"]) == 2
    assert "estimates: expected files of `frameout bench --keep-estimates`, got none in" in capsys.readouterr().err
