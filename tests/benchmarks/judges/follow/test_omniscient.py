"""The omniscient controller keeps in view what others lose: the twin that it plans with is the rendered carrier."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from benchmarks.judges.follow.omniscient import OmniscientHead, OmniscientHeadParameters, OmniscientParameters
from benchmarks.judges.follow.planning import Planner
from benchmarks.judges.follow.references import TrueTarget
from benchmarks.run.jobs import run_job
from benchmarks.run.selection import job_on
from scenarios import catalog
from scenarios.command_link import LINKS, Link, episode_link
from scenarios.envs.actions import action_count
from scenarios.envs.settings import FollowSettings
from scenarios.loop import Loop
from scenarios.visibility import MOSTLY_SEEN


def seen(scenario: str, seed: int, controller: str) -> float:
    """Return the share of the time in view of an episode with pictures, whose tracker tells the truth."""
    job = job_on("follow", scenario, "quick", seed, ("oracle_target",), controller=controller, link="prompt")
    [block] = run_job(job).blocks
    [value] = [row["value"] for row in block if row["metric"] == "time_in_view"]
    return float(value)


def test_it_never_loses_a_car_in_gusts() -> None:
    assert seen("road-town", 3, "omniscient") == 1.0 > seen("road-town", 3, "hold")


@pytest.mark.heavy
def test_it_never_loses_a_person() -> None:
    assert seen("stereo-follow", 3, "omniscient") == 1.0 > seen("stereo-follow", 3, "hold")


@pytest.mark.heavy
def test_it_looks_round_those_who_hide_a_person() -> None:
    """In an episode without pictures in which a plan that only centres the person sees him half of the time."""
    scene = catalog.scenario("stereo-follow")
    preset = scene.presets["standard"]
    planner, visible = Planner(OmniscientParameters(), scene.id, preset, 1002, LINKS["prompt"]), []
    for _ in range(preset.frame_count - 1):
        planner.command()
        visible.append(float(planner._twin["visible"][0]))
    assert np.mean(np.array(visible) >= MOSTLY_SEEN) > 0.85


def test_its_plans_are_worth_more_after_each_round() -> None:
    settings = OmniscientParameters(horizon_frames=12, plans=64, rounds=4)
    scene = catalog.scenario("road-town")
    planner = Planner(settings, scene.id, scene.presets["quick"], 3, LINKS["prompt"])
    planner.shares[:] = 0.5
    none = np.zeros((64, *planner.shares.shape))
    before = planner.worth(none + planner.shares, 12)[0]
    planner.improve()
    assert planner.worth(none + planner.shares, 12)[0] > before


def test_it_competes_by_default() -> None:
    """Without an import of its module by hand."""
    code = "from benchmarks.contract.suite import suite; from benchmarks.run.selection import choices; "
    code += "print([each.controllers for each in choices(suite('follow'), variants=False)])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.count("'omniscient'") == 4


def test_envs_and_other_suites_refuse_it() -> None:
    settings = FollowSettings("road-town-v2", "hold", action="correction", controller="omniscient")
    with pytest.raises(ValueError, match="controller: expected one that knows no more than a policy, got 'omniscient'"):
        action_count(settings, catalog.scenario("road-town").carrier)
    job = job_on("frame-out", "road-town", "quick", 3, ("hold",), controller="omniscient")
    assert "controllers: expected one that knows no more than a tracker" in run_job(job).failures[0].reason


@pytest.mark.parametrize("scenario", ["fish-tank-ptz", pytest.param("harbour-ptz", marks=pytest.mark.heavy)])
def test_it_never_loses_what_a_head_can_follow(scenario: str) -> None:
    assert seen(scenario, 3, "omniscient") == 1.0 > seen(scenario, 3, "hold")


@pytest.mark.parametrize("link", [Link(), Link(delay_frames=3), Link(noise=0.1), Link(delay_frames=3, noise=0.1)])
def test_the_twin_of_a_head_is_the_head(link: Link) -> None:
    """Unless noise turns the head, the target is in the middle, once the first commands have arrived."""
    scene, seed = catalog.scenario("fish-tank-ptz"), 4
    episode = scene.episode("quick", seed, closed_loop=True, truth="target")
    controller = OmniscientHead(OmniscientHeadParameters())
    controller.foresee(scene.id, scene.presets["quick"], seed, link)
    loop = Loop(episode, [TrueTarget(scene.target)], episode_link(scene.carrier, episode.rate_hz, link, seed))
    target = episode._objects.names.index(scene.target)
    off_px, twins, heads = [], [], []
    for frame in loop.frames(controller, 60):
        off_px.append(np.abs(frame.truth.position_px[target] - frame.camera.centre_px).max())
        twins.append(controller._twin._head.T_world_camera)
        heads.append(episode._head.T_world_camera)
    if link.noise == 0.0:
        assert np.median(off_px[20:]) < 3.0
    # The twin is ahead by the delay.
    ahead = link.delay_frames
    np.testing.assert_allclose(twins[: 60 - ahead], heads[ahead:], atol=1e-12)
    episode.close()


def test_a_scene_in_which_any_view_counts_is_refused() -> None:
    scene = catalog.scenario("fish-tank")
    with pytest.raises(ValueError, match="scenario: expected one whose tracker looks through a head that is steered"):
        OmniscientHead(OmniscientHeadParameters()).foresee(scene.id, scene.presets["quick"], 0, LINKS["prompt"])
