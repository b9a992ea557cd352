"""The measurement of an env's speed, and the soak, in a world without a renderer."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from tests import fakes_scenario
from tests.fakes_scenario import FakeEpisode
from tests.fakes_trackers import NoParameters, Still
from tools.speed import env_stepping as env_speed
from tools.speed import soak
from tools.speed.env_stepping import measure_env, measure_env_steps, measure_scaling, seconds_in_turns
from tools.speed.rendering import UNTIMED_FRAMES
from tools.speed.soak import SoakSample, growth

STEP_S, BARE_S = 0.004, 0.02
FRAMES = 60


def work(seconds: float) -> None:
    """Keep the processor busy."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


class FakeWorld:
    """Is slow at drawing a picture, and slower at taking changes, which are not timed."""

    calls = 0

    def hand_over(self) -> None:
        work(2 * BARE_S)

    def camera_image(self, *arguments: Any, **options: Any) -> None:
        FakeWorld.calls += 1
        work(BARE_S)


def fake_keywords(preset: str) -> dict[str, Any]:
    tracker = Still(NoParameters(), np.random.default_rng(0))
    return {"scenario": "fake-town-v1", "preset": preset, "changes": {"frame_count": FRAMES}, "tracker": tracker}


@pytest.fixture(autouse=True)
def _stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeEpisode, "world", FakeWorld(), raising=False)
    monkeypatch.setattr(env_speed, "TinyRenderer", lambda world: world)
    for module in (env_speed, soak):
        monkeypatch.setattr(module, "env_keywords", fake_keywords)
    FakeWorld.calls = 0


def test_steps_are_timed_against_bare_calls_alone(monkeypatch):
    step = fakes_scenario.FakeEpisode.step

    def slow(self: Any, command: Any = None) -> Any:
        work(STEP_S)
        return step(self, command)

    monkeypatch.setattr(FakeEpisode, "step", slow)
    sample = measure_env_steps("tiny", 0, 16)
    assert (len(sample.step_s), len(sample.bare_s)) == (16, 2)
    assert FakeWorld.calls == 2 * (1 + 2), "a rehearsal, and one call before each run's steps"
    # An env's own work comes on top of the world's.
    assert STEP_S <= np.median(sample.step_s) < 2 * STEP_S
    assert np.median(sample.bare_s) == pytest.approx(BARE_S, rel=0.2)
    assert sample.reset_s >= STEP_S


def test_a_reset_is_to_another_episode_and_to_one_that_is_kept(monkeypatch):
    """A scenario that keeps its latest world begins the same episode again much sooner."""
    init, kept = FakeEpisode.__init__, []

    def slow(self: Any, configuration: Any, closed_loop: bool, phase_s: float) -> None:
        if kept != [phase_s]:
            work(0.1)
        kept[:] = [phase_s]
        init(self, configuration, closed_loop, phase_s)

    monkeypatch.setattr(FakeEpisode, "__init__", slow)
    sample = measure_env_steps("tiny", 0, 16)
    assert sample.cached_reset_s < 0.1 <= sample.reset_s


def test_more_steps_than_an_episode_has_are_refused():
    longest = FRAMES - 1 - UNTIMED_FRAMES
    with pytest.raises(ValueError, match=f"frames: expected at most {longest}, .* got {longest + 1}"):
        measure_env_steps("tiny", 0, longest + 1)


def in_this_process(wanted: list[int]) -> Callable[..., SyncVectorEnv]:
    """Return a maker of vector envs without processes that records the number of envs at a time."""

    def make(envs: list[Any], max_concurrency: int) -> SyncVectorEnv:
        wanted.append(max_concurrency)
        return SyncVectorEnv(envs)

    return make


def test_the_entries_are_those_of_a_summary(monkeypatch):
    monkeypatch.setattr(env_speed, "EnvProcesses", in_this_process([]))
    monkeypatch.setattr(env_speed, "seconds_in_turns", lambda actors, times: [4.0, 2.0, 9.0, 3.0])
    done = []
    entries = measure_env("tiny", range(2), 8, lambda part, of: done.append((part, of)))
    assert [entry["metric"] for entry in entries] == [
        "env_speedup_over_tinyrenderer",
        "env_steps_per_s",
        "env_process_scaling",
        "env_arithmetic_scaling",
        "env_tinyrenderer_cpu_ms",
        "env_reset_cpu_s",
        "env_cached_reset_cpu_s",
    ]
    for entry in entries:
        assert (entry["suite"], entry["tracker"], entry["n"]) == ("speed", "env", 2)
        assert 0 < entry["ci_low"] <= entry["mean"] <= entry["ci_high"] < np.inf
    assert [entry["mean"] for entry in entries[2:4]] == [2.0, 3.0]
    assert done[-1] == (4, 4)


def test_actors_take_turns(monkeypatch):
    clock = {"now_s": 0.0}
    told: list[float] = []

    def actor(seconds: float) -> Callable[[], None]:
        def act() -> None:
            told.append(seconds)
            clock["now_s"] += seconds

        return act

    monkeypatch.setattr(env_speed.time, "perf_counter", lambda: clock["now_s"])
    assert seconds_in_turns((actor(2.0), actor(4.0)), 25) == [50.0, 100.0]
    assert told == 2 * (10 * [2.0] + 10 * [4.0]) + 5 * [2.0] + 5 * [4.0]


@pytest.mark.heavy
def test_resets_do_not_count_as_steps(monkeypatch):
    reset = FakeEpisode.__init__

    def slow(self: Any, *arguments: Any, **options: Any) -> None:
        work(0.1)
        reset(self, *arguments, **options)

    monkeypatch.setattr(FakeEpisode, "__init__", slow)
    at_a_time: list[int] = []
    monkeypatch.setattr(env_speed, "EnvProcesses", in_this_process(at_a_time))
    monkeypatch.setattr(env_speed, "_COUNTED", 10)
    done: list[int] = []
    told = measure_scaling("tiny", range(2), 3, done.append)
    assert at_a_time == [1, 2]
    assert done == [0, 1, 2], "a rehearsal, and each episode"
    assert len(told) == 2
    assert all(0.0 < seconds < 4 * 0.1 for episode in told for seconds in episode[:2])


@pytest.mark.heavy
def test_a_soak_goes_through_episodes_and_weighs_every_process():
    told: list[SoakSample] = []
    samples = soak.soak("tiny", 2 * 3 * FRAMES, 2, told.append, samples=10)
    assert told == samples
    assert samples[-1].steps == 2 * 3 * FRAMES
    # A step of every episode is its reset, which is the step after its last.
    assert samples[-1].episodes == 2 * 4
    assert all(len(each.rss_mib) == 3 and min(each.rss_mib) > 20 for each in samples)


def test_growth_is_what_stays_of_it():
    def samples(mib: Any) -> list[SoakSample]:
        return [SoakSample(k + 1, 0, 0.0, (100.0, float(mib(k)))) for k in range(100)]

    assert growth(samples(lambda k: 300)) == 0.0
    assert growth(samples(lambda k: 100 if k < 20 else 300)) == 0.0
    # 30.5 steps and 90.5 steps after the beginning, on average.
    assert growth(samples(lambda k: 300 + k + 1)) == pytest.approx((400 + 90.5) / (400 + 30.5) - 1)
    assert abs(growth(samples(lambda k: 300 + 40 * (k % 2)))) < 0.01
