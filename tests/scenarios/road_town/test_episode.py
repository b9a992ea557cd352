"""Every preset: byte-identical repeats; truth agrees with itself and with the picture; bad input is refused by name."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import gymnasium
import numpy as np
import pytest

from benchmarks.data.sets.request import Request
from benchmarks.learning.settings import Training
from scenarios.catalog import SUCCESSORS, envs, names, scenario
from scenarios.envs.follow_env import FollowEnv
from scenarios.road_town.pilot import OUT, picture_states
from scenarios.road_town.plan import TARGET
from scenarios.road_town.presets import PRESETS, FrameOuts, RoadTown
from scenarios.road_town.town import forget_town
from sim.optics import project
from trackers.types import CameraCommand, Observation

ROAD_TOWN = scenario("road-town")


def _frames(preset: str, seed: int, count: int, **options):
    episode = ROAD_TOWN.episode(preset, seed, **options)
    frames = []
    for k in range(count):
        command = CameraCommand(forward_mps=3.0, yaw_rate_rad_s=0.1) if episode.closed_loop and k else None
        frames.append(episode.step(command))
    return episode, frames


def _flat(value) -> list[np.ndarray]:
    if dataclasses.is_dataclass(value):
        return [leaf for field in dataclasses.fields(value) for leaf in _flat(getattr(value, field.name))]
    return [np.asarray(value)]


@pytest.mark.heavy
@pytest.mark.parametrize("preset", PRESETS)
def test_same_seed_same_bytes(preset):
    first = _frames(preset, 0, 4)
    # One town is drawn anew, one taken from memory.
    kept = _frames(preset, 0, 4)
    forget_town()
    second = _frames(preset, 0, 4)
    for a, b, c in zip(first[1], kept[1], second[1], strict=True):
        for x, y, z in zip(_flat(a), _flat(b), _flat(c), strict=True):
            np.testing.assert_array_equal(x, y)
            np.testing.assert_array_equal(x, z)
    for episode, _ in (first, kept, second):
        episode.close()


@pytest.mark.heavy
def test_another_seed_is_another_picture():
    episodes = [_frames("quick", seed, 1) for seed in (0, 1)]
    one, other = (frames[0].observation.image_rgb for _, frames in episodes)
    assert (one != other).any()
    for episode, _ in episodes:
        episode.close()


@pytest.mark.heavy
def test_pictures_do_not_depend_on_larger_views_drawn_between():
    plain, with_views = (ROAD_TOWN.episode("quick", 3) for _ in range(2))
    for _ in range(3):
        a, b = plain.step(), with_views.step()
        with_views.larger_view(2.0)
        np.testing.assert_array_equal(a.observation.image_rgb, b.observation.image_rgb)


LEFT_OUT = {"flow_px", "semantic_map", "visible_fraction"}


@pytest.mark.heavy
@pytest.mark.parametrize("closed_loop", [False, True])
def test_less_truth_is_the_same_where_it_is(closed_loop):
    whole, less = (_frames("quick", 1, 6, closed_loop=closed_loop, truth=extent)[1] for extent in ("all", "target"))
    for a, b in zip(whole, less, strict=True):
        for x, y in zip(_flat(a.observation), _flat(b.observation), strict=True):
            np.testing.assert_array_equal(x, y)
        for field in dataclasses.fields(a.truth):
            if field.name not in LEFT_OUT:
                for x, y in zip(*(_flat(getattr(truth, field.name)) for truth in (a.truth, b.truth)), strict=True):
                    np.testing.assert_array_equal(x, y)
        assert b.truth.flow_px.shape == (0, 0, 2)
        assert b.truth.visible_fraction[0] == a.truth.visible_fraction[0]
        assert np.isnan(b.truth.visible_fraction[1:]).all()


def test_extent_of_truth_is_refused_by_name():
    with pytest.raises(ValueError, match="truth: expected 'all' or 'target', got some"):
        ROAD_TOWN.episode("quick", 0, truth="some")


@pytest.fixture(scope="module")
def quick():
    episode, frames = _frames("quick", 1, PRESETS["quick"].frame_count)
    yield episode, frames
    episode.close()


@pytest.mark.heavy
def test_states_and_exit_counts_are_those_of_the_plan(quick):
    episode, frames = quick
    planned = picture_states(episode.plan.camera, episode.plan.camera_poses, episode.plan.target_corners_m()) == OUT
    # The plan uses the car's bounding box; truth uses its vertices, whose box is a little smaller.
    out = np.array([f.truth.state[TARGET] == "out" for f in frames])
    assert (out & ~planned).sum() <= 4
    assert not (planned & ~out).any()
    assert out.any()
    run = -1
    for frame in frames:
        run = run + 1 if frame.truth.state[TARGET] == "out" else -1
        assert frame.truth.frames_since_exit[TARGET] == run
        assert (frame.truth.side[TARGET] in ("left", "right", "top", "bottom")) or run == -1


@pytest.mark.heavy
def test_target_is_drawn_where_truth_says(quick):
    _, frames = quick
    for frame in frames[::10]:
        t = frame.truth
        rows, columns = np.nonzero(t.instance_map == t.instance_id[0])
        if t.state[TARGET] == "in" and t.visible_fraction[0] > 0.98:
            box = t.box_xyxy[0]
            drawn = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
            np.testing.assert_allclose(box, drawn, atol=1.6)
            assert box[0] < t.position_px[0, 0] < box[2]
        if t.state[TARGET] == "out":
            assert len(rows) == 0
            assert t.visible_fraction[0] == 0.0


def test_depth_and_ids_agree_with_projected_places(quick):
    episode, frames = quick
    t = frames[40].truth
    ground = t.instance_map == 0
    rows, columns = (index[::997] for index in np.nonzero(ground))
    focal, centre = episode.plan.camera.focal_px, episode.plan.camera.centre_px
    depth = t.depth_m[rows, columns]
    rays = np.column_stack([(columns + 0.5 - centre[0]) / focal, (rows + 0.5 - centre[1]) / focal, np.ones(len(rows))])
    world = (rays * depth[:, None]) @ t.T_world_camera[:3, :3].T + t.T_world_camera[:3, 3]
    np.testing.assert_allclose(world[:, 2], 0.0, atol=2e-3)


def test_flow_of_the_target_is_its_motion(quick):
    episode, frames = quick
    for before, after in pairwise(frames[20:31]):
        car = episode.plan.sizes_m[0]
        roof = np.array([0.0, 0.0, 0.5 * car[2], 1.0])
        now, _ = project(episode.plan.camera, after.truth.T_world_camera, (after.truth.T_world_object[0] @ roof)[:3])
        then, _ = project(episode.plan.camera, before.truth.T_world_camera, (before.truth.T_world_object[0] @ roof)[:3])
        rows, columns = np.nonzero(after.truth.instance_map == after.truth.instance_id[0])
        mean = after.truth.flow_px[rows, columns].mean(axis=0)
        np.testing.assert_allclose(mean, then - now, atol=0.4)


def test_observation_holds_no_truth():
    fields = {field.name for field in dataclasses.fields(Observation)}
    assert fields == {"image_rgb", "time_s", "camera", "settings", "ego", "right_rgb", "counts", "steered"}


@pytest.mark.heavy
def test_measured_pose_has_errors_where_the_preset_says():
    _, frames = _frames("standard", 4, 3)
    for frame in frames:
        measured = frame.observation.ego.T_world_camera
        assert 0.01 < np.linalg.norm(measured[:3, 3] - frame.truth.T_world_camera[:3, 3]) < 8.0
    assert _frames("paper-a3", 4, 1)[1][0].observation.ego is None
    exact = _frames("paper-a2", 4, 1)[1][0]
    np.testing.assert_allclose(exact.observation.ego.T_world_camera, exact.truth.T_world_camera)


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (lambda: scenario("road-city"), "scenario: expected one of .*road-town-v2.*; got 'road-city'"),
        (lambda: ROAD_TOWN.episode("rural", 0), "preset: expected one of .*standard.*; got 'rural'"),
        (lambda: ROAD_TOWN.episode("quick", -1), "master_seed: expected a whole number >= 0, got -1"),
        (lambda: ROAD_TOWN.episode("quick", 0, renderer="optix"), "renderer: expected .*pybullet.*got 'optix'"),
        (lambda: RoadTown("x", width_px=0), "width_px: expected a whole number from 32 to 4096, got 0"),
        (
            lambda: RoadTown("x", frame_count=106),
            "frame_count: expected at least 107 for 2 or more frame-outs, got 106",
        ),
        (
            lambda: RoadTown("x", frame_count=107, closed_loop=True),
            "frame_count: expected at least 1.. for 2 or more frame-outs in closed loop, got 107",
        ),
        (lambda: RoadTown("x", altitude_m=(5.0, 10.0)), r"altitude_m: expected two numbers .* in \[40, 100\], got \(5"),
        (lambda: RoadTown("x", altitude_m=(90.0, 101.0)), r"altitude_m: expected two numbers .* in \[40, 100\], got"),
        (lambda: RoadTown("x", traffic_cars=100), r"traffic_cars: expected a number in \[0, 60\], got 100"),
        (lambda: FrameOuts(start_frame=28), "start_frame: expected None or at least 29, got 28"),
        (
            lambda: RoadTown("x", camera_pitch_deg=(0.0, 50.0)),
            r"camera_pitch_deg: expected 0, or angles .* above 2\d.\d, got",
        ),
        (
            lambda: RoadTown("x", camera_pitch_deg=(23.0, 50.0), field_of_view_deg=60.0),
            "camera_pitch_deg: expected 0, or angles .* above 2",
        ),
    ],
)
def test_bad_input_gets_one_clear_message(action, message):
    with pytest.raises(ValueError, match=message):
        action()


@pytest.mark.heavy
def test_commands_are_asked_for_in_closed_loop_and_refused_on_a_set_path():
    looped, _ = _frames("paper-a2", 0, 1)
    with pytest.raises(ValueError, match="command: expected a CameraCommand"):
        looped.step()
    flown, _ = _frames("quick", 0, 1)
    with pytest.raises(ValueError, match="command: expected None"):
        flown.step(CameraCommand())


def test_version_may_be_left_out():
    assert scenario("road-town") is scenario("road-town-v2")


@pytest.mark.parametrize(
    "asked", [scenario, lambda name: FollowEnv(name, tracker="hold"), lambda name: Request(name, "quick", (0, 1), ())]
)
def test_a_deleted_version_names_its_successor(asked):
    with pytest.raises(ValueError, match="scenario: expected road-town-v2, which took its place, got 'road-town-v1'"):
        asked("road-town-v1")


def test_a_deleted_env_names_its_successor():
    for made in (gymnasium.make, gymnasium.make_vec):
        with pytest.raises(gymnasium.error.DeprecatedEnv, match="Please use `frameout/RoadTownFollow-v3` instead"):
            made("frameout/RoadTownFollow-v1")
    told = "env: expected frameout/RoadTownFollow-v3, which took its place, got 'frameout/RoadTownFollow-v1'"
    with pytest.raises(ValueError, match=told):
        Training(env="frameout/RoadTownFollow-v1")
    assert set(SUCCESSORS.values()) <= {*names(), *envs()}
    assert not set(SUCCESSORS) & {*names(), *envs()}
