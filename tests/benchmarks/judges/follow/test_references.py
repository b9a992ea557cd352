"""The oracle of suite follow answers the truth, and a pair with it is an oracle whatever its controller."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.judges.follow.references import ORACLE, TrueTarget
from benchmarks.run.episodes import simulated
from benchmarks.run.jobs import heading_of
from benchmarks.run.selection import job_on
from scenarios import catalog
from scenarios.fish_tank.tank import VOLUME_M
from scenarios.loop import Loop
from scenarios.scenario import Frame
from trackers.estimate_check import check_estimate
from trackers.types import CameraModel, Estimate


@pytest.mark.heavy
def test_it_answers_the_true_position_and_distance_also_outside_the_picture() -> None:
    named = simulated("road-town", "quick", 3)
    with closing(named.open("all")) as episode:
        loop = Loop(episode, [ORACLE.create(named, episode, np.random.default_rng(0))])
        for frame in loop.frames():
            truth, answer = frame.truth, loop.answers[0]
            target = truth.index_of("target")
            assert isinstance(answer, Estimate)
            if truth.frame > 0:
                assert answer.position_px == pytest.approx(truth.position_px[target])
                assert answer.in_view_probability == (truth.state[target] in ("in", "partial"))
                camera: CameraModel = frame.camera
                ray = np.append((answer.position_px - camera.centre_px) / camera.focal_px, 1.0)
                middle_m = (truth.T_world_camera @ np.append(ray * answer.depth_m, 1.0))[:3]
                assert middle_m[:2] == pytest.approx(truth.T_world_object[target, :2, 3], abs=1e-6)
            if truth.state[target] == "out":
                break
        else:
            pytest.fail("the car never left the picture")


def second_frame(name: str, preset: str) -> tuple[Frame, Estimate]:
    """Return the frame after the start of an episode, and what the oracle answers there."""
    named = simulated(name, preset, 3)
    with closing(named.open("all")) as episode:
        loop = Loop(episode, [ORACLE.create(named, episode, np.random.default_rng(0))])
        frames = loop.frames()
        next(frames)
        frame, answer = next(frames), loop.answers[0]
    assert isinstance(answer, Estimate)
    assert answer.depth_m is not None
    assert (answer.position_px == frame.truth.position_px[frame.truth.index_of(named.scenario.target)]).all()
    return frame, answer


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "preset"), [("stereo-follow", "quick"), ("harbour", "patrol")])
def test_pixel_and_distance_are_of_the_middle_of_a_person(name: str, preset: str) -> None:
    frame, answer = second_frame(name, preset)
    truth = frame.truth
    target = truth.index_of(catalog.scenario(name).target)
    pose, camera = truth.T_world_object[target], frame.camera
    ray = np.append((answer.position_px - camera.centre_px) / camera.focal_px, 1.0)
    answered_m = np.linalg.inv(pose) @ truth.T_world_camera @ np.append(ray * answer.depth_m, 1.0)
    assert answered_m[:3] == pytest.approx([0.0, 0.0, 0.5 * truth.size_m[target, 2]], abs=1e-6)


def test_the_distance_of_a_fish_is_that_of_the_middle_of_its_body() -> None:
    """Water bends the ray of its pixel, so its depth below the surface is compared."""
    frame, answer = second_frame("fish-tank", "quick")
    truth = frame.truth
    target = truth.index_of(catalog.scenario("fish-tank").target)
    place_m = truth.T_world_object[target, :3, 3].copy()
    foot_z_m, place_m[2] = place_m[2], VOLUME_M[2] - truth.below_surface_m[target]
    assert place_m[2] - foot_z_m > 1e-3
    assert answer.depth_m == pytest.approx(
        (place_m - truth.T_world_camera[:3, 3]) @ truth.T_world_camera[:3, 2], abs=1e-4
    )


@pytest.mark.heavy
def test_a_car_that_is_partly_behind_the_camera_is_answered_without_a_box() -> None:
    """As where the camera never moves: the box of truth is NaN, its centre is not."""
    frame, _ = second_frame("road-town", "quick")
    box_xyxy = frame.truth.box_xyxy.copy()
    box_xyxy[frame.truth.index_of("target")] = np.nan
    answer = TrueTarget("target").update(replace(frame, truth=replace(frame.truth, box_xyxy=box_xyxy)))
    check_estimate(answer)
    assert answer.box_xyxy is None
    assert answer.depth_m is not None


@pytest.mark.parametrize(("tracker_role", "role"), [("oracle", "oracle"), ("blind", "blind"), ("ours", "baseline")])
def test_a_pair_with_unfair_knowledge_is_not_ranked(tracker_role: str, role: str) -> None:
    job = job_on("follow", "road-town", "quick", 0, ("oracle_target",), controller="centre")
    pair = replace(job, trackers={"oracle_target": replace(job.trackers["oracle_target"], role=tracker_role)})
    assert heading_of(pair, "oracle_target")["role"] == role
