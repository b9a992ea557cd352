"""The speed of envs: steps, resets and processes, in a world without a renderer."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from benchmarks.learning.training import Training
from scenarios import catalog
from scenarios.envs.settings import FollowSettings
from tests.fakes_scenario import FakeEpisode
from tests.fakes_trackers import NoParameters, Still
from tests.tools.speed.conftest import BARE_S, FakeWorld, work
from tools.speed import envs
from tools.speed.envs import measure_resets, scaling_times, seconds_in_turns, step_times
from tools.speed.figures import UNTIMED_FRAMES
from trackers.controllers.catalogue import controller_entry

STEP_S = 0.004
FRAMES = 60
RESET_S, WORLD_S, FIRST_S, LATER_S = 0.5, 4.0, 0.3, 0.01
TRAINING = Training("frameout/RoadTownFollow-v2", pictures=True, episodes_per_world=4)


def fake_keywords(preset: str) -> dict[str, Any]:
    tracker = Still(NoParameters(), np.random.default_rng(0))
    return {"scenario": "fake-town-v1", "preset": preset, "changes": {"frame_count": FRAMES}, "tracker": tracker}


@pytest.fixture(autouse=True)
def _fake_town(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeEpisode, "world", FakeWorld(), raising=False)
    monkeypatch.setattr(envs, "env_keywords", fake_keywords)


def test_steps_are_timed_against_bare_calls_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    step = FakeEpisode.step

    def slow(self: Any, command: Any = None) -> Any:
        work(STEP_S)
        return step(self, command)

    monkeypatch.setattr(FakeEpisode, "step", slow)
    step_s, bare_s, reset_s, _ = step_times("tiny", 0, 16)
    assert FakeWorld.calls == 2 * (1 + 2), "a rehearsal, and one call before each run's steps"
    # An env's own work comes on top of the world's.
    assert STEP_S <= step_s < 3 * STEP_S
    assert bare_s == pytest.approx(BARE_S, rel=0.3)
    assert reset_s >= STEP_S


def test_a_reset_is_to_another_episode_and_to_one_that_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scenario that keeps its latest world begins the same episode again much sooner."""
    init, kept = FakeEpisode.__init__, []

    def slow(self: Any, configuration: Any, closed_loop: bool, phase_s: float) -> None:
        if kept != [phase_s]:
            work(0.1)
        kept[:] = [phase_s]
        init(self, configuration, closed_loop, phase_s)

    monkeypatch.setattr(FakeEpisode, "__init__", slow)
    _, _, reset_s, cached_reset_s = step_times("tiny", 0, 16)
    assert cached_reset_s < 0.1 <= reset_s


def test_more_steps_than_an_episode_has_are_refused() -> None:
    longest = FRAMES - 1 - UNTIMED_FRAMES
    with pytest.raises(ValueError, match=f"frames: expected at most {longest}, .* got {longest + 1}"):
        step_times("tiny", 0, longest + 1)


def test_actors_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = {"now_s": 0.0}
    acted: list[float] = []

    def actor(seconds: float) -> Callable[[], None]:
        def act() -> None:
            acted.append(seconds)
            clock["now_s"] += seconds

        return act

    monkeypatch.setattr(envs.time, "perf_counter", lambda: clock["now_s"])
    assert seconds_in_turns((actor(2.0), actor(4.0)), 25) == [50.0, 100.0]
    assert acted == 2 * (10 * [2.0] + 10 * [4.0]) + 5 * [2.0] + 5 * [4.0]


@pytest.mark.heavy
def test_resets_do_not_count_as_steps_of_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    reset = FakeEpisode.__init__

    def slow(self: Any, *arguments: Any, **options: Any) -> None:
        work(0.1)
        reset(self, *arguments, **options)

    at_a_time: list[int] = []

    def in_this_process(made: list[Any], max_concurrency: int) -> SyncVectorEnv:
        at_a_time.append(max_concurrency)
        return SyncVectorEnv(made)

    monkeypatch.setattr(FakeEpisode, "__init__", slow)
    monkeypatch.setattr(envs, "EnvProcesses", in_this_process)
    monkeypatch.setattr(envs, "_COUNTED", 10)
    taken_s = scaling_times("tiny", 0, 3)
    assert at_a_time == [1, 2]
    assert len(taken_s) == 4
    assert all(0.0 < seconds < 4 * 0.1 for seconds in taken_s[:2])


class FakeEnv:
    """Takes its time by a clock of its own; every fourth reset builds a world."""

    now_s = 0.0
    resets = 0

    def __init__(self, scenario: str, **settings: Any) -> None:
        self.settings = SimpleNamespace(
            worlds=settings["worlds"],
            episodes_per_world=settings["episodes_per_world"],
            configuration=lambda drawn: SimpleNamespace(frame_count=300),
        )
        self.action_space = SimpleNamespace(shape=(4,))

    def reset(self, seed: int | None = None) -> None:
        FakeEnv.resets = 0 if seed is not None else FakeEnv.resets + 1
        self._steps = 0
        every = self.settings.episodes_per_world if self.settings.worlds else 1
        FakeEnv.now_s += WORLD_S if FakeEnv.resets % every == 0 else RESET_S

    def step(self, action: np.ndarray) -> None:
        assert action.shape == (4,)
        FakeEnv.now_s += FIRST_S if self._steps < UNTIMED_FRAMES else LATER_S
        self._steps += 1

    def close(self) -> None:
        """There is nothing to free."""


@pytest.fixture
def by_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(envs, "FollowEnv", FakeEnv)
    monkeypatch.setattr(time, "process_time", lambda: FakeEnv.now_s)


def test_a_cycle_has_one_new_world_and_whole_episodes_are_reckoned_from_parts(by_the_clock: None) -> None:
    figures = {metric: each.above / each.below for metric, each in measure_resets(TRAINING, 6, 0).items()}
    # An episode of 300 frames has 299 steps.
    four_s = WORLD_S + 3 * RESET_S + 4 * (UNTIMED_FRAMES * FIRST_S + (299 - UNTIMED_FRAMES) * LATER_S)
    assert figures == pytest.approx(
        {
            "training_steps_per_s_without_resets": 1 / LATER_S,
            "training_steps_per_s_with_resets": 4 * 299 / four_s,
            "training_reset_throughput": 4 * 299 * LATER_S / four_s,
            "training_new_world_reset_cpu_s": WORLD_S,
            "training_reset_cpu_s": (WORLD_S + 3 * RESET_S) / 4,
        }
    )
    with pytest.raises(ValueError, match="frames: expected at most 294, got 295"):
        measure_resets(TRAINING, 295, 0)


def test_without_kept_worlds_every_reset_builds_one(by_the_clock: None) -> None:
    figures = measure_resets(Training("frameout/RoadTownFollow-v2", pictures=True, worlds=0), 6, 0)
    assert figures["training_reset_cpu_s"].above == pytest.approx(WORLD_S)


@pytest.mark.parametrize(
    "env_id", [each.env_id for each in catalog.entries() if each.place.startswith("scenarios.") and each.env_id]
)
def test_every_env_takes_the_keywords_of_its_training(env_id: str) -> None:
    training = Training(env_id, pictures=True)
    settings = FollowSettings(training.scenario, **training.env_keywords)
    assert settings.preset == catalog.env_preset(training.scenario)
    assert controller_entry(settings.controller, catalog.scenario(training.scenario).carrier.name).role == "ours"
