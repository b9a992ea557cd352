"""The second camera, which a head turns and zooms, and its truth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenario import HARBOUR, HEAD, LENS, MOUNT, HarbourEpisode
from scenarios.pan_tilt_zoom import Head
from scenarios.truth import check_truth
from scenarios.visibility import states_of
from sim.optics import project
from trackers.types import CameraCommand

SMALL = dataclasses.replace(PRESETS["quick"], background=2)


@pytest.fixture
def episode():
    made = HARBOUR.episode(SMALL, 4, closed_loop=True, truth="target")
    yield made
    made.close()


def aimed(episode: HarbourEpisode, gain: float) -> CameraCommand:
    """Return the command that turns the head towards the target, by truth."""
    head, frame = episode._head, max(episode._frame, 0)
    target = episode._objects.course[frame, episode._objects.names.index(HARBOUR.target), :3, 3] + (0.0, 0.0, 0.9)
    x, y, z = target - head.T_world_camera[:3, 3]
    return CameraCommand(
        pan_rad_s=gain * (np.arctan2(y, x) - head.pan_rad),
        tilt_rad_s=gain * (np.arctan2(z, np.hypot(x, y)) - head.tilt_rad),
    )


@pytest.mark.heavy
def test_commands_keep_the_target_in_the_second_camera_and_its_truth_is_that_camera_s(episode) -> None:
    box = episode.start.box_xyxy
    frame = episode.step()
    target = frame.truth.index_of(HARBOUR.target)
    np.testing.assert_array_equal(frame.truth.box_xyxy[target], box)
    for _ in range(14):
        frame = episode.step(aimed(episode, 0.45))
    truth, camera = frame.judged
    assert frame.steered is truth
    check_truth(truth)
    assert truth.state[target] == "in"
    assert np.abs(truth.position_px[target] - camera.centre_px).max() < 120
    # Both cameras see the same place.
    for seen, by in ((truth, camera), (frame.truth, frame.camera)):
        place = seen.T_world_object[target, :3, 3] + 0.5 * seen.size_m[target, 2] * seen.T_world_object[target, :3, 2]
        np.testing.assert_allclose(project(by, seen.T_world_camera, place)[0], seen.position_px[target], atol=1e-9)
    assert np.ptp(truth.box_xyxy[target][1::2]) > 2.0 * np.ptp(frame.truth.box_xyxy[target][1::2])
    view = frame.observation.steered
    assert view is not None
    np.testing.assert_array_equal(view.ego.T_world_camera, truth.T_world_camera)
    assert view.camera.band == "thermal"
    assert truth.instance_map.size == 0
    absent = frame.truth.state == "absent"
    assert (truth.state[absent] == "absent").all()
    others = states_of(camera, truth.box_xyxy, truth.visible_fraction)
    np.testing.assert_array_equal(truth.state[~absent], others[~absent])


def test_without_a_command_the_camera_sees_the_middle_of_the_quay(episode) -> None:
    frame = episode.step()
    truth, camera = frame.judged
    middle = project(camera, truth.T_world_camera, np.zeros(3))[0]
    np.testing.assert_allclose(middle, camera.centre_px, atol=1e-6)
    assert camera.focal_px == LENS.focal_px
    with pytest.raises(ValueError, match=r"^command: expected a CameraCommand"):
        episode.step()


@pytest.mark.heavy
def test_the_overview_is_the_same_whether_a_second_camera_is_steered_or_not(episode) -> None:
    apart = HARBOUR.episode(SMALL, 4)
    frames = [episode.step(CameraCommand(pan_rad_s=0.3) if k else None) for k in range(3)]
    for frame in frames:
        other = apart.step()
        assert other.steered is None
        assert other.observation.steered is None
        np.testing.assert_array_equal(frame.observation.counts, other.observation.counts)
        np.testing.assert_array_equal(frame.truth.box_xyxy, other.truth.box_xyxy)
    assert apart.start.box_xyxy is None
    apart.close()


def test_a_head_obeys_within_its_limits() -> None:
    head = Head(MOUNT, 5.0)
    pan, tilt = head.pan_rad, head.tilt_rad
    head.obey(CameraCommand(pan_rad_s=9.0, tilt_rad_s=0.1, zoom_per_s=0.2))
    assert head.pan_rad == pytest.approx(pan + 0.8 / 5.0)
    assert head.tilt_rad == pytest.approx(tilt + 0.1 / 5.0)
    assert head.zoom == pytest.approx(np.exp(0.2 / 5.0))
    for _ in range(100):
        head.obey(CameraCommand(pan_rad_s=9.0, tilt_rad_s=-9.0, zoom_per_s=9.0))
    assert head.pan_rad < 1.0
    assert head.tilt_rad > -1.0
    assert head.camera.focal_px == pytest.approx(3.0 * LENS.focal_px)
    assert [axis.name for axis in HEAD.axes] == ["pan_rad_s", "tilt_rad_s", "zoom_per_s"]
    R = head.T_world_camera[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) > 0.99


def test_in_closed_loop_there_is_always_someone_to_follow() -> None:
    preset = dataclasses.replace(PRESETS["standard"], frame_count=80)
    followed, apart = (HARBOUR.episode(preset, 1, closed_loop=looped) for looped in (True, False))
    target = followed._objects.names.index(HARBOUR.target)
    assert followed._objects.presence[:, target].all()
    assert not apart._objects.presence[:, apart._objects.names.index(HARBOUR.target)].all()
    followed.close()
    apart.close()
