"""A scene of many targets, thermal pictures and a camera at rest goes through every command, from its folder alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import av
import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.contract.suite import Scene, add_scene, suite
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.editions import own_code
from benchmarks.run.episodes import editions_of, simulated
from benchmarks.run.jobs import opened
from benchmarks.run.selection import job_on, tracker_named
from benchmarks.show.replay import replay
from benchmarks.show.showing import suite_watching
from scenarios import catalog
from scenarios.loop import Loop
from scenarios.truth import check_truth
from tests.toy_scene import register
from tests.toy_scene.scenario import TOY_YARD, YardEpisode
from trackers.belief.features import FEATURES
from trackers.types import CameraCommand

ROOT = Path(__file__).parents[2]
MODULES = ("--modules", register.__name__)
ENV = "frameout/ToyYard-v1"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run of the suite ``toy-many`` in this process."""
    out = tmp_path_factory.mktemp("many")
    assert bench("toy-many", out, "--workers", "0") == 0
    return out


def bench(name: str, out: Path, *more: str) -> int:
    return main(["bench", name, *MODULES, "--preset", "quick", "--seeds", "0:2", "--out", str(out), *more])


def rows_of(directory: Path) -> list[dict[str, Any]]:
    rows = [row for row in read_rows(directory) if row["metric"] not in TIMES]
    for row in rows:
        del row["seconds"]
    return rows


def mean_of(directory: Path, metric: str, **names: str) -> float:
    (found,) = [
        each
        for each in json.loads((directory / "summary.json").read_text())
        if each["metric"] == metric and names.items() <= each.items()
    ]
    return float(found["mean"])


# Through every command ------------------------------------------------------------------------------------------------


def test_bench_ranks_trackers_of_many(results: Path) -> None:
    assert mean_of(results, "found_rate", tracker="warm_bodies") > 0.8
    assert mean_of(results, "position_error_px", tracker="warm_bodies") < 2.0
    switches = [mean_of(results, "identity_switches", tracker=f"warm_bodies{x}") for x in ("", "_no_motion")]
    assert switches[0] < switches[1]
    (row, *_) = rows_of(results)
    assert {"scene", "judge", "tracker"} <= row["editions"].keys()
    assert (row["suite"], row["scenario"]) == ("toy-many", "toy-yard-v1")


@pytest.mark.heavy
def test_rows_are_the_same_bytes_whatever_the_workers(results: Path, tmp_path: Path) -> None:
    """Workers import the modules themselves."""
    command = ["bench", "toy-many", *MODULES, "--preset", "quick", "--seeds", "0:2", "--out", str(tmp_path)]
    shell = [sys.executable, "-m", "benchmarks.cli.main", *command, "--workers", "2"]
    done = subprocess.run(
        shell, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    # Other tests of this process may have registered trackers of many.
    ours = [row for row in rows_of(results) if row["tracker"].startswith("warm_bodies")]
    assert json.dumps(ours) == json.dumps(rows_of(tmp_path))


def test_editions_hold_the_content_of_a_scene_a_judge_and_a_tracker_of_other_packages() -> None:
    made = editions_of(suite("toy-many"), simulated("toy-yard", "quick", 0), tracker_named("warm_bodies"))
    for part in ("scene", "judge", "tracker"):
        module = "scenario" if part == "scene" else part
        assert made[part].endswith(f" {own_code(f'tests.toy_scene.{module}')}")


@pytest.mark.heavy
def test_compare_report_and_list_take_the_modules_too(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pair = ("warm_bodies", "warm_bodies_no_motion")
    assert main(["compare", *pair, "--directory", str(results), "--json", *MODULES]) == 0
    compared = json.loads(capsys.readouterr().out)
    assert {(each["events"], each["metric"]) for each in compared} == {
        ("whole episodes", "found_rate"),
        ("whole episodes", "identity_switches"),
        ("crates", "crate_found_rate"),
    }
    (results / "report.html").unlink()
    assert main(["report", str(results), *MODULES, "--markdown"]) == 0
    assert "`warm_bodies`" in capsys.readouterr().out
    page = (results / "report.html").read_text()
    assert "How many are found?" in page
    assert "warm_bodies_no_motion" in page
    assert main(["list", *MODULES, "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert "toy-yard-v1" in [each["scenario"] for each in listed["scenarios"]]
    assert {"hold", "centre"} <= {each["name"] for each in listed["controllers"] if each["carrier"] == "yard-head"}
    assert main(["list", *MODULES, "--reference"]) == 0
    assert "crate_found_rate" in capsys.readouterr().out


def test_render_draws_all_tracks_on_a_set_path_and_one_in_closed_loop(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = {"many": (), "steered": ("--controller", "centre")}
    for name, more in shown.items():
        out = tmp_path / f"{name}.mp4"
        words = ["render", "toy-yard", "--preset", "quick", "--tracker", "warm_bodies", "--frames", "4"]
        assert main([*words, "--out", str(out), *more, *MODULES]) == 0
        assert "toy-yard-v1-quick-0, frames: 4 of 4" in capsys.readouterr().err
        with av.open(str(out)) as video:
            assert sum(1 for _ in video.decode(video=0)) == 4


def test_follow_judges_the_steered_camera(tmp_path: Path) -> None:
    assert bench("follow", tmp_path, "--scenario", "toy-yard", "--workers", "0") == 0
    shares = {name: mean_of(tmp_path, "centring_error", controller=name) for name in ("centre", "hold")}
    assert shares["centre"] < 0.5 * shares["hold"]
    assert mean_of(tmp_path, "effort", controller="hold") == 0.0
    assert mean_of(tmp_path, "time_seen", controller="centre") > 0.9


# The env --------------------------------------------------------------------------------------------------------------


def test_the_env_is_gymnasiums_and_its_features_are_of_the_steered_camera() -> None:
    env = gym.make(ENV, disable_env_checker=True)
    check_env(env.unwrapped, skip_render_check=True)
    observed, info = env.reset(seed=3, options={"preset": "quick", "episode_seed": 1})
    assert env.action_space.shape == (3,)
    for _ in range(19):
        observed, reward, _, truncated, info = env.step(env.action_space.sample())
        assert observed.shape == (len(FEATURES),)
        assert np.isfinite(observed).all()
        assert np.isfinite(reward)
        frame = env.unwrapped.episode.frame
        assert frame.steered is not None
        target = frame.truth.index_of(TOY_YARD.target)
        np.testing.assert_array_equal(info["box_xyxy"], frame.steered.box_xyxy[target])
        np.testing.assert_array_equal(info["T_world_camera"], frame.steered.T_world_camera)
        assert info["reward_in_view"] == float(info["in_view"])
    assert truncated
    env.close()


def test_pictures_of_one_band_are_observed_too() -> None:
    env = gym.make(ENV, observation="both", action="correction", controller="centre", render_mode="rgb_array")
    observed, _ = env.reset(seed=0)
    assert observed["pixels"].shape == (72, 96, 3)
    env.step(np.zeros(3))
    assert env.render().ndim == 3
    env.close()


# The scene's contracts ------------------------------------------------------------------------------------------------


def test_both_cameras_have_whole_truth_and_pictures_are_of_their_band() -> None:
    episode, again = (TOY_YARD.episode("quick", 1, closed_loop=True) for _ in range(2))
    frames, others = (
        [each.step(CameraCommand() if k else None) for k in range(each.frame_count)] for each in (episode, again)
    )
    for frame, other in zip(frames, others, strict=True):
        check_truth(frame.truth)
        assert frame.steered is not None
        check_truth(frame.steered)
        seen, counts = frame.observation, frame.observation.counts
        assert seen.camera.band == "thermal"
        assert counts is not None
        assert counts.max() < 1 << 14
        assert (seen.image_rgb == seen.image_rgb[..., :1]).all()
        assert other.observation.counts is not None
        assert counts.tobytes() == other.observation.counts.tobytes()
        assert frame.steered.box_xyxy.tobytes() == other.steered.box_xyxy.tobytes()  # type: ignore[union-attr]
    again.close()
    assert len(episode.start.background) > 0
    assert episode.start.box_xyxy is not None
    np.testing.assert_array_equal(frames[0].truth.box_xyxy[0], episode.start.box_xyxy)
    empty = episode.start.background[0].counts
    assert empty is not None
    assert empty.max() < frames[0].observation.counts.max()  # type: ignore[union-attr]


def test_truth_of_the_target_alone_leaves_pictures_as_they_are(episode: YardEpisode) -> None:
    short = TOY_YARD.episode("quick", 1, truth="target")
    for whole, part in zip(Loop(episode).frames(), Loop(short).frames(), strict=True):
        assert whole.observation.image_rgb.tobytes() == part.observation.image_rgb.tobytes()
        assert np.isnan(part.truth.visible_fraction[1:]).all()
    short.close()


def test_a_scene_is_added_to_a_suite_once() -> None:
    assert suite("follow").is_about("toy-yard-v1")
    assert suite("follow").tracked_by(suite("follow").scene("toy-yard-v1")) == "toy-many"
    with pytest.raises(ValueError, match="scene: expected a scenario that the suite does not have, got 'toy-yard'"):
        add_scene("follow", Scene("toy-yard"))
    assert catalog.scenario("toy-yard") is TOY_YARD


def test_what_is_shown_without_a_controller_fits_the_tracker() -> None:
    assert suite_watching("toy-yard-v1", "warm_bodies").name == "toy-many"
    assert suite_watching("toy-yard-v1", None).name == "toy-many"
    assert suite_watching("toy-yard-v1", "colour_pf").name == "follow"
    assert suite_watching("road-town-v2", "colour_pf").name == "frame-out"


def test_replayed_instants_hold_every_track_and_target() -> None:
    job = job_on("toy-many", "toy-yard", "quick", 1, ("warm_bodies",))
    with opened(job) as live:
        instants = list(replay(live, scale=1.0, wanted=range(5), frame_count=5))
    assert [len(each.targets) for each in instants] == [2] * 5
    assert [[identity for identity, _ in each.estimates] for each in instants] == [["0", "1"]] * 5
