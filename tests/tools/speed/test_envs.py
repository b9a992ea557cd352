"""The speed of envs: steps, resets and processes, in a world without a renderer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.settings import WORLDS
from scenarios.envs.vectors import FollowVectorEnv
from tests.fakes_scenario import FakeEpisode
from tests.fakes_trackers import NoParameters, Still
from tests.tools.speed.conftest import BARE_S, FakeWorld, work
from tools.speed import envs
from tools.speed.envs import episode_times, measure_env, seconds_in_turns, step_times
from tools.speed.figures import UNTIMED_FRAMES, Figure

STEP_S = 0.004
FRAMES = 60


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
    step_s, bare_s = step_times("tiny", 0, 16)
    assert FakeWorld.calls == 2 * (1 + 2), "a rehearsal, and one call before each run's steps"
    # An env's own work comes on top of the world's.
    assert STEP_S <= step_s < 3 * STEP_S
    assert bare_s == pytest.approx(BARE_S, rel=0.3)


def test_episodes_with_resets_are_new_and_in_one_world(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scenario that keeps its latest episode, or world, begins it again much sooner."""
    init, seeds = FakeEpisode.__init__, []
    reset = FollowEnv.reset

    def noted(self: Any, **options: Any) -> Any:
        seeds.append(options["options"]["episode_seed"])
        return reset(self, **options)

    def slow(self: Any, *arguments: Any, **options: Any) -> None:
        work(0.1)
        init(self, *arguments, **options)

    monkeypatch.setattr(FollowEnv, "reset", noted)
    monkeypatch.setattr(FakeEpisode, "__init__", slow)
    whole_s, resets_s, steps = episode_times("tiny", 3)
    assert len(set(seeds)) == len(seeds) == 4
    assert {seed % WORLDS for seed in seeds} == {3}
    assert steps == 3 * (FRAMES - 1)
    assert 3 * 0.1 <= resets_s < whole_s


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

    counts: list[tuple[int, int]] = []

    def in_this_process(num_envs: int, workers: int, **keywords: Any) -> FollowVectorEnv:
        counts.append((num_envs, workers))
        return FollowVectorEnv(num_envs, workers=0, **keywords)

    monkeypatch.setattr(FakeEpisode, "__init__", slow)
    monkeypatch.setattr(envs, "FollowVectorEnv", in_this_process)
    monkeypatch.setattr(envs, "_COUNTED", 10)
    figures = measure_env("tiny", 8, 0)
    assert counts == [(8, 2)]
    scaling = figures["env_process_scaling"]
    assert all(0.0 < seconds < 8 * 0.1 for seconds in scaling[:2])
    assert scaling.above == pytest.approx(scaling.below, rel=0.5), "eight steps of one, a step of eight"
    assert 0.1 <= figures["env_reset_cpu_s"].above < 0.3
    assert figures["env_world_cpu_s"].above == 0.0
    assert ratios_of(figures)["env_steps_per_s_with_resets"] < FRAMES / 0.1
    ratios = ratios_of(figures)
    assert ratios["env_speedup_over_tinyrenderer"] == pytest.approx(BARE_S * ratios["env_steps_per_s"], rel=0.3)
    assert {each.unit for each in figures.values()} == {"ratio", "1/s", "s"}
    assert set(figures) == {
        "env_speedup_over_tinyrenderer",
        "env_steps_per_s",
        "env_steps_per_s_with_resets",
        "env_process_scaling",
        "env_arithmetic_scaling",
        "env_reset_cpu_s",
        "env_world_cpu_s",
    }


def ratios_of(figures: Mapping[str, Figure]) -> dict[str, float]:
    return {name: each.above / each.below for name, each in figures.items()}
