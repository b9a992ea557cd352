"""A person followed with pictures: byte-identical repeats; truth agrees with itself, geometry and the pair."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.scenario import Frame, Setup
from scenarios.stereo_follow import camera
from scenarios.stereo_follow.building import CORRIDOR_LIGHTS, HALL_LIGHTS, LIGHT_GROUPS
from scenarios.stereo_follow.floor_plan import PLACES
from scenarios.stereo_follow.lighting import LightPlan, baked_light, illuminance_lx, set_light
from scenarios.stereo_follow.plan import TARGET, building_of, make_plan
from scenarios.stereo_follow.presets import PRESETS
from scenarios.stereo_follow.robot import FASTEST_MPS, FASTEST_TURN_RAD_S
from scenarios.stereo_follow.scenario import STEREO_FOLLOW, StereoFollowEpisode
from scenarios.stereo_follow.truth import PeopleTruth
from sim.optics import invert_pose, project
from sim.render.pipeline import capture
from sim.render.protocol import create_renderer
from sim.sensors.camera_sensor import CameraSensor
from sim.shaders.baked.shader import BakedLightShader
from tests.scenarios.stereo_follow.conftest import SEED, Recorded
from trackers.light_adaptive_stereo.matching import StereoMatcher
from trackers.registry import entry
from trackers.types import CameraCommand

SMALL = replace(PRESETS["quick"], width_px=160, height_px=120, dropped_share=1.0, odometry=False)
AHEAD = CameraCommand(forward_mps=0.8, yaw_rate_rad_s=0.4)


def _flat(value) -> list[np.ndarray]:
    if dataclasses.is_dataclass(value):
        return [leaf for field in dataclasses.fields(value) for leaf in _flat(getattr(value, field.name))]
    return [np.asarray(value)]


def _ground_of(frame: Frame, pixels: tuple[NDArray[np.intp], NDArray[np.intp]]) -> NDArray[np.float64]:
    """Return the world points (N, 3) that the left camera shows at pixels (rows, columns), by the depth map."""
    truth, lens = frame.truth, frame.camera
    rows, columns = pixels
    depth_m = truth.depth_m[rows, columns].astype(float)
    x, y = lens.centre_px
    right, down = (columns + 0.5 - x) / lens.focal_px, (rows + 0.5 - y) / lens.focal_px
    points_m = np.column_stack([right, down, np.ones(len(rows))]) * depth_m[:, None]
    return points_m @ truth.T_world_camera[:3, :3].T + truth.T_world_camera[:3, 3]


@pytest.mark.heavy
def test_same_seed_same_bytes(recorded: Recorded):
    building_of.cache_clear()
    baked_light.cache_clear()
    again = STEREO_FOLLOW.episode("quick", SEED)
    assert np.array_equal(again.start.box_xyxy, recorded.episode.start.box_xyxy)
    for first in recorded.frames[:4]:
        second = again.step()
        again.larger_view(1.5)
        for x, y in zip(_flat(first), _flat(second), strict=True):
            np.testing.assert_array_equal(x, y)
    again.close()


@pytest.mark.heavy
def test_the_observation_holds_no_truth(recorded: Recorded):
    for frame in recorded.frames[::10]:
        seen, truth = frame.observation, frame.truth
        assert isinstance(truth, PeopleTruth)
        for part in _flat(seen):
            assert not any(np.shares_memory(part, fact) for fact in _flat(truth))
        assert seen.ego is not None
        assert seen.camera.baseline_m == camera.BASELINE_M
        # Its frame is the robot's start, and wheels measure neither nod nor roll.
        assert np.abs(seen.ego.T_world_camera - truth.T_world_camera).max() > 0.01
        assert seen.ego.T_world_camera[2, 2] == pytest.approx(0.0, abs=1e-12)
    assert recorded.frames[0].observation.ego.T_world_camera[:3, 3] == pytest.approx([0, 0, 1.2])


@pytest.mark.heavy
def test_the_target_is_drawn_at_its_true_place_with_its_visible_share(recorded: Recorded):
    whole = 0
    for frame in recorded.frames:
        t = frame.truth
        rows, columns = np.nonzero(t.instance_map == t.instance_id[TARGET])
        box, share = t.box_xyxy[TARGET], t.visible_fraction[TARGET]
        assert 0 <= share <= 1
        assert (share > 0) == (len(rows) > 0)
        if len(rows):
            assert box[0] - 1 <= columns.min() <= columns.max() <= box[2] + 1
            assert box[1] - 1 <= rows.min() <= rows.max() <= box[3] + 1
        if t.state[TARGET] == "in" and share > 0.99:
            drawn = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
            np.testing.assert_allclose(box, drawn, atol=2.0)
            assert box[0] < t.position_px[0, 0] < box[2]
            whole += 1
    assert whole > 3


def test_the_visible_share_is_that_of_the_pixels_without_other_people(recorded: Recorded):
    """Rendered again with all other people far away, the target's pixels give truth's visible share."""
    episode = recorded.episode
    world, people = episode.world, episode._objects
    renderer = create_renderer("raster", world)
    for frame in recorded.frames[4::11]:
        t = frame.truth
        people.move_to(t.frame)
        for k, bodies in enumerate(people.parts):
            for body, pose in zip(bodies, people.part_poses[k], strict=True):
                if k != TARGET:
                    world.move(body, pose + np.array([[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, -50.0], [0, 0, 0, 0]]))
        alone = renderer.gbuffer(frame.camera, t.T_world_camera).instance_id
        people.merge(alone)
        own = t.instance_id[TARGET]
        seen, whole = (t.instance_map == own).sum(), (alone == own).sum()
        inside = (t.box_xyxy[TARGET] >= 0).all() and (t.box_xyxy[TARGET, 2:] <= (320, 240)).all()
        if inside:
            assert t.visible_fraction[TARGET] == pytest.approx(seen / whole, abs=0.03)
        else:
            assert t.visible_fraction[TARGET] <= seen / whole + 0.03


def test_the_occluder_is_the_person_who_covers_the_target(recorded: Recorded):
    named = 0
    for frame in recorded.frames:
        t = frame.truth
        if t.visible_fraction[TARGET] > 0.8 or t.state[TARGET] != "occluded":
            continue
        x0, y0, x1, y1 = np.clip(t.box_xyxy[TARGET], 0, [320, 240, 320, 240]).astype(int)
        ids = t.instance_map[y0:y1, x0:x1]
        covers = np.array([(ids == own).sum() for own in t.instance_id])
        covers[TARGET] = 0
        hider = t.occluder[TARGET]
        assert hider == covers.argmax()
        away_m = np.linalg.norm(t.T_world_object[:, :2, 3] - t.T_world_camera[:2, 3], axis=1)
        assert away_m[hider] < away_m[TARGET]
        named += 1
    assert named > 0
    assert all(frame.truth.occluder[0] != 0 for frame in recorded.frames)


def test_depth_of_floors_lies_on_the_ground(recorded: Recorded):
    names = [body.name for body in recorded.episode.world.bodies]
    floors = [names.index(name) for name in ("corridor floor", "hall floor", "paving")]
    for frame in recorded.frames[::20]:
        rows, columns = (index[::61] for index in np.nonzero(np.isin(frame.truth.instance_map, floors)))
        assert len(rows) > 20
        np.testing.assert_allclose(_ground_of(frame, (rows, columns))[:, 2], 0.0, atol=2e-3)


def test_the_right_picture_shows_the_same_places_from_twelve_centimetres_beside(recorded: Recorded):
    for frame in recorded.frames[::15]:
        t = frame.truth
        rows, columns = (index.ravel()[::311] for index in np.indices(t.depth_m.shape))
        in_sight = t.depth_m[rows, columns] < 40.0
        rows, columns = rows[in_sight], columns[in_sight]
        pixels, depth_m = project(frame.camera, t.T_world_right, _ground_of(frame, (rows, columns)))
        place = np.floor(pixels).astype(int)
        inside = ((place >= 0) & (place < (320, 240))).all(axis=1)
        there_m = t.right_depth_m[place[inside, 1], place[inside, 0]]
        # Elsewhere a person hides the place from one camera, or it lies at an edge.
        assert (np.abs(there_m - depth_m[inside]) < 0.03 * depth_m[inside] + 0.02).mean() > 0.9


def test_the_rig_is_calibrated_but_not_quite(recorded: Recorded):
    mounts = [invert_pose(f.truth.T_world_camera) @ f.truth.T_world_right for f in recorded.frames[::20]]
    for mount in mounts:
        np.testing.assert_allclose(mount, mounts[0], atol=1e-9)
        np.testing.assert_allclose(mount[:3, 3], [camera.BASELINE_M, 0, 0], atol=1e-9)
        turned_rad = np.arccos(np.clip((np.trace(mount[:3, :3]) - 1) / 2, -1, 1))
        assert 1e-6 < turned_rad < np.deg2rad(0.2)


def test_disparity_matched_from_the_pair_is_the_true_one(recorded: Recorded):
    """Up to the rotation of the right camera, which a tracker does not know."""
    matcher, off_px = StereoMatcher(), []
    for frame in recorded.frames[::15]:
        seen, t = frame.observation, frame.truth
        matched_m = matcher.depth_m(seen.image_rgb, seen.right_rgb, seen.camera)
        step = t.depth_m.shape[0] // matched_m.shape[0]
        true_m = t.depth_m[::step, ::step]
        near = np.isfinite(matched_m) & (true_m < 6.0)
        assert near.mean() > 0.1
        focal_px = seen.camera.focal_px / step
        turned_px = focal_px * (invert_pose(t.T_world_camera) @ t.T_world_right)[0, 2]
        disparity_px = focal_px * camera.BASELINE_M / np.stack([matched_m, true_m])[:, near]
        off_px.append(np.median(disparity_px[0] - disparity_px[1]) - turned_px)
    assert np.mean(off_px) == pytest.approx(0.0, abs=0.1)


def test_truth_holds_the_target_s_place_and_new_changes_of_light(recorded: Recorded):
    plan = recorded.episode.plan
    words = {"lamp on", "lamp off", "back light", "doorway", "shade", None}
    for k, frame in enumerate(recorded.frames):
        t = frame.truth
        assert t.frame == k
        assert t.place == plan.places[k]
        assert t.place in PLACES
        assert t.light_event in words
        assert plan.light.switched[k] in (None, t.light_event)
        away_m = np.linalg.norm(t.T_world_object[1:, :2, 3] - t.T_world_camera[:2, 3], axis=1)
        assert t.near_person == bool(((away_m < 1.5) & (t.visible_fraction[1:] > 0)).any())
        assert (t.illuminance_lx > 0).all()
        assert np.linalg.norm(t.T_world_camera[:2, 3] - plan.crowd.robot_m[k]) < 1e-6
        assert abs(np.arcsin(t.T_world_camera[2, 2])) < np.deg2rad(0.8)
    assert recorded.frames[0].truth.light_event in (None, *plan.light.switched[:1])


def test_the_camera_reports_the_settings_it_used(recorded: Recorded):
    for frame in recorded.frames:
        part, t = frame.observation.settings, frame.truth
        assert (part.exposure_s, part.gain, part.registers) == (t.exposure_s, t.gain, t.registers)
        for name, largest in (("red", 1023), ("blue", 1023), ("shutter", 707), ("gain", 683)):
            assert 0 <= getattr(t.registers, name) <= largest
        assert t.registers.shutter == pytest.approx(707 * t.exposure_s / camera.LONGEST_EXPOSURE_S, abs=0.51)


def test_where_the_lamps_are_off_it_is_darker_and_the_shutter_stays_open_longer(recorded: Recorded):
    episode, frame = recorded.episode, recorded.frames[0]
    shader = episode._shader
    assert isinstance(shader, BakedLightShader)
    plan = episode.plan.building.plan
    area = plan.corridor
    # Half way between window and passage.
    place_m = np.array([[0.5 * (area.x0 + area.x1), 0.5 * (area.y0 + area.y1), 1.3]])
    viewer_m = np.array([area.x1, place_m[0, 1], 1.2])
    pose = camera.camera_pose(viewer_m[:2] - (1.0, 0.0), np.pi)
    lux, exposure_s, levels = [], [], []
    for strength in (1.0, 0.0):
        strengths = {group: np.ones(1) for group in LIGHT_GROUPS}
        strengths[CORRIDOR_LIGHTS] = strengths[HALL_LIGHTS] = np.full(1, strength)
        set_light(shader, LightPlan(strengths, (None,)), 0)
        lux.append(float(illuminance_lx(shader, place_m, viewer_m)[0]))
        sensor = CameraSensor(camera.SENSOR, np.random.default_rng(0))
        picture = capture(create_renderer("raster", episode.world), shader, sensor, frame.camera, pose, 0).picture
        exposure_s.append(picture.settings.exposure_s * picture.settings.gain)
        levels.append(picture.image_rgb.mean())
    assert 0 < lux[1] < 0.5 * lux[0]
    assert exposure_s[1] > 1.3 * exposure_s[0]
    assert levels[1] < 1.3 * levels[0]


@pytest.fixture(scope="module")
def driven() -> Iterator[tuple[StereoFollowEpisode, list[Frame]]]:
    """Yield a small closed-loop episode of another seed, without odometry and with all right pictures lost."""
    episode = StereoFollowEpisode(Setup(STEREO_FOLLOW, SMALL, 9, closed_loop=True))
    yield episode, [episode.step()] + [episode.step(AHEAD) for _ in range(15)]
    episode.close()


@pytest.mark.heavy
def test_in_closed_loop_the_robot_goes_as_it_is_told(driven: tuple[StereoFollowEpisode, list[Frame]]):
    episode, frames = driven
    with pytest.raises(ValueError, match="command: expected a CameraCommand"):
        episode.step()
    poses = np.array([frame.truth.T_world_camera for frame in frames])
    step_m = np.diff(poses[:, :2, 3], axis=0)
    headings = np.unwrap(np.arctan2(poses[:, 1, 2], poses[:, 0, 2]))
    turn_rad = np.diff(headings)
    assert np.linalg.norm(step_m[-1]) * 15.0 == pytest.approx(AHEAD.forward_mps, rel=0.05)
    assert np.mean(turn_rad[-4:]) * 15.0 == pytest.approx(AHEAD.yaw_rate_rad_s, abs=0.1)
    assert np.linalg.norm(step_m, axis=1).max() * 15.0 < FASTEST_MPS
    assert turn_rad.max() * 15.0 < FASTEST_TURN_RAD_S
    along = np.column_stack([np.cos(headings[:-1]), np.sin(headings[:-1])])
    assert (np.einsum("fk,fk->f", step_m[4:], along[4:]) > 0).all()


def test_a_command_on_a_set_path_and_a_step_too_many_are_refused(recorded: Recorded):
    with pytest.raises(StopIteration):
        recorded.episode.step()
    fresh = StereoFollowEpisode.__new__(StereoFollowEpisode)
    fresh.closed_loop, fresh.frame_count, fresh._frame = False, 5, -1
    with pytest.raises(ValueError, match="command: expected None"):
        fresh.step(AHEAD)


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["stereo_people", "stereo_wb", "stereo_wb_shutter_gain"])
def test_lost_pictures_are_none_and_no_tracker_falls_over_them(
    name: str, driven: tuple[StereoFollowEpisode, list[Frame]]
):
    episode, frames = driven
    assert episode.plan.dropped.all()
    tracker = entry(name).create(np.random.default_rng(0))
    tracker.initialise(frames[0].observation, episode.start.box_xyxy)
    for frame in frames:
        assert frame.observation.right_rgb is None
        assert frame.observation.ego is None
        tracker.update(replace(frame.observation, time_s=frame.observation.time_s + 1.0))


def test_another_seed_is_another_episode(recorded: Recorded, driven: tuple[StereoFollowEpisode, list[Frame]]):
    other = make_plan(PRESETS["quick"], 9, closed_loop=False)
    assert not np.array_equal(other.crowd.robot_m, recorded.episode.plan.crowd.robot_m)
    assert other.looks != recorded.episode.plan.looks
    assert driven[1][0].truth.T_world_camera[0, 3] != recorded.frames[0].truth.T_world_camera[0, 3]
