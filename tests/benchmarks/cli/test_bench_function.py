"""A bench from Python is the bench of the command."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks import TrackerWarning, bench
from benchmarks.cli.bench_function import bench as same
from benchmarks.cli.main import main
from benchmarks.contract.suite import Scene
from benchmarks.judges.frame_out.suite import FRAME_OUT
from benchmarks.run.experiment import Progress
from tests import fakes_scenario
from tests.fakes_trackers import Still
from trackers import registry

SUITE = replace(
    FRAME_OUT, scenes=(Scene(fakes_scenario.FAKE_TOWN.id, "frame-out"),), preset="tiny", quick_preset="tiny"
)
TINY: dict[str, Any] = {"seeds": range(1), "workers": 0, "trackers": ["fake_knowing", "fake_raises"]}


@pytest.mark.heavy
def test_results_and_what_failed_come_back(tmp_path: Path) -> None:
    assert bench is same
    told = "fake_raises failed in fake-town-v1 tiny, seed 0, frame 20: RuntimeError: a bug"
    with pytest.warns(TrackerWarning, match=told):
        results = bench(SUITE, out=tmp_path, **TINY)
    rows = results.rows()
    assert set(rows["tracker"]) == {"fake_knowing", "fake_raises"}
    assert set(rows["seed"]) == {0}
    assert [failure.tracker for failure in results.outcome.failures] == ["fake_raises"]
    assert results.outcome.episodes == 2
    with pytest.warns(TrackerWarning, match=told):
        again = bench(SUITE, out=str(tmp_path), **TINY)
    assert (again.outcome.episodes, again.outcome.resumed) == (0, 2)
    (failure,) = again.outcome.failures
    assert failure.reason == (
        "RuntimeError: a bug (in an earlier run, whose rows are kept; to run it again, choose another folder)"
    )
    assert repr(again) == f"Results({str(tmp_path)!r}, 1 failure)"


def test_frames_without_an_answer_are_told(tmp_path: Path) -> None:
    with pytest.warns(TrackerWarning, match=r"fake_silent gave no answer \(NaN\) on 220 frames; each counts as"):
        bench(SUITE, out=tmp_path, **{**TINY, "trackers": "fake_silent"})


def test_it_runs_in_this_process_beside_the_main_thread_too(tmp_path: Path) -> None:
    with ThreadPoolExecutor() as pool:
        results = pool.submit(bench, SUITE, out=tmp_path, **{**TINY, "trackers": "fake_still"}).result()
    assert results.outcome.episodes == 1
    assert results.outcome.failures == []


def test_quick_runs_once_what_no_seed_makes_reproducible(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    monkeypatch.setattr(
        "benchmarks.cli.bench_function.run", lambda experiment, out, report: seen.append((experiment, out))
    )
    monkeypatch.setattr("benchmarks.run.outcome.Outcome.followed_by", lambda self, later: self)
    monkeypatch.setattr("benchmarks.cli.bench_function.Results", lambda folder, outcome: folder)
    assert bench("frame-out", seeds=range(1), quick=True) == Path("results/quick")
    assert bench("frame-out", seeds=range(1), trackers="hold") == Path("results/frame-out")
    (quick, _), (whole, _) = seen
    assert (quick.episodes[0].preset, quick.repeats) == ("quick", 1)
    assert (whole.episodes[0].preset, whole.repeats, list(whole.trackers)) == ("standard", None, ["hold"])
    assert "mosaic_graph_pf" in quick.trackers


def test_progress_is_shown_under_a_title(tmp_path: Path) -> None:
    shown: list[Any] = []

    @contextmanager
    def show(title: str) -> Iterator[Progress]:
        shown.append(title)
        yield lambda done, of: shown.append((done, of))

    bench(SUITE, out=tmp_path, progress=show, **{**TINY, "trackers": "fake_still"})
    assert shown == ["frame-out, 1 tracker", (0, 1), (1, 1)]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"limit_s": "x"}, "limit_s: expected a number of seconds > 0, at most 1,000,000, got 'x'"),
        ({"limit_s": float("inf")}, "limit_s: expected a number of seconds > 0, at most 1,000,000, got inf"),
        ({"seeds": "0:2"}, r"seeds: expected range\(A, B\), got '0:2'"),
        ({"trackers": "fake_knows"}, r"trackers: expected one of .*; got 'fake_knows' \(did you mean fake_knowing\?\)"),
        ({"trackers": "mine"}, r"trackers: expected one of .*; got 'mine'; one of your own is known when its module"),
        ({"trackers": []}, r"trackers: expected a name or several, or None for the default, got \[\]"),
        ({"suite": ["frame-out"]}, r"suite: expected a name or a Suite; each suite has results of its own, got \["),
        ({"workers": 1.5}, "workers: expected a whole number >= 0, got 1.5"),
        ({"preset": ()}, r"preset: expected a name or several, or None for the default, got \(\)"),
        ({"preset": "huge"}, "preset: expected one of .*; got 'huge'"),
        ({"link": "noisy"}, "link: expected prompt, since suite frame-out knows no other, got 'noisy'"),
    ],
)
def test_wrong_arguments_are_named_before_anything_is_written(
    tmp_path: Path, wrong: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        bench(**{"suite": SUITE, "out": tmp_path / "out", **TINY, **wrong})
    assert not (tmp_path / "out").exists()


def test_a_name_that_is_given_twice_runs_once(tmp_path: Path) -> None:
    results = bench(SUITE, out=tmp_path, **{**TINY, "trackers": ["fake_still", "fake_still"]})
    assert results.outcome.episodes == len(TINY["seeds"])
    assert not list(tmp_path.glob("*outdated*"))


def test_names_are_checked_for_all_suites_before_the_first_one_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for wrong, told in (
        (["frame-out", "stereo", "--trackers", "hold"], "got 'hold', which is of suite frame-out"),
        (["follow", "frame-out", "--link", "noisy"], "link: expected prompt, since suite frame-out knows no other"),
        (["frame-out", "follow", "--data", "x"], "data: expected none with suite follow, as stored pictures"),
        (["frame-out", "--set", "rate=9"], "set: expected one of width_px"),
    ):
        assert main(["bench", *wrong, "--seeds", "0:1", "--out", str(tmp_path / "out")]) == 2
        assert told in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


def test_pictures_that_exist_take_no_values(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--real", "x", "--set", "rate_hz=9", "--out", str(tmp_path / "out")]) == 2
    assert "set: expected none with --real, which runs no episodes" in capsys.readouterr().err


def test_rows_name_the_values_that_were_set(tmp_path: Path) -> None:
    rows = bench(SUITE, out=tmp_path, preset="tiny[rate_hz=10]", **{**TINY, "trackers": "fake_still"}).rows()
    assert set(rows["preset"]) == {"tiny[rate_hz=10]"}


def test_a_tracker_of_a_cell_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its rows could not say which code made them, and would be kept when the cell has changed."""
    mine = type("Mine", (Still,), {"__module__": "__main__"})
    monkeypatch.setattr(registry, "_ENTRIES", registry.entries())
    registry.register("of_a_cell", role="external", summary="", suites=("frame-out",))(mine)
    with pytest.raises(ValueError, match="trackers: expected ones that a module of their own registers"):
        bench(SUITE, out=tmp_path / "out", **{**TINY, "trackers": "of_a_cell"})


def test_a_run_that_keeps_no_estimates_needs_no_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pyarrow", "benchmarks.data.estimates.keeping", "benchmarks.data.estimates.block_file"):
        monkeypatch.setitem(sys.modules, name, None)
    one = {**TINY, "trackers": "fake_still"}
    assert bench(SUITE, out=tmp_path / "none", **one).outcome.episodes
    with pytest.raises(ValueError, match="packages: expected pyarrow to be installed"):
        bench(SUITE, out=tmp_path / "kept", keep_estimates=True, **one)
