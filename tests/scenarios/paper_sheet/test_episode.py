"""Episodes whose target is a sheet: byte-identical repeats, and a truth that agrees with the pictures."""

from __future__ import annotations

import dataclasses
from contextlib import closing

import numpy as np
import pytest

from scenarios.catalog import scenario
from scenarios.paper_sheet.scenario import SheetEpisode
from scenarios.paper_sheet.sheet import SHEET_M
from scenarios.scenario import Frame
from scenarios.stereo_follow.camera import BASELINE_M, LONGEST_EXPOSURE_S
from scenarios.stereo_follow.truth import StereoTruth
from scenarios.truth import check_truth
from sim.optics import project
from trackers.types import CameraCommand

PAPER_SHEET = scenario("paper-sheet")
PRESETS = ("paper-b1", "paper-b2")
FRAMES = 5


def recorded(preset: str, seed: int, frames: int = FRAMES) -> tuple[np.ndarray, list[Frame]]:
    """Return the first box and the first frames."""
    with closing(PAPER_SHEET.episode(preset, seed)) as episode:
        return episode.start.box_xyxy, [episode.step() for _ in range(frames)]


@pytest.fixture(scope="module", params=PRESETS)
def first(request: pytest.FixtureRequest) -> tuple[str, np.ndarray, list[Frame]]:
    return request.param, *recorded(request.param, 3)


def _flat(value) -> list[np.ndarray]:
    if dataclasses.is_dataclass(value):
        return [leaf for field in dataclasses.fields(value) for leaf in _flat(getattr(value, field.name))]
    return [np.asarray(value)]


@pytest.mark.heavy
def test_episodes_are_a_function_of_the_seed_alone(first):
    preset, box, frames = first
    with closing(PAPER_SHEET.episode(preset, 3)) as again:
        np.testing.assert_array_equal(again.start.box_xyxy, box)
        for one in frames:
            other = again.step()
            again.larger_view(1.5)
            for x, y in zip(_flat(one), _flat(other), strict=True):
                np.testing.assert_array_equal(x, y)
    _, others = recorded(preset, 4, 1)
    assert (others[0].observation.image_rgb != frames[0].observation.image_rgb).mean() > 0.5


def test_the_papers_count_of_pictures():
    counts = {}
    for preset in PRESETS:
        with closing(PAPER_SHEET.episode(preset, 0)) as episode:
            counts[preset] = episode.frame_count
            assert episode.frame_count == PAPER_SHEET.presets[preset].frame_count
    assert counts == {"paper-b1": 9, "paper-b2": 947}


@pytest.mark.heavy
def test_the_sheet_is_drawn_where_truth_says(first):
    _, box, frames = first
    for frame in frames:
        t = frame.truth
        assert isinstance(t, StereoTruth)
        check_truth(t)
        rows, columns = np.nonzero(t.instance_map == t.instance_id[0])
        np.testing.assert_allclose(
            t.box_xyxy[0], [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1], atol=1.0
        )
        np.testing.assert_allclose(t.box_xyxy[0], box, atol=1e-3)
        assert t.visible_fraction[0] > 0.99
        assert (t.names, t.state) == (("target",), ["in"])
        np.testing.assert_allclose(t.position_px[0], [columns.mean() + 0.5, rows.mean() + 0.5], atol=3.0)
        # Its size in pixels matches its distance.
        away_m = t.depth_m[rows, columns].mean()
        assert box[3] - box[1] == pytest.approx(SHEET_M[1] * frame.camera.focal_px / away_m, rel=0.1)
        assert (t.right_instance_map == t.instance_id[0]).sum() == pytest.approx(len(rows), rel=0.1)


def test_the_right_picture_shows_the_sheet_from_beside(first):
    _, _, frames = first
    for frame in frames:
        t = frame.truth
        assert np.linalg.norm(t.T_world_right[:3, 3] - t.T_world_camera[:3, 3]) == pytest.approx(BASELINE_M)
        middle_m = t.T_world_object[0, :3, 3] + [0.0, 0.0, 0.5 * SHEET_M[1]]
        for pose, depth_m in ((t.T_world_camera, t.depth_m), (t.T_world_right, t.right_depth_m)):
            pixel, there_m = project(frame.camera, pose, middle_m)
            column, row = pixel.astype(int)
            assert depth_m[row, column] == pytest.approx(there_m, abs=0.01)
        seen = frame.observation
        assert seen.right_rgb.shape == seen.image_rgb.shape
        assert (seen.right_rgb != seen.image_rgb).mean() > 0.3


def test_observation_and_truth_tell_the_same_settings_and_share_no_memory(first):
    _, _, frames = first
    for k, frame in enumerate(frames):
        observed, t = frame.observation, frame.truth
        assert (observed.settings.exposure_s, observed.settings.gain) == (t.exposure_s, t.gain)
        assert observed.settings.registers == t.registers
        assert t.registers.shutter == pytest.approx(707 * t.exposure_s / LONGEST_EXPOSURE_S, abs=0.51)
        assert t.frame == k
        assert observed.time_s == t.time_s
        for seen in _flat(observed):
            assert not any(np.shares_memory(seen, fact) for fact in _flat(t))


def test_the_larger_view_holds_the_picture_in_its_middle(first):
    preset, _, _ = first
    with closing(PAPER_SHEET.episode(preset, 3)) as episode:
        seen = episode.step().observation.image_rgb
        larger = episode.larger_view(1.5)
    assert larger.shape == (1.5 * seen.shape[0], 1.5 * seen.shape[1], 3)
    top, left = seen.shape[0] // 4, seen.shape[1] // 4
    middle = larger[top:-top, left:-left].astype(int)
    # Each picture has its own noise.
    assert np.abs(middle.mean(axis=(0, 1)) - seen.mean(axis=(0, 1))).max() < 2.0
    assert np.median(np.abs(middle - seen)) < 8


def test_nobody_steers(first):
    preset, _, _ = first
    with pytest.raises(ValueError, match=r"closed_loop: expected None or False, since the camera follows .*, got True"):
        PAPER_SHEET.episode(preset, 0, closed_loop=True)
    with closing(PAPER_SHEET.episode(preset, 0)) as episode:
        with pytest.raises(ValueError, match="command: expected None, since this episode follows a set path"):
            episode.step(CameraCommand(forward_mps=1.0, yaw_rate_rad_s=0.0))
        assert isinstance(episode, SheetEpisode)


@pytest.mark.heavy
def test_after_the_last_frame_there_is_none():
    with closing(PAPER_SHEET.episode("paper-b1", 0)) as episode:
        for _ in range(episode.frame_count):
            episode.step()
        with pytest.raises(StopIteration, match="episode: expected at most 9 steps"):
            episode.step()
