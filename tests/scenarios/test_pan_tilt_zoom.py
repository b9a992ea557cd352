"""A pan-tilt-zoom head, upright or hanging, and the scenes whose trackers look through one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenarios import catalog
from scenarios.fish_tank import ptz as tank
from scenarios.harbour import ptz as harbour
from scenarios.pan_tilt_zoom import Head
from scenarios.truth import check_truth
from scenarios.visibility import is_in_view, view_width_m
from sim.optics import project
from sim.pose import rotation_by
from trackers.types import CameraCommand

SCENES = ("fish-tank-ptz", "harbour-ptz")
angles = st.floats(-0.2, 0.2)


@given(pan=angles, tilt=angles, mount=st.sampled_from([tank.MOUNT, harbour.MOUNT]))
def test_a_head_turns_about_its_own_axes(pan: float, tilt: float, mount) -> None:
    head = Head(mount, 10.0)
    head.pan_rad, head.tilt_rad = pan, tilt
    ahead, left = np.array(mount.ahead), np.array(mount.left)
    upright = np.stack([-left, np.cross(ahead, -left), ahead], axis=1)
    # First tilted about its own left axis, then panned about the mount's upright one.
    turned = rotation_by(pan * np.cross(ahead, left)) @ rotation_by(-tilt * left) @ upright
    np.testing.assert_allclose(head.T_world_camera[:3, :3], turned, atol=1e-12)


@given(pan=angles, tilt=angles, mount=st.sampled_from([tank.MOUNT, harbour.MOUNT]))
def test_encoders_measure_angles_to_half_a_step(pan: float, tilt: float, mount) -> None:
    head = Head(mount, 10.0)
    head.pan_rad, head.tilt_rad = pan, tilt
    true, measured = head.T_world_camera[:3, :3], head.T_world_measured[:3, :3]
    between_rad = np.arccos(np.clip(0.5 * (np.trace(true.T @ measured) - 1.0), -1.0, 1.0))
    assert between_rad <= np.sqrt(0.5) * mount.step_rad + 1e-7
    head.pan_rad, head.tilt_rad = 7 * mount.step_rad, -3 * mount.step_rad
    np.testing.assert_allclose(head.T_world_measured, head.T_world_camera, atol=1e-12)


@pytest.fixture(scope="module", params=SCENES)
def seen(request):
    """Frames of an episode: as it begins, the head turned away, back again, and zoomed out."""
    scenario = catalog.scenario(request.param)
    preset = dataclasses.replace(scenario.presets["quick"], width_px=160, height_px=120)
    episode = scenario.episode(preset, 3, closed_loop=True, truth="target")
    first = episode.step()
    turn = CameraCommand(pan_rad_s=2.0)
    frames = [episode.step(turn) for _ in range(6)]
    out = [episode.step(CameraCommand(zoom_per_s=-1.0)) for _ in range(2 * int(4.5 * episode.rate_hz))]
    yield scenario, episode, first, frames, out
    episode.close()


def test_the_first_picture_has_the_target_in_the_middle_and_large_enough(seen) -> None:
    scenario, episode, first, *_ = seen
    target = first.truth.index_of(scenario.target)
    assert first.steered is None
    assert first.observation.steered is None
    assert np.abs(first.truth.position_px[target] - first.camera.centre_px).max() < 0.15 * first.camera.width_px
    assert view_width_m(first.truth, target, first.camera) == pytest.approx(0.8 * scenario.widest_view_m, rel=0.02)
    assert is_in_view(first.truth, target, first.camera, scenario.widest_view_m)
    np.testing.assert_array_equal(episode.start.box_xyxy, first.truth.box_xyxy[target])
    assert episode.start.camera == first.camera
    assert episode.start.background == ()


def test_truth_and_picture_are_those_of_the_head(seen) -> None:
    scenario, _, first, turned, out = seen
    target = first.truth.index_of(scenario.target)
    for frame in (first, *turned, *out):
        check_truth(frame.truth)
        assert frame.observation.image_rgb.shape[:2] == (120, 160)
        x, y = frame.truth.position_px[target]
        if frame.truth.state[target] == "in" and frame.truth.visible_fraction[target] > 0.95:
            box = frame.truth.box_xyxy[target].round().astype(int)
            shown = frame.truth.instance_map[box[1] : box[3] + 1, box[0] : box[2] + 1]
            assert (shown == frame.truth.instance_id[target]).any(), (frame.truth.frame, x, y)
    # Turned away to the left, the target leaves to the right.
    assert turned[-1].truth.state[target] == "out"
    assert turned[-1].truth.side[target] == "right"
    if scenario.id.startswith("harbour"):
        truth = turned[-1].truth
        middle_m = truth.T_world_object[target, :3, 3] + 0.5 * truth.size_m[target, 2] * np.array([0.0, 0.0, 1.0])
        place_px = project(turned[-1].camera, truth.T_world_camera, middle_m)[0]
        np.testing.assert_allclose(place_px, truth.position_px[target], atol=1e-9)


def test_zoomed_out_the_target_is_in_the_picture_but_too_small_to_count(seen) -> None:
    scenario, _, first, _, out = seen
    target, last = first.truth.index_of(scenario.target), out[-1]
    assert last.camera.focal_px < 0.2 * first.camera.focal_px
    assert view_width_m(last.truth, target, last.camera) > 3.0 * scenario.widest_view_m
    assert not is_in_view(last.truth, target, last.camera, scenario.widest_view_m)


def test_trackers_get_the_pose_that_encoders_measure(seen) -> None:
    _, episode, first, turned, _ = seen
    mount = episode._head.mount
    for frame in (first, *turned):
        error = frame.observation.ego.T_world_camera[:3, :3] - frame.truth.T_world_camera[:3, :3]
        assert 0.0 < np.abs(error).max() < mount.step_rad


@pytest.mark.parametrize("name", SCENES)
def test_a_fast_target_is_lost_by_a_head_that_stays(name: str) -> None:
    scenario = catalog.scenario(name)
    episode = scenario.episode("quick", 5, closed_loop=True, truth="target")
    frames = [episode.step(CameraCommand() if k else None) for k in range(episode.frame_count)]
    target = frames[0].truth.index_of(scenario.target)
    in_view = [is_in_view(each.truth, target, each.camera, scenario.widest_view_m) for each in frames]
    assert in_view[0]
    assert not all(in_view)
    episode.close()
