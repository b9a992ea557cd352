"""The suite ``harbour`` from the command line: an episode, its report and its video."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.cli.main import main
from benchmarks.contract.judging import Ending
from benchmarks.contract.suite import suite
from benchmarks.judges.harbour.judge import HarbourJudge
from benchmarks.judges.harbour.sizes import MEAN_SIZE_M
from scenarios.harbour.conditions import draw_conditions
from scenarios.harbour.intruders import Intruders
from scenarios.harbour.plan import draw_plan
from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenario import HARBOUR
from sim.optics import project
from sim.rng import episode_seed, generator
from sim.world import World
from trackers.types import Estimate, Track

FAKES = "tests.benchmarks.judges.harbour.fake_watchers"


@pytest.fixture(scope="module", autouse=True)
def preset() -> Iterator[None]:
    """A preset with few pictures without intruders, which cost more than all others."""
    HARBOUR.presets["brief"] = replace(HARBOUR.presets["quick"], background=3)
    yield
    del HARBOUR.presets["brief"]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("harbour")
    words = ["--modules", FAKES, "--trackers", "fake_stares", "--preset", "brief", "--seeds", "0:1"]
    assert main(["bench", "harbour", *words, "--out", str(folder), "--workers", "0"]) == 0
    return folder


def rows_of(out: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (out / "records.jsonl").read_text().splitlines()]


@pytest.mark.heavy
def test_rows_are_those_of_metrics(out: Path) -> None:
    needed = {each.name for metric in suite("harbour").metrics for each in metric.statistic.of}
    drawn = {"region_depth_m", "region_width_m", "region_height_m", "found_unseen", "frames"}
    assert {row["metric"] for row in rows_of(out)} <= needed | drawn


def test_a_tracker_is_judged_at_its_own_threshold_and_at_all(out: Path) -> None:
    told = {row["metric"]: row["value"] for row in rows_of(out) if row["event"] is None}
    assert told["false_alarms_per_hour"] * told["watched_hours"] == pytest.approx(1.0)
    assert (told["froc_alarms"][0], told["froc_alarms"][-1]) == (2.0, 0.0)


def test_the_report_has_its_figures_and_one_visit(out: Path) -> None:
    page = (out / "report.html").read_text()
    for words in ("How many false alarms does a find cost?", "What contrast does it take?"):
        assert words in page, words
    (picture,) = (out / "pictures").glob("*.jpg")
    sheet = cv2.imread(str(picture))
    assert sheet is not None
    height, width = sheet.shape[:2]
    assert width > 2 * height


def test_a_video_is_drawn(tmp_path: Path) -> None:
    file = tmp_path / "x.mp4"
    words = ["--modules", FAKES, "--preset", "brief", "--seed", "0", "--frames", "5"]
    assert main(["render", "harbour", *words, "--out", str(file)]) == 0
    video = cv2.VideoCapture(str(file))
    shapes = {frame.shape for _ in range(5) for read, frame in [video.read()] if read}
    assert len(shapes) == 1
    height, width = shapes.pop()[:2]
    assert width > 960 + 200
    assert height > 720


@pytest.mark.heavy
def test_the_mean_sizes_are_the_scene_s() -> None:
    standard = PRESETS["standard"]
    found: dict[str, list[NDArray[np.float64]]] = {kind: [] for kind in MEAN_SIZE_M}
    for index in range(40):
        seed, world = episode_seed(index, HARBOUR.id, 0), World()
        plan = draw_plan(standard, generator(seed, "plan"))
        conditions = draw_conditions(standard, generator(seed, "conditions"))
        coming = Intruders(world, plan, conditions, np.zeros(1), generator(seed, "looks"))
        for kind, size_m in zip(coming.kinds, coming.size_m, strict=True):
            found[kind].append(size_m)
    for kind, mean_m in MEAN_SIZE_M.items():
        np.testing.assert_allclose(np.mean(found[kind], axis=0), mean_m, atol=0.006)


def test_truth_itself_is_perfect() -> None:
    episode = HARBOUR.episode("quick", 1)
    judge = HarbourJudge(episode, HARBOUR)
    sheet = judge.sheet()
    for _ in range(episode.frame_count):
        frame = episode.step()
        judge.see(frame, None)
        truth = frame.truth
        centre_m = truth.T_world_object[:, :3, 3] + 0.5 * truth.size_m[:, 2:] * truth.T_world_object[:, :3, 2]
        depth_m = project(frame.camera, truth.T_world_camera, centre_m)[1]
        here = np.flatnonzero(truth.state != "absent")
        estimates = {k: Estimate(truth.position_px[k], truth.box_xyxy[k], depth_m=float(depth_m[k])) for k in here}
        sheet.keep(frame, [Track(int(k), estimates[k], truth.kinds[k], truth.size_m[k]) for k in here])
    episode.close()
    scores = list(sheet.scores(Ending()))
    told = {score.metric: score.value for score in scores if score.event is None}
    assert (told["false_tracks_per_frame"], told["identity_switches"]) == (0.0, 0.0)
    assert told["hota"] == pytest.approx(1.0)
    assert told["boxes_right"][-1] == told["boxes_told"][-1] == told["boxes_true"] > 0
    assert told["gospa_m"] == pytest.approx(0.0, abs=1e-6)
    of_visits = [score for score in scores if score.event is not None]
    assert {score.value for score in of_visits if score.metric in ("found", "found_as_in_paper", "kind_right")} == {1.0}
    assert {score.value for score in of_visits if score.metric == "duplicate_rate"} == {0.0}
    errors = [
        score.value for score in of_visits if score.metric.endswith(("error", "error_m")) or "beyond" in score.metric
    ]
    assert np.abs(np.array(errors, float)).max() < 1e-6
