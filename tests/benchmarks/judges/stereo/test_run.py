"""The suite ``stereo`` from end to end on a drawn episode: run, resume, fail, report, compare, list."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.cli.main import main
from benchmarks.contract.judging import truth_as
from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import register_suite
from benchmarks.judges.stereo.metrics.people import WORST_ERROR_M
from benchmarks.judges.stereo.suite import STEREO
from benchmarks.run.outcome import Outcome
from benchmarks.show.page import write_report
from benchmarks.show.showing import showing_of
from scenarios.road_town.truth import RoadTruth
from tests.benchmarks.judges.follow import fake_follow
from tests.benchmarks.judges.follow.fake_follow import HIDDEN
from tests.benchmarks.named import NamedExperiment as Experiment
from tests.benchmarks.named import run_named as run

ALL_TRACKERS = ("follow_knowing", "follow_single", "follow_taken")
TINY = Experiment(
    suite="stereo",
    scenario=fake_follow.FAKE_FOLLOW.id,
    presets=("tiny",),
    trackers=ALL_TRACKERS,
    seeds=range(2),
    workers=0,
    modules=("tests.benchmarks.judges.follow.fake_follow",),
)
LIGHT_FRAMES, FRAMES = 30, 70


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> tuple[Outcome, Path]:
    out = tmp_path_factory.mktemp("stereo")
    return run(TINY, out), out


def mean_of(outcome: Outcome, tracker: str, metric: str) -> float:
    (mean,) = (e["mean"] for e in outcome.summary if e["tracker"] == tracker and e["metric"] == metric)
    return float(mean)


@pytest.mark.heavy
def test_who_knows_the_way_has_the_best_of_all_scores(outcome: tuple[Outcome, Path]) -> None:
    made, _ = outcome
    best = {
        "precision": 1.0,
        "recall": 1.0,
        "f_measure": 1.0,
        "detection_f1": 1.0,
        "wrong_person_rate": 0.0,
        "occlusion_recovery_rate": 1.0,
        "time_to_recover_s": 0.0,
        "f1_after_lamp_off": 1.0,
        "f1_after_back_light": 1.0,
        "f1_near_person": 1.0,
        "f1_no_near_person": 1.0,
        "wrong_after_light_rate": 0.0,
    }
    assert {metric: mean_of(made, "follow_knowing", metric) for metric in best} == pytest.approx(best)
    assert mean_of(made, "follow_knowing", "position_error_m") < 1e-6
    # There was none.
    assert not any(entry["metric"] in ("f1_after_doorway", "f1_after_shade") for entry in made.summary)


@pytest.mark.heavy
def test_whoever_goes_with_another_is_told_so(outcome: tuple[Outcome, Path]) -> None:
    made, _ = outcome
    right, wrong = HIDDEN[0] - 1, FRAMES - HIDDEN[-1] - 1
    assert mean_of(made, "follow_taken", "precision") == pytest.approx(right / (right + wrong), abs=1e-5)
    assert mean_of(made, "follow_taken", "recall") == 1.0
    # Also while the target is hidden.
    assert mean_of(made, "follow_taken", "wrong_person_rate") == pytest.approx(
        (FRAMES - HIDDEN[0]) / (FRAMES - 1), abs=1e-5
    )
    assert mean_of(made, "follow_taken", "occlusion_recovery_rate") == 0.0
    assert mean_of(made, "follow_taken", "wrong_after_occlusion_rate") == 1.0
    assert mean_of(made, "follow_taken", "wrong_after_light_rate") == 1.0


def test_a_tracker_without_depth_is_lent_what_its_pixel_shows(outcome: tuple[Outcome, Path]) -> None:
    """It points at the target; while it is hidden that pixel shows the crosser and gives their place."""
    made, out = outcome
    assert mean_of(made, "follow_single", "f_measure") == 1.0
    (series,) = {
        tuple(row["value"])
        for row in read_rows(out)
        if row["tracker"] == "follow_single" and row["metric"] == "outcome_by_frame"
    }
    assert [k for k, code in enumerate(series) if code != 1] == [0, *HIDDEN]
    assert 5 in [series[k] for k in HIDDEN]


def test_rows_have_the_keys_that_are_documented(outcome: tuple[Outcome, Path]) -> None:
    _, out = outcome
    keys = (
        "suite scenario preset tracker role controller renderer seed modules repeat metric value weight event seconds "
        "editions"
    )
    kinds = set()
    for row in read_rows(out):
        assert list(row) == keys.split()
        if row["event"] is not None:
            kinds.add(row["event"]["kind"])
            names = {"index", "kind", "first_frame", "length_frames", "back_frame", "place", "light"}
            assert set(row["event"]) == names
    assert kinds == {"occlusion", "lamp off", "back light", "near person", "nobody near"}


def test_ours_is_compared_in_what_the_suite_says(outcome: tuple[Outcome, Path]) -> None:
    _, out = outcome
    comparisons = json.loads((out / "comparisons.json").read_text())
    assert {(c["tracker"], c["other"]) for c in comparisons} == {("follow_knowing", name) for name in ALL_TRACKERS[1:]}
    assert {c["metric"] for c in comparisons} == set(STEREO.compared)


@pytest.mark.heavy
def test_who_fails_misses_the_target_from_there_on(tmp_path: Path) -> None:
    made = run(replace(TINY, trackers=("follow_raises", "follow_knowing"), seeds=range(1)), tmp_path)
    (failure,) = made.failures
    assert (failure.tracker, failure.frame, failure.reason) == ("follow_raises", 40, "RuntimeError: a bug")
    rows = {row["metric"]: row["value"] for row in read_rows(tmp_path) if row["tracker"] == "follow_raises"}
    assert rows["failed_at_frame"] == 40.0
    seen_before = 39 - len(HIDDEN)
    assert (rows["right_frames"], rows["wrong_frames"], rows["missed_frames"]) == (seen_before, 0.0, FRAMES - 40)
    assert rows["position_error_m"] == pytest.approx(WORST_ERROR_M * 30 / (seen_before + 30), rel=1e-4)
    assert mean_of(made, "follow_raises", "precision") == 1.0
    assert mean_of(made, "follow_knowing", "f_measure") == 1.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"trackers": ("follow_knowing", "hold")},
            r"trackers: expected one of .*follow_knowing.*; got 'hold', which is of suite frame-out",
        ),
        ({"suite": "frame-out"}, r"trackers: expected one of .*; got 'follow_knowing', which is of suite stereo"),
        ({"trackers": ("oracle_map",)}, "got 'oracle_map', which is of suite frame-out"),
    ],
)
def test_trackers_of_another_suite_are_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message) as told:
        run(replace(TINY, **change), tmp_path)
    expected = str(told.value).split("expected one of ")[1].split(";")[0].split(", ")
    assert ("hold" in expected) == (change.get("suite") == "frame-out")


def test_a_scenario_that_tells_another_truth_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match=r"truth: expected StereoTruth, .* got RoadTruth"):
        run(replace(TINY, scenario="fake-town", modules=("tests.fakes_scenario",)), tmp_path)
    with pytest.raises(TypeError, match="truth: expected RoadTruth"):
        truth_as(fake_follow.FAKE_FOLLOW.episode("tiny", 0).step().truth, RoadTruth)


@pytest.mark.heavy
def test_the_page_shows_what_the_suite_is_about(outcome: tuple[Outcome, Path]) -> None:
    _, out = outcome
    page = write_report(out).read_text()
    text = re.sub(r"<[^>]+>", " ", page)
    assert f"<h1>{showing_of(STEREO).heading}</h1>" in page
    assert "outside the picture" not in text
    for words in ("When is the person lost?", "How soon is the person found again?", "What does a better score cost?"):
        assert words in text
    assert "2 occlusions of 6 frames, 4 changes of light (2 × lamp off, 2 × back light)" in text
    for words in ("after lamp off", "near person", *ALL_TRACKERS):
        assert words in text
    # Its pictures are black: nothing is matched in them, in the hall or in the corridor.
    facts = text.split("Disparity matched from the pair")[1].split("Intervals:")[0]
    assert facts.split("all pixels")[1].split()[:4] == ["–", "–", "–", "0.0"]
    assert ["hall" in facts, "corridor" in facts, "yard" in facts] == [True, True, False]
    assert page.count("<svg") == 4
    assert write_report(out).read_text() == page


@pytest.mark.heavy
def test_both_suites_may_lie_on_one_page(outcome: tuple[Outcome, Path], tmp_path: Path) -> None:
    for suite, scenario, tracker, modules in (
        ("frame-out", "fake-town", "fake_still", ("tests.fakes_scenario",)),
        ("stereo", TINY.scenario, "follow_taken", TINY.modules),
    ):
        experiment = replace(TINY, suite=suite, scenario=scenario, trackers=(tracker,), modules=modules)
        run(experiment, tmp_path)
    page = write_report(tmp_path).read_text()
    assert "<h1>What happens outside the picture · Is it still the same person?</h1>" in page


@pytest.mark.heavy
def test_compare_divides_by_what_happened(outcome: tuple[Outcome, Path], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["compare", "follow_knowing", "follow_taken", "--directory", str(outcome[1])]
    assert main([*words, "--json"]) == 0
    found = {(e["events"], e["metric"]): e["difference"] for e in json.loads(capsys.readouterr().out)}
    assert found["occlusions", "recovered"] == 1.0
    assert found["2 s after lamp off", "detection_f1"] == 1.0
    assert found["2 s after any change of light", "wrong_person_rate"] == -1.0
    assert 0.0 < found["near person", "detection_f1"] < 1.0
    assert ("2 s after shade", "detection_f1") not in found
    assert main(words) == 0
    assert "2 s after back light" in capsys.readouterr().out


def test_trackers_of_two_suites_are_not_compared(outcome: tuple[Outcome, Path], tmp_path: Path) -> None:
    town = replace(TINY, suite="frame-out", scenario="fake-town", modules=("tests.fakes_scenario",))
    run(replace(town, trackers=("fake_still",), seeds=range(1)), tmp_path)
    names = [f"{outcome[1]}:follow_taken", f"{tmp_path}:fake_still"]
    assert main(["compare", *names]) == 2


def test_list_tells_the_suites_of_each_tracker(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "--json"]) == 0
    trackers = {each["name"]: each["suites"] for each in json.loads(capsys.readouterr().out)["trackers"]}
    assert trackers["opencv_mil"] == ["frame-out", "stereo"]
    assert trackers["oracle_driver"] == trackers["colour_pf"] == ["frame-out"]


def test_a_suites_name_is_taken_once() -> None:
    with pytest.raises(ValueError, match="suite: expected a new name, got 'stereo', which is taken"):
        register_suite(STEREO)
