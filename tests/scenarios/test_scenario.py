"""Frames, and checks of presets that all scenes share."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest

from scenarios import catalog
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
        infos[name] = truth_info(frame, 0, (frame, estimate), CameraCommand(), NO_REWARD, 0) | {
            "reward": reward["in_view"]
        }
        assert set(infos[name]) >= {*INFO, "reward"}
        assert infos[name]["error_px"] == pytest.approx(5.0)
    assert [infos[name]["in_view"] for name in infos] == [True, False]
    assert [infos[name]["reward"] for name in infos] == [1.0, 0.0]
    assert infos["two"]["position_px"].tolist() == [-99.0, -99.0]
    assert infos["two"]["state"] != infos["one"]["state"]


SHIPPED = [entry.id for entry in catalog.entries() if entry.place.startswith("scenarios.")]
CONFIGURATIONS = [(name, preset) for name in SHIPPED for preset in catalog.scenario(name).presets.values()]


def _first_of_each_kind() -> list[Any]:
    return list({type(preset): preset for _, preset in reversed(CONFIGURATIONS)}.values())


def _numbers(preset: Any) -> list[str]:
    return [f.name for f in fields(preset) if type(getattr(preset, f.name)) in (int, float)]


def _ranges(preset: Any) -> list[str]:
    values = {f.name: getattr(preset, f.name) for f in fields(preset)}
    return [n for n, v in values.items() if isinstance(v, tuple) and len(v) == 2 and type(v[0]) in (int, float)]


@pytest.mark.parametrize("preset", _first_of_each_kind(), ids=lambda preset: type(preset).__name__)
def test_each_number_of_a_preset_has_a_lowest_and_a_highest_value(preset: Any) -> None:
    assert is_dataclass(preset)
    for name in _numbers(preset):
        for value in (-1, 10**9, float("nan"), float("inf")):
            with pytest.raises(ValueError, match=rf"^{name}: expected .*, got [^\n]*$"):
                replace(preset, **{name: value})
    for name in _ranges(preset):
        low, high = getattr(preset, name)
        reversed_range = (high, low) if high > low else (high + 1, low)
        for value in ((-(10**9), high), (low, 10**9), reversed_range, (low, float("nan"))):
            with pytest.raises(ValueError, match=rf"^{name}: expected .*, got [^\n]*$"):
                replace(preset, **{name: type(getattr(preset, name))(value)})


@pytest.mark.parametrize(("name", "preset"), CONFIGURATIONS, ids=lambda given: str(given)[:24])
def test_an_episode_of_any_scene_has_two_frames_or_more(name: str, preset: Any) -> None:
    if "frame_count" not in {f.name for f in fields(preset)}:
        return
    for count in (-1, 0, 1, 10**6):
        with pytest.raises(
            ValueError, match=r"^frame_count: expected (at least \d+|a whole number in \[2, \d+\]).*, got"
        ):
            replace(preset, frame_count=count)
    for rate_hz in (0.0, 1e-6, 1e6):
        with pytest.raises(ValueError, match=r"^rate_hz: expected a number in \[0.\d+, 1000\], got"):
            replace(preset, rate_hz=rate_hz)
