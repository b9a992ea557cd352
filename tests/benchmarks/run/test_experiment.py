from __future__ import annotations

import json
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.contract.rows import read_blocks, read_rows
from benchmarks.judges.frame_out.metrics.localisation import WORST_ERROR_M
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run import experiment
from benchmarks.run.jobs import Job, run_job
from benchmarks.run.outcome import Outcome
from benchmarks.run.selection import SET_PATH, job_on, tracker_named
from benchmarks.show.provenance import provenance
from tests import fakes_scenario
from tests.benchmarks.named import NamedExperiment as Experiment
from tests.benchmarks.named import run_named as run

TINY = Experiment(
    suite="frame-out",
    scenario=fakes_scenario.FAKE_TOWN.id,
    presets=("tiny",),
    trackers=("fake_knowing", "fake_still"),
    seeds=range(2),
    workers=0,
    limit_s=60.0,
    modules=("tests.fakes_scenario",),
)


def without_times(directory: Path) -> list[dict[str, Any]]:
    """Return all rows without the values that depend on the clock."""
    rows = [row for row in read_rows(directory) if row["metric"] not in TIMES]
    for row in rows:
        del row["seconds"]
    return rows


def mean_of(outcome: Outcome, tracker: str, metric: str) -> float:
    (mean,) = (e["mean"] for e in outcome.summary if e["tracker"] == tracker and e["metric"] == metric)
    return float(mean)


@pytest.mark.heavy
def test_the_right_tracker_wins(tmp_path: Path) -> None:
    outcome = run(TINY, tmp_path)
    assert mean_of(outcome, "fake_knowing", "recovery_rate") == 1.0
    assert mean_of(outcome, "fake_knowing", "offscreen_error_30_m") < 1.5
    assert mean_of(outcome, "fake_knowing", "coverage_95") == pytest.approx(0.95, abs=0.03)
    assert mean_of(outcome, "fake_knowing", "nees") == pytest.approx(2.0, abs=0.4)
    assert mean_of(outcome, "fake_knowing", "in_view_gm") > 0.99
    assert mean_of(outcome, "fake_still", "recovery_rate") == 0.0
    assert mean_of(outcome, "fake_still", "in_view_tnr") == 0.0
    comparisons = json.loads((tmp_path / "comparisons.json").read_text())
    assert {(c["tracker"], c["other"]) for c in comparisons} == {("fake_knowing", "fake_still")}


def test_the_summary_has_exactly_the_shape_that_others_rely_on(tmp_path: Path) -> None:
    run(TINY, tmp_path)
    names = "suite scenario preset tracker role renderer metric unit better mean ci_low ci_high n"
    for entry in json.loads((tmp_path / "summary.json").read_text()):
        assert list(entry) == names.split()
        assert entry["ci_low"] <= entry["mean"] <= entry["ci_high"]


def test_rows_do_not_depend_on_workers_order_or_company(tmp_path: Path) -> None:
    run(TINY, tmp_path / "here")
    run(replace(TINY, workers=2), tmp_path / "processes")
    run(replace(TINY, trackers=("fake_still",)), tmp_path / "apart")
    run(replace(TINY, trackers=("fake_knowing",)), tmp_path / "apart")
    here = without_times(tmp_path / "here")
    assert here == without_times(tmp_path / "processes")
    assert here == without_times(tmp_path / "apart")


@pytest.mark.heavy
def test_a_stopped_run_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[int] = []

    def stopped(job: Job) -> Any:
        calls.append(job.episode.seed)
        if job.episode.seed == 1:
            raise KeyboardInterrupt
        return run_job(job)

    monkeypatch.setattr("benchmarks.run.workers.run_job", stopped)
    with pytest.raises(KeyboardInterrupt):
        run(TINY, tmp_path)
    assert {key.seed for key in read_blocks(tmp_path)} == {0}
    with (tmp_path / "records.jsonl").open("a") as file:
        file.write('{"suite": "frame-out", "scen')
    monkeypatch.setattr(
        "benchmarks.run.workers.run_job", lambda job: calls.append(10 + job.episode.seed) or run_job(job)
    )
    outcome = run(TINY, tmp_path)
    assert calls == [0, 1, 11]
    assert (outcome.resumed, outcome.episodes) == (2, 2)
    run(TINY, tmp_path / "at once")
    assert without_times(tmp_path) == without_times(tmp_path / "at once")
    assert run(TINY, tmp_path).episodes == 0


@pytest.mark.heavy
def test_what_another_edition_made_is_made_again(tmp_path: Path) -> None:
    run(TINY, tmp_path)
    file = tmp_path / "records.jsonl"
    lines = file.read_text().splitlines()
    still = [k for k, line in enumerate(lines) if json.loads(line)["tracker"] == "fake_still"]
    for k in still:
        row = json.loads(lines[k])
        row["editions"]["tracker"] = "another"
        lines[k] = json.dumps(row)
    file.write_text("\n".join(lines) + "\n")
    outcome = run(TINY, tmp_path)
    assert (outcome.resumed, outcome.episodes) == (2, 2)
    aside = tmp_path / "records.outdated-1.jsonl"
    assert outcome.moved == [f"{len(still)} rows that are outdated, cut off or broken were moved to {aside}"]
    moved = [json.loads(line) for line in aside.read_text().splitlines()]
    assert {(row["tracker"], row["editions"]["tracker"]) for row in moved} == {("fake_still", "another")}
    assert len(moved) == len(still)


def test_jobs_are_made_as_they_are_worked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Progress is shown before the first episode, and no list of all jobs is made."""
    made: list[int] = []
    monkeypatch.setattr(experiment, "Job", lambda **fields: made.append(fields["episode"].seed) or Job(**fields))

    def stopped(job: Job) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr("benchmarks.run.workers.run_job", stopped)
    shown: list[tuple[int, int]] = []
    with pytest.raises(KeyboardInterrupt):
        run(replace(TINY, seeds=range(100)), tmp_path, lambda done, of: shown.append((done, of)))
    assert shown == [(0, 200)]
    assert made == [0]


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("tracker", "reason"),
    [
        ("fake_raises", "RuntimeError: a bug"),
        ("fake_exits", "SystemExit: bye"),
        ("fake_spoils", "ValueError: assignment destination is read-only"),
        ("fake_half_nan", "position_px: expected finite numbers, got [nan, 3.0]"),
        ("fake_wrong_shape", "position_px: expected the shape (2,), got (3,)"),
        ("fake_slow", "took longer than 0.5 s over one frame"),
    ],
)
def test_a_tracker_that_fails_is_named_and_has_the_worst_score(tmp_path: Path, tracker: str, reason: str) -> None:
    limit_s = 0.05 if tracker == "fake_slow" else TINY.limit_s
    outcome = run(replace(TINY, trackers=(tracker, "fake_knowing"), seeds=range(1), limit_s=limit_s), tmp_path)
    (failure,) = outcome.failures
    told = str(failure)
    assert "\n" not in told
    for part in (tracker, "fake-town-v1 tiny, seed 0, frame 20", reason):
        assert part in told
    assert mean_of(outcome, tracker, "recovery_rate") == 0.0
    assert mean_of(outcome, tracker, "offscreen_error_m") == WORST_ERROR_M
    assert mean_of(outcome, tracker, "in_view_tnr") == 0.0
    assert mean_of(outcome, "fake_knowing", "recovery_rate") == 1.0
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    rows = read_rows(tmp_path)
    assert {row.get("limit_s", TINY.limit_s) for row in rows} == {limit_s}
    assert ("--limit-s 0.05" in provenance(rows)["command"]) == (tracker == "fake_slow")


def test_a_silent_tracker_is_no_failure_but_has_the_worst_error(tmp_path: Path) -> None:
    outcome = run(replace(TINY, trackers=("fake_silent",)), tmp_path)
    assert outcome.failures == []
    assert outcome.silent == {"fake_silent": 2 * 220}
    assert mean_of(outcome, "fake_silent", "offscreen_error_m") == WORST_ERROR_M


def test_a_tracker_that_kills_its_process_is_found_and_the_others_results_stand(tmp_path: Path) -> None:
    trackers = ("fake_knowing", "fake_kills", "fake_still")
    outcome = run(replace(TINY, trackers=trackers, workers=2, seeds=range(1)), tmp_path)
    assert sorted((f.tracker, f.seed, f.frame) for f in outcome.failures) == [("fake_kills", k, 20) for k in range(1)]
    assert all("ended its process" in f.reason for f in outcome.failures)
    assert mean_of(outcome, "fake_kills", "offscreen_error_m") == WORST_ERROR_M
    run(replace(TINY, seeds=range(1)), tmp_path / "without")
    others = [row for row in without_times(tmp_path) if row["tracker"] != "fake_kills"]
    assert others == without_times(tmp_path / "without")
    assert not (tmp_path / ".running").exists()


@pytest.mark.heavy
def test_in_closed_loop_the_tracker_steers(tmp_path: Path) -> None:
    outcome = run(replace(TINY, presets=("tiny-loop",)), tmp_path)
    assert {entry["controller"] for entry in outcome.summary} == {"centre"}
    assert mean_of(outcome, "fake_knowing", "time_in_view") == 1.0
    assert mean_of(outcome, "fake_knowing", "losses_per_minute") == 0.0
    assert mean_of(outcome, "fake_still", "time_in_view") < 0.5
    # Its car never comes back, which counts, since the tracker steered.
    assert mean_of(outcome, "fake_still", "recovery_rate") == 0.0
    outcome = run(replace(TINY, presets=("tiny-loop",), controllers=(SET_PATH,)), tmp_path / "set")
    assert "controller" not in outcome.summary[0]


def test_trackers_that_no_seed_reaches_run_three_times(tmp_path: Path) -> None:
    tracker = replace(tracker_named("fake_knowing"), reproducible=False)
    run(replace(TINY, trackers={"fake_knowing": tracker}, seeds=range(1)), tmp_path)
    rows = [row for row in read_rows(tmp_path) if row["metric"] == "centre_error_px"]
    assert [row["repeat"] for row in rows] == [0, 1, 2]
    assert len({row["value"] for row in rows}) == 3


def test_an_empty_folder_is_left_where_nothing_can_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match="out: expected a folder that can be written, got"):
        run(TINY, tmp_path / "file")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"suite": "nix"}, r"suite: expected one of .*fish, follow, frame-out, harbour, .*stereo.*; got 'nix'"),
        ({"scenario": "nix"}, "scenario: expected one of .*; got 'nix'"),
        ({"presets": ("nix",)}, "preset: expected one of tiny, tiny-loop.*; got 'nix'"),
        ({"trackers": ("nix",)}, "trackers: expected one of .*fake_knowing.*; got 'nix'"),
        ({"controllers": ("nix",)}, "controllers: expected one of set-path, .*centre.*; got 'nix'"),
        ({"renderer": "nix"}, "renderer: expected one of raster, pybullet; got 'nix'"),
        ({"seeds": range(3, 3)}, "seeds: expected A:B with 0 <= A < B, got 3:3"),
        ({"seeds": range(-3, 3)}, "seeds: expected A:B with 0 <= A < B, got -3:3"),
        ({"workers": -1}, "workers: expected a whole number >= 0, got -1"),
        ({"limit_s": 0.0}, "limit_s: expected a number of seconds > 0, at most 1,000,000, got 0"),
        ({"modules": ("no.such.module",)}, "modules: expected one that can be imported, got 'no.such.module'"),
    ],
)
def test_what_does_not_exist_is_named(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        run(replace(TINY, **change), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_seeds_are_not_mixed_in_one_folder(tmp_path: Path) -> None:
    run(replace(TINY, trackers=("fake_still",)), tmp_path)
    told = "out: expected a folder with no seeds but 10000:10001, e.g. an empty one, got .* seed 0"
    with pytest.raises(ValueError, match=told):
        run(replace(TINY, seeds=range(10_000, 10_001)), tmp_path)


def test_settings_that_are_tried_draw_the_numbers_of_their_tracker() -> None:
    job = job_on("frame-out", "fake-town", "tiny", 0, ("fake_knowing",))
    tried = {"fake_knowing": tracker_named("fake_knowing"), "trial": tracker_named("fake_knowing")}
    blocks = run_job(replace(job, trackers=tried)).blocks
    errors = [[row["value"] for row in block if row["metric"] == "offscreen_error_m"] for block in blocks]
    assert errors[0] == errors[1]
    with pytest.raises(ValueError, match="fake_knowing: expected no parameter, got 'nix'"):
        tracker_named("fake_knowing", nix=1)


def test_each_tracker_runs_as_often_as_wanted_with_random_numbers_of_its_own(tmp_path: Path) -> None:
    drawing = replace(TINY, trackers=("fake_knowing",), seeds=range(1))
    once = run(drawing, tmp_path)
    assert {row["repeat"] for row in read_rows(tmp_path)} == {0}
    first = without_times(tmp_path)
    again = run(replace(drawing, repeats=3), tmp_path)
    assert (once.episodes, again.episodes, again.resumed) == (1, 1, 0)
    rows = without_times(tmp_path)
    by_repeat = [[row | {"repeat": 0} for row in rows if row["repeat"] == repeat] for repeat in range(3)]
    # The first run is that without repeats; the others draw other numbers.
    assert by_repeat[0] == first
    errors = [[row["value"] for row in some if row["metric"] == "nees"] for some in by_repeat]
    assert len({str(each) for each in errors}) == 3
    assert "--repeats 3" in provenance(read_rows(tmp_path))["command"]
    # More runs than are wanted are kept.
    assert run(replace(drawing, repeats=2), tmp_path).episodes == 0
    assert run(drawing, tmp_path).episodes == 0


@pytest.mark.parametrize("repeats", [0, -1, 1.5, "many"])
def test_a_number_of_runs_that_is_none_is_refused(repeats: Any) -> None:
    with pytest.raises(ValueError, match=r"repeats: expected a whole number > 0, got"):
        replace(TINY, repeats=repeats).made()


def test_runs_that_a_controller_does_not_follow_are_refused() -> None:
    steered = Experiment("follow", "road-town", ("quick",), ("hold",), range(1), controllers=("centre",), repeats=2)
    with pytest.raises(ValueError, match="repeats: expected 1 where a controller steers"):
        steered.made()
