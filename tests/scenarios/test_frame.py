"""Following is judged by the steered camera where an episode has two."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scenarios.envs.reward import Reward, Rewarder
from scenarios.envs.truth_info import INFO, NO_REWARD, truth_info
from scenarios.scenario import Frame
from tests.benchmarks.fake_episode import FakeEpisode
from trackers.types import CameraCommand, CameraModel, Estimate, SteeredCamera

ZOOMED = CameraModel(64, 48, 100.0)


@pytest.fixture
def watched() -> Frame:
    """Return a frame with its target in the picture."""
    return FakeEpisode().step()


def steered(frame: Frame) -> Frame:
    """Return the frame with a second camera that does not see the target."""
    elsewhere = replace(frame.truth, position_px=np.full((1, 2), -99.0), state=np.array(["out"]))
    return replace(frame, observation=replace(frame.observation, steered=SteeredCamera(ZOOMED)), steered=elsewhere)


def test_a_frame_is_judged_by_the_steered_camera_if_there_is_one(watched: Frame) -> None:
    truth, camera = watched.judged
    assert truth is watched.truth
    assert camera is watched.camera is watched.observation.camera
    two = steered(watched)
    truth, camera = two.judged
    assert truth is two.steered
    assert camera is ZOOMED
    assert two.camera == watched.camera


def test_reward_and_info_are_of_the_judged_camera_and_the_estimate_s_error_of_the_watched_one(watched: Frame) -> None:
    estimate = Estimate(watched.truth.position_px[0] + [3.0, 4.0])
    infos = {}
    for name, frame in (("one", watched), ("two", steered(watched))):
        reward = Rewarder(Reward(), 15.0).terms(frame, 0, 0.0)
        infos[name] = truth_info(frame, 0, estimate, CameraCommand(), NO_REWARD, 0) | {"reward": reward["in_view"]}
        assert set(infos[name]) >= {*INFO, "reward"}
        assert infos[name]["error_px"] == pytest.approx(5.0)
    assert [infos[name]["in_view"] for name in infos] == [True, False]
    assert [infos[name]["reward"] for name in infos] == [1.0, 0.0]
    assert infos["two"]["position_px"].tolist() == [-99.0, -99.0]
    assert infos["two"]["state"] != infos["one"]["state"]
