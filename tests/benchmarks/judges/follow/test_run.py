"""The suite ``follow`` from end to end in the world of arithmetic: run, resume, fail, report, compare, command line."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli.main import main
from benchmarks.contract import suite as suites
from benchmarks.contract.rows import FILE_NAME, read_blocks, read_rows
from benchmarks.data.estimates.keeping import Estimates
from benchmarks.data.estimates.rejudging import rejudge
from benchmarks.judges.follow.suite import FOLLOW
from benchmarks.run.outcome import Outcome
from benchmarks.run.result_folder import append_block
from benchmarks.show.page import write_report
from benchmarks.show.showing import showing_of
from benchmarks.statistics.summary import write_summary
from tests.benchmarks.named import NamedExperiment as Experiment
from tests.benchmarks.named import run_named as run
from tests.benchmarks.run.fake_steering import FAKE_CONTROLLERS, FAKE_FOLLOW
from tests.benchmarks.run.test_experiment import without_times
from trackers.controllers import catalogue

CONTROLLERS = ("hold", "centre", "fake_ours")
TRACKERS = ("fake_knowing", "fake_still")
TINY = Experiment(
    suite="follow",
    scenario=FAKE_FOLLOW.scenes[0].scenario,
    presets=("tiny",),
    trackers=TRACKERS,
    controllers=CONTROLLERS,
    seeds=range(2),
    workers=0,
)


@pytest.fixture(scope="module", autouse=True)
def _fake_suite() -> Any:
    """Give the suite the world of arithmetic and our controllers."""
    with pytest.MonkeyPatch.context() as patch:
        suites.suites()
        patch.setitem(suites._SUITES, "follow", FAKE_FOLLOW)
        for entry in FAKE_CONTROLLERS:
            patch.setitem(catalogue._ENTRIES, (entry.carrier, entry.name), entry)
        yield


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> tuple[Outcome, Path]:
    out = tmp_path_factory.mktemp("follow")
    return run(TINY, out), out


def mean_of(outcome: Outcome, controller: str, tracker: str, metric: str) -> float:
    names = {"controller": controller, "tracker": tracker, "metric": metric}
    (mean,) = (e["mean"] for e in outcome.summary if names.items() <= e.items())
    return float(mean)


@pytest.mark.heavy
def test_who_steers_by_who_knows_keeps_it_in_view(outcome: tuple[Outcome, Path]) -> None:
    made, _ = outcome
    best = {
        "time_seen": 1.0,
        "time_in_view": 1.0,
        "losses_per_minute": 0.0,
        "wrong_target_rate": 0.0,
        "sr_500": 1.0,
        "dat_tsr": 1.0,
    }
    assert {metric: mean_of(made, "centre", "fake_knowing", metric) for metric in best} == best
    assert mean_of(made, "hold", "fake_knowing", "time_in_view") < 0.5
    assert mean_of(made, "hold", "fake_knowing", "effort") == 0.0
    assert mean_of(made, "hold", "fake_knowing", "sr_500") == 0.0
    assert mean_of(made, "hold", "fake_knowing", "time_to_find_again_s") > 2.0
    assert mean_of(made, "centre", "fake_still", "time_in_view") < 0.5


def test_rows_name_controller_tracker_and_link(outcome: tuple[Outcome, Path]) -> None:
    _, out = outcome
    keys = "suite scenario preset tracker role controller renderer seed tracker_role link repeat metric value weight"
    rows = read_rows(out)
    for row in rows:
        assert list(row) == [*keys.split(), "event", "seconds", "editions"]
    assert {(row["controller"], row["role"]) for row in rows} == {
        ("hold", "blind"),
        ("centre", "baseline"),
        ("fake_ours", "ours"),
    }
    assert {(row["tracker"], row["tracker_role"]) for row in rows} == {
        ("fake_knowing", "ours"),
        ("fake_still", "baseline"),
    }
    assert {row["link"] for row in rows} == {"prompt"}
    assert len(read_blocks(out)) == 3 * 2 * 2
    assert all("controller" in row["editions"] for row in rows)


def test_the_summary_has_the_shape_that_others_rely_on(outcome: tuple[Outcome, Path]) -> None:
    names = "suite scenario preset tracker role renderer controller link metric unit better mean ci_low ci_high n"
    for entry in outcome[0].summary:
        assert list(entry) == names.split()


def test_each_is_compared_along_both_names(outcome: tuple[Outcome, Path]) -> None:
    comparisons = json.loads((outcome[1] / "comparisons.json").read_text())
    pairs = {(c["controller"], c["tracker"], c["compared"], c["other"]) for c in comparisons}
    assert pairs == {
        *(("fake_ours", tracker, "controller", other) for tracker in TRACKERS for other in ("hold", "centre")),
        *((controller, "fake_knowing", "tracker", "fake_still") for controller in CONTROLLERS),
    }


@pytest.mark.heavy
def test_a_stopped_run_goes_on_and_other_links_stand_beside(outcome: tuple[Outcome, Path], tmp_path: Path) -> None:
    run(replace(TINY, controllers=("hold",), trackers=TRACKERS[:1]), tmp_path)
    went_on = run(TINY, tmp_path)
    assert (went_on.resumed, went_on.episodes) == (2, 10)
    assert without_times(tmp_path) == without_times(outcome[1])
    noisy = replace(TINY, controllers=("hold",), trackers=TRACKERS[:1], link="noisy")
    assert run(noisy, tmp_path).episodes == 2
    assert run(noisy, tmp_path).episodes == 0
    assert {key.link for key in read_blocks(tmp_path)} == {"prompt", "noisy"}
    rows = [row for row in read_rows(tmp_path) if row["link"] == "noisy" and row["metric"] == "effort"]
    assert all(row["value"] > 0.01 for row in rows)


def test_estimates_on_late_pictures_are_judged_on_these_and_the_view_on_those_of_now(tmp_path: Path) -> None:
    late = replace(TINY, controllers=("centre",), trackers=("fake_knowing",), seeds=range(1))
    errors = [
        mean_of(run(replace(late, link=link), tmp_path / link), "centre", "fake_knowing", "centring_error")
        for link in ("prompt", "late")
    ]
    assert errors[0] < errors[1], "what is late is steered by late"
    still, out = replace(late, controllers=("hold",), link="late", keeper=Estimates()), tmp_path / "still"
    run(replace(still, trackers=("fake_knowing", "fake_raises")), out)
    found = {row["tracker"]: row["value"] for row in read_rows(out) if row["metric"] == "in_view_tpr"}
    assert found["fake_knowing"] > 0.9, "in three frames a car drives by its length"
    assert 0.0 < found["fake_raises"] < found["fake_knowing"]
    rows = without_times(out)
    (out / FILE_NAME).unlink()
    rejudge(out, None, 0, (), lambda done, of: None)
    assert without_times(out) == rows


@pytest.mark.heavy
def test_a_pair_with_a_blind_tracker_is_blind_whatever_steers(tmp_path: Path) -> None:
    pair = replace(TINY, controllers=("centre",), trackers=("fake_knowing", "blind_straight"), seeds=range(1))
    assert not run(pair, tmp_path).failures
    roles = {(row["tracker"], row["role"], row["tracker_role"]) for row in read_rows(tmp_path)}
    assert roles == {("fake_knowing", "baseline", "ours"), ("blind_straight", "blind", "blind")}
    page = write_report(tmp_path).read_text()
    competitors, references = page.split('<tbody class="apart">')[:2]
    assert "blind_straight" not in competitors
    assert "blind_straight" in references
    assert "Blind trackers get no picture" in references


@pytest.mark.heavy
def test_all_controllers_of_the_carrier_steer_by_default(tmp_path: Path) -> None:
    made = run(replace(TINY, controllers=None, trackers=TRACKERS[:1], seeds=range(1)), tmp_path)
    assert {row["controller"] for row in read_rows(tmp_path)} >= {"hold", "centre", "fake_ours", "fake_raises"}
    failures = {(f.tracker, f.frame, f.reason) for f in made.failures}
    assert ("fake_raises", 20, "RuntimeError: a bug") in failures
    assert "from there on it has commanded nothing" in str(made.failures[0])
    (row,) = (
        row
        for row in read_rows(tmp_path)
        if (row["metric"], row["controller"]) == ("controller_failed_at_frame", "fake_raises")
    )
    assert row["value"] == 20.0
    assert "fake_raises, seed 0: failed at frame 20; no command from there on" in write_report(tmp_path).read_text()


def made_up(controller: str, tracker: str, seed: int, time_in_view: float) -> list[dict[str, Any]]:
    """Return the rows of one pair in one episode."""
    heading = {
        "suite": "follow",
        "scenario": "fake-town-v1",
        "preset": "tiny",
        "tracker": tracker,
        "role": {"fake_ours": "ours", "policy:mine": "policy"}.get(controller, "baseline"),
        "controller": controller,
        "renderer": "raster",
        "seed": seed,
        "tracker_role": "ours" if tracker == "fake_knowing" else "baseline",
        "link": "prompt",
        "repeat": 0,
    }
    ending = {"weight": 100.0, "event": None, "seconds": 1.0, "editions": {}}
    values = {"time_in_view": time_in_view, "frames": 101.0}
    return [{**heading, "metric": metric, "value": value, **ending} for metric, value in values.items()]


@pytest.mark.heavy
def test_paired_differences_are_right_on_made_up_rows(tmp_path: Path) -> None:
    """Episodes differ more than trackers do: unpaired, no difference would be significant."""
    better_by = {"hold": 0.0, "centre": 0.1, "fake_ours": 0.15, "policy:mine": 0.2}
    for seed in range(12):
        for controller, better in better_by.items():
            for tracker, worse in (("fake_knowing", 0.0), ("fake_still", 0.05)):
                append_block(tmp_path, made_up(controller, tracker, seed, 0.06 * seed + better - worse))
    write_summary(tmp_path)
    found = json.loads((tmp_path / "comparisons.json").read_text())
    assert {entry["metric"] for entry in found} == {"time_in_view"}
    for entry in found:
        if entry["compared"] == "tracker":
            assert (entry["tracker"], entry["other"]) == ("fake_knowing", "fake_still")
            expected = 0.05
        else:
            assert entry["controller"] in ("fake_ours", "policy:mine")
            expected = better_by[entry["controller"]] - better_by[entry["other"]]
        assert entry["difference"] == pytest.approx(expected, abs=1e-6)
        assert (entry["ci_low"], entry["ci_high"]) == pytest.approx((expected, expected), abs=1e-6)
        assert entry["p_holm"] < 0.05
    assert len(found) == 2 * 2 * 3 + 4
    page = re.sub(r"<[^>]+>", " ", write_report(tmp_path).read_text())
    assert "policy:mine + fake_still minus each other controller" in page
    assert "fake_knowing + hold minus each other tracker" in page


def test_the_page_shows_controllers_and_trackers(outcome: tuple[Outcome, Path]) -> None:
    page = write_report(outcome[1]).read_text()
    text = re.sub(r"<[^>]+>", " ", page)
    assert f"<h1>{showing_of(FOLLOW).heading}</h1>" in page
    for words in ("How long is the target seen?", *TRACKERS):
        assert words in text
    assert "fake_ours + fake_knowing minus each other controller, on the same seeds" in text
    assert "--link prompt --controllers" in text
    assert page.count('<th scope="col" class="kind">controller</th><th scope="col" class="kind">tracker</th>') == 2
    # Each tracker had its own episodes: losses are those of all.
    losses = sum(row["metric"] == "watched_frames" for row in read_rows(outcome[1]))
    assert f"{losses} losses of " in text
    assert write_report(outcome[1]).read_text() == page


@pytest.mark.heavy
def test_the_command_line_runs_resumes_prints_and_compares(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "follow", "--quick", "--workers", "0", "--seeds", "0:1", "--out", str(tmp_path)]
    words += ["--controllers", "hold", "centre", "--trackers", "fake_knowing", "fake_still"]
    assert main(words) == 0
    out, _ = capsys.readouterr()
    lines = [line.split()[:3] for line in out.splitlines() if "fake_" in line]
    assert lines[0] == ["centre", "fake_knowing", "baseline"]
    assert "fake-town-v1, tiny, raster, prompt link: 1 episode, too few for intervals" in out
    assert main([*words, "--json"]) == 0
    assert {e["controller"] for e in json.loads(capsys.readouterr().out)["summary"]} == {"hold", "centre"}
    assert main(["report", str(tmp_path), "--markdown"]) == 0
    assert "| `centre`" in capsys.readouterr().out
    pair = ["compare", "centre+fake_knowing", f"{tmp_path}:hold+fake_knowing", "--directory", str(tmp_path)]
    assert main([*pair, "--json"]) == 0
    found = {(e["events"], e["metric"]): e["difference"] for e in json.loads(capsys.readouterr().out)}
    assert found["whole episodes", "time_in_view"] > 0.5
    assert main(["compare", "centre", "hold", "--directory", str(tmp_path)]) == 2
    assert "expected one of centre+fake_knowing, centre+fake_still" in capsys.readouterr().err


@pytest.mark.heavy
def test_results_over_two_links_are_not_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = replace(TINY, controllers=("hold",), trackers=TRACKERS[:1], seeds=range(1))
    for link in ("prompt", "noisy"):
        run(replace(one, link=link), tmp_path)
    pair = "hold+fake_knowing"
    assert main(["compare", pair, pair, "--directory", str(tmp_path)]) == 2
    assert "error: directory: expected results of one link, got noisy, prompt" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--controllers", "nix"], "controllers: expected one of .*hold.*; got 'nix'"),
        (["--controllers", "set-path"], "controllers: expected one of .*hold.*; got 'set-path'"),
        (["--controllers", "policy:nix"], "policy: expected a file that can be read, got 'nix', whose JSON"),
        (["--trackers", "stereo_people"], "trackers: expected one of .*; got 'stereo_people'"),
        (["--link", "nix"], "link: expected one of prompt, delayed, noisy, late; got 'nix'"),
        (["--scenario", "stereo-follow"], "scenario: expected one of fake-town-v1; got 'stereo-follow-v2'"),
        (["--preset", "nix"], "preset: expected one of tiny, tiny-loop.*; got 'nix'"),
    ],
)
def test_what_is_wrong_is_reported_in_one_line(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "follow", "--workers", "0", "--seeds", "0:1", "--out", str(tmp_path / "out"), *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = (line for line in err.splitlines() if not line.startswith("compiling kernels"))
    assert re.fullmatch(f"error: {message}.*", line), line
    assert not (tmp_path / "out").exists()
