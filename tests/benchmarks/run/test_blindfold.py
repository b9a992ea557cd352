"""A blind tracker gets no picture, and of the truth only the state at the start and at each exit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.tracker_spec import TrackerSpec
from benchmarks.run.blindfold import Blindfolded
from benchmarks.run.episodes import simulated
from benchmarks.run.selection import Registered, trackers_of
from scenarios.scenario import Frame
from tests.fakes_scenario import FAKE_TOWN
from tests.fakes_trackers import NoParameters
from trackers.baselines.single_target import Hold, HoldParameters
from trackers.protocols import TargetState
from trackers.types import Estimate, Observation

NAMED = simulated(FAKE_TOWN.id, "tiny", 0)
EPISODE = NAMED.open("all")
FRAMES = [EPISODE.step() for _ in range(EPISODE.frame_count)]
BLIND = [
    spec
    for spec in trackers_of().values()
    if isinstance(spec, Registered) and spec.role == "blind" and not spec.entry.follows_many
]
"""Those of many targets are called on no frame at all, see tests/toy_scene/test_hindsight.py."""
CARRYING = [spec for spec in BLIND if spec.name in ("blind_carried", "blind_straight", "blind_turning")]


class Spy:
    """A blind tracker that records its inputs."""

    def __init__(self) -> None:
        self.seen: list[Observation] = []
        self.told_at_s: list[float] = []

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        self.seen.append(observation)

    def set_state(self, observation: Observation, state: TargetState) -> None:
        self.told_at_s.append(observation.time_s)

    def update(self, observation: Observation) -> Estimate:
        self.seen.append(observation)
        return Estimate(np.zeros(2))


def answers(spec: TrackerSpec, frames: list[Frame]) -> NDArray[np.float64]:
    """Return the positions (F - 1, 2) that a fresh tracker answers."""
    tracker = spec.create(NAMED, EPISODE, np.random.default_rng(0))
    tracker.initialise(frames[0], EPISODE.start)
    return np.array([tracker.update(frame).position_px for frame in frames[1:]])


def is_told(frame: Frame) -> bool:
    return frame.truth.frame == 0 or frame.truth.frames_since_exit[0] == 0


def with_noise(frame: Frame, rng: np.random.Generator) -> Frame:
    """Return the frame with other pictures and settings."""
    noise = rng.integers(0, 256, frame.observation.image_rgb.shape, np.uint8)
    return replace(frame, observation=replace(frame.observation, image_rgb=noise, right_rgb=noise, settings=None))


def scrambled(frame: Frame, rng: np.random.Generator) -> Frame:
    """Return the frame with all true places falsified, but not its exits."""
    truth = frame.truth
    T_world_object, T_world_camera = truth.T_world_object.copy(), truth.T_world_camera.copy()
    T_world_object[:, :2, 3] += rng.normal(0, 30, (len(truth.names), 2))
    T_world_camera[:2, 3] += rng.normal(0, 30, 2)
    return replace(
        frame,
        truth=replace(
            truth,
            T_world_object=T_world_object,
            T_world_camera=T_world_camera,
            speed_mps=rng.uniform(0, 50, len(truth.names)),
            position_px=rng.normal(0, 500, truth.position_px.shape),
            box_xyxy=rng.normal(0, 500, truth.box_xyxy.shape),
            visible_fraction=rng.uniform(0, 1, len(truth.names)),
        ),
    )


def test_the_episode_has_exits_to_be_told_of() -> None:
    assert sum(map(is_told, FRAMES)) >= 2
    assert {suite for spec in BLIND for suite in spec.suites} == {"frame-out", "stereo"}


def test_no_picture_and_no_reading_of_the_light_reach_it() -> None:
    spy, rng = Spy(), np.random.default_rng(1)
    tracker = Blindfolded(spy, FAKE_TOWN.target)
    frames = [with_noise(frame, rng) for frame in FRAMES]
    tracker.initialise(frames[0], EPISODE.start)
    for frame in frames[1:]:
        tracker.update(frame)
    assert all(seen.image_rgb.size == 0 and seen.right_rgb is None and seen.settings is None for seen in spy.seen)
    assert [seen.time_s for seen in spy.seen] == [frame.observation.time_s for frame in frames]
    assert spy.told_at_s == [frame.observation.time_s for frame in frames if is_told(frame)]


@pytest.mark.parametrize("spec", BLIND, ids=lambda spec: spec.name)
def test_noise_in_the_picture_changes_no_answer(spec: TrackerSpec) -> None:
    rng = np.random.default_rng(2)
    assert np.array_equal(answers(spec, [with_noise(frame, rng) for frame in FRAMES]), answers(spec, FRAMES))


@pytest.mark.parametrize("spec", BLIND, ids=lambda spec: spec.name)
def test_no_truth_reaches_it_between_exits(spec: TrackerSpec) -> None:
    rng = np.random.default_rng(3)
    frames = [frame if is_told(frame) else scrambled(frame, rng) for frame in FRAMES]
    assert np.array_equal(answers(spec, frames), answers(spec, FRAMES))


@pytest.mark.parametrize("spec", CARRYING, ids=lambda spec: spec.name)
def test_the_state_at_the_exit_reaches_it(spec: TrackerSpec) -> None:
    said = answers(spec, FRAMES)
    for frame in FRAMES[1:]:
        if is_told(frame):
            truth = frame.truth
            assert said[truth.frame - 1] == pytest.approx(truth.position_px[0], abs=1e-6)
    rng = np.random.default_rng(4)
    false = answers(spec, [scrambled(frame, rng) if is_told(frame) else frame for frame in FRAMES])
    assert (np.abs(false - said).max(axis=1) > 1.0).all()


def test_a_tracker_that_cannot_be_told_is_refused() -> None:
    with pytest.raises(TypeError, match="tracker: expected one with a method set_state, since its role is blind"):
        Blindfolded(Hold(HoldParameters(), np.random.default_rng(0)), FAKE_TOWN.target)


def test_what_is_told_is_seen_from_the_camera() -> None:
    """Turned with the camera and counted from it, so that errors of its measured pose persist as it moves."""
    states: list[TargetState] = []

    class Listener(Spy):
        Parameters = NoParameters

        def set_state(self, observation: Observation, state: TargetState) -> None:
            states.append(state)

    Blindfolded(Listener(), FAKE_TOWN.target).initialise(FRAMES[0], EPISODE.start)
    truth = FRAMES[0].truth
    pose = truth.T_world_camera
    in_world_m = pose[:3, :3] @ states[0].place_m + pose[:3, 3]
    assert in_world_m == pytest.approx(truth.T_world_object[0, :3, 3] + [0, 0, 0.5 * truth.size_m[0, 2]])
    assert np.linalg.norm(states[0].velocity_mps) == pytest.approx(truth.speed_mps[0])
    assert pose[:3, :3] @ states[0].velocity_mps == pytest.approx(truth.speed_mps[0] * truth.T_world_object[0, :3, 0])
