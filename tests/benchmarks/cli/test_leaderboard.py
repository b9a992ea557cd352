"""The leaderboard on a terminal of any width: whole words, and intervals."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from rich.console import Console

from benchmarks.cli import leaderboard
from benchmarks.cli.main import main
from benchmarks.contract.suite import suite
from benchmarks.show.tables import column_of
from benchmarks.statistics.summary import write_summary
from tests.benchmarks.fake_rows import TRACKERS, write_rows


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("results")
    write_rows(directory, range(10_000, 10_003))
    return directory


@pytest.mark.parametrize("width", [60, 80, 118, 132, 200])
def test_no_word_is_cut_and_each_number_has_its_interval(
    width: int, results: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(leaderboard, "console_of", lambda _: Console(width=width))
    leaderboard.print_leaderboard(write_summary(results))
    out = capsys.readouterr().out
    assert "…" not in out
    assert max(map(len, out.splitlines())) <= width
    assert set(TRACKERS) <= {line.split()[0] for line in out.splitlines() if line.strip()}
    intervals = re.findall(r"−?\d[\d.]*–\d", out)
    assert len(intervals) >= 2 * len(TRACKERS)
    shown, _, left_out = out.partition("not shown, as the table would be too wide:")
    heads = {
        word for name in suite("frame-out").headline for word in column_of(suite("frame-out").metric(name)).head.split()
    }
    assert set(re.findall(r"[a-z]{3,}", shown.split("─")[0].split("them")[-1])) <= heads | {"tracker", "role"}
    assert (left_out == "") == (width >= 132)


def test_metrics_are_chosen(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(results), "--markdown", "--metric", "kept_rate", "offscreen_error_30_m"]) == 0
    table = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("| tracker"))
    assert table == "| tracker | role | kept rate (%) ↑ | offscreen error 30 (m) ↓ |"
    assert "recovery rate" in (results / "report.html").read_text().partition("Every metric")[2]


def test_the_title_tells_how_many_events_there_are(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(results), "--markdown"]) == 0
    assert ": 3 episodes (frame-outs: 9), 95 % intervals over them\n" in capsys.readouterr().out


def test_two_suites_on_one_scene_have_a_table_each(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The scenes of ``many`` are those of others."""
    entries = [each for each in write_summary(results) if each["metric"] == "recovery_rate"]
    other = [each | {"suite": "many", "metric": "hota"} for each in entries]
    leaderboard.print_leaderboard([*entries, *other], markdown=True)
    first, second = capsys.readouterr().out.split("| tracker")[1:]
    assert "recovery rate" in first
    assert "HOTA" not in first
    assert "HOTA" in second.splitlines()[0]
    assert "many, road-town-v2, standard, raster: 3 episodes" in first


def test_a_metric_without_rows_is_named(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    entries = write_summary(results)
    recovered = [each for each in entries if each["metric"] == "recovery_rate"]
    leaderboard.print_leaderboard(recovered, ["kept_rate", "recovery_rate"])
    assert "; no row gives kept_rate" in " ".join(capsys.readouterr().out.split())
    leaderboard.print_leaderboard(entries, ["kept_rate", "recovery_rate"])
    assert "no row gives" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("metric", "told"),
    [
        ("speed", "error: metric: expected one of recovery_rate, .*; got 'speed'"),
        ("recovery", r"; got 'recovery' \(did you mean recovery_rate\?\)"),
    ],
)
def test_unknown_metrics_are_refused(metric: str, told: str, results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(results), "--metric", metric]) == 2
    assert re.search(told, capsys.readouterr().err)


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert re.fullmatch(r"frameout \d+\.\d+\.\d+\n", capsys.readouterr().out)
