"""The example of CONTRIBUTING is a sound scene: its truth holds, it repeats to the byte, its suite needs no events."""

from __future__ import annotations

import importlib
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import pytest
from gymnasium.utils.env_checker import check_env

from benchmarks.cli.main import main
from benchmarks.contract import suite as registry
from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import Scene, add_metric, add_scene, register_suite, suite
from scenarios import catalog, objects
from scenarios.loop import Loop
from scenarios.truth import check_truth

MODULE = "tests.plain_scene.belt"
MODULES = ("--modules", MODULE, "--preset", "quick", "--seeds", "0:1")


@pytest.fixture(scope="module", autouse=True)
def belt() -> Any:
    """Return the scene's module. Imported here, it is not yet registered when tests of all scenes are collected."""
    return importlib.import_module(MODULE)


@pytest.fixture(autouse=True)
def own_registry(belt: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_SUITES", dict(registry.suites()))


def test_the_target_leaves_and_comes_back_and_repeats_to_the_byte(belt: Any) -> None:
    runs = []
    for _ in range(2):
        episode = belt.CONVEYOR.episode("quick", 3)
        runs.append(list(Loop(episode).frames()))
        episode.close()
    for frame, again in zip(*runs, strict=True):
        check_truth(frame.truth)
        assert frame.observation.image_rgb.tobytes() == again.observation.image_rgb.tobytes()
    states = [str(frame.truth.state[0]) for frame in runs[0]]
    assert states[0] == states[-1] == "in"
    assert states.count("out") > 5


def test_trackers_of_a_suite_without_events_are_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "belt", *MODULES, "--workers", "0", "--out", str(tmp_path)]) == 0
    assert re.search(r"outside\s+error\s.*\(px\)", capsys.readouterr().out, re.DOTALL)
    assert main(["compare", "hold", "colour_pf", "--modules", MODULE, "--directory", str(tmp_path)]) == 0
    assert "outside_error_px" in capsys.readouterr().out


def test_frame_out_judges_a_scene_without_roads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    add_scene("frame-out", Scene("conveyor", trackers=("hold", "hold_ground")))
    words = ("bench", "frame-out", "--scenario", "conveyor", *MODULES, "--workers", "0", "--out", str(tmp_path))
    assert main([*words]) == 0
    rows = read_rows(tmp_path)
    frame_outs = [row["frame_out"] for row in rows if row["metric"] == "reentry_error_m"]
    assert {(each["kind"], each["side"], each["turned"]) for each in frame_outs} == {("outside", "right", None)}
    assert "frame-out of 10 frames" in (tmp_path / "report.html").read_text()


def test_a_camera_at_rest_has_an_env_with_nothing_to_command_and_no_controllers_to_compare(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    env = gym.make("frameout/Conveyor-v1", preset="quick")
    check_env(env.unwrapped, skip_render_check=True)
    assert env.action_space.shape == (0,)
    assert env.reset(seed=0)[1]["run_m"] == 0.0
    env.close()
    add_scene("follow", Scene("conveyor", trackers_of="frame-out"))
    assert main(["bench", "follow", "--scenario", "conveyor", *MODULES, "--out", str(tmp_path)]) == 2
    expected = "scenario: expected one with a camera that can be steered, got 'conveyor-v1'"
    assert expected in capsys.readouterr().err


def test_a_truth_that_is_not_what_it_says_ends_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(objects, "visible_fraction", lambda *seen: 3.0)
    assert main(["bench", "belt", *MODULES, "--workers", "0", "--out", str(tmp_path)]) == 2
    assert "visible_fraction: expected numbers from 0 to 1, got 3 to 3" in capsys.readouterr().err


def test_names_that_do_not_fit_are_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    for field in ("headline", "compared"):
        with pytest.raises(ValueError, match=f"{field}: expected one of outside_error_px; got 'found'"):
            register_suite(replace(suite("belt"), name="odd", **{field: ("found",)}))
    with pytest.raises(ValueError, match=r"headline: expected names of metrics, .*, got 'outside_error_px'"):
        register_suite(replace(suite("belt"), name="odd", headline="outside_error_px"))
    metric = suite("belt").metrics[0]
    with pytest.raises(ValueError, match=r"metrics: expected each name once, got 'outside_error_px' twice"):
        register_suite(replace(suite("belt"), name="odd", metrics=(metric, metric)))
    for wrong in (replace(metric, better="smaller"), replace(metric, statistic="mode")):
        with pytest.raises(
            ValueError, match=r"(better|statistic) of metric outside_error_px: expected (one of|a Statistic)"
        ):
            register_suite(replace(suite("belt"), name="odd", metrics=(wrong,)))
        with pytest.raises(ValueError, match=r"(better|statistic) of metric new: expected (one of|a Statistic)"):
            add_metric("belt", replace(wrong, name="new"))
    monkeypatch.setattr(catalog, "_ENTRIES", (catalog.Entry("other-v1", f"{MODULE}:CONVEYOR"),))
    with pytest.raises(ValueError, match=r"CONVEYOR to have its entry's id 'other-v1', got 'conveyor-v1'"):
        catalog.scenario("other")
