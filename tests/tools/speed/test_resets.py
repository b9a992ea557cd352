"""The measurement of throughput with resets and without, in a world without a renderer."""

from __future__ import annotations

import json
import re
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.learning.training import Training
from scenarios import catalog
from scenarios.envs.settings import FollowSettings
from tests.tools.command import tools
from tools.speed import resets
from tools.speed.rendering import UNTIMED_FRAMES
from tools.speed.resets import CycleSample, measure_cycle, measure_resets
from trackers.controllers.catalogue import controller_entry

RESET_S, WORLD_S, FIRST_S, STEP_S = 0.5, 4.0, 0.3, 0.01
TRAINING = Training("frameout/RoadTownFollow-v2", pictures=True, episodes_per_world=4)


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
        FakeEnv.now_s += FIRST_S if self._steps < UNTIMED_FRAMES else STEP_S
        self._steps += 1

    def close(self) -> None:
        """There is nothing to free."""


@pytest.fixture(autouse=True)
def _by_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resets, "FollowEnv", FakeEnv)
    monkeypatch.setattr(time, "process_time", lambda: FakeEnv.now_s)


def test_a_cycle_has_one_new_world_and_whole_episodes_are_reckoned_from_parts():
    sample = measure_cycle(TRAINING, 0, 6)
    assert sample.reset_s == pytest.approx((WORLD_S, RESET_S, RESET_S, RESET_S))
    assert sample.first_s == pytest.approx((UNTIMED_FRAMES * FIRST_S,) * 4)
    assert np.shape(sample.step_s) == (4, 6)
    assert sample.steps_per_s == pytest.approx(1 / STEP_S)
    # An episode of 300 frames has 299 steps.
    four_s = WORLD_S + 3 * RESET_S + 4 * (UNTIMED_FRAMES * FIRST_S + (299 - UNTIMED_FRAMES) * STEP_S)
    assert sample.steps_per_s_with_resets == pytest.approx(4 * 299 / four_s)


def test_without_kept_worlds_every_reset_builds_one():
    sample = measure_cycle(Training("frameout/RoadTownFollow-v2", pictures=True, worlds=0), 0, 6)
    assert sample.reset_s == pytest.approx((WORLD_S,))


@pytest.mark.parametrize(
    "env_id", [each.env_id for each in catalog.entries() if each.place.startswith("scenarios.") and each.env_id]
)
def test_every_env_takes_the_keywords_of_its_training(env_id):
    training = Training(env_id, pictures=True)
    settings = FollowSettings(training.scenario, **training.env_keywords)
    assert settings.preset == catalog.env_preset(training.scenario)
    assert controller_entry(settings.controller, catalog.scenario(training.scenario).carrier.name).role == "ours"


def test_more_steps_than_an_episode_has_are_refused():
    with pytest.raises(ValueError, match="frames: expected at most 294, got 295"):
        measure_cycle(TRAINING, 0, 295)


def test_the_entries_are_those_of_a_summary(monkeypatch):
    samples = iter([CycleSample((2.0, 1.0), (0.0, 0.0), ((0.01,), (0.01,)), 305)] * 2)
    monkeypatch.setattr(resets, "measure_cycle", lambda *arguments: next(samples))
    done: list[tuple[int, int]] = []
    env_id = "frameout/StereoFollow-v2"
    entries = measure_resets(env_id, "standard", range(2), 6, lambda part, of: done.append((part, of)))
    assert {entry["metric"]: entry["mean"] for entry in entries} == pytest.approx(
        {
            "training_steps_per_s_without_resets": 100.0,
            "training_steps_per_s_with_resets": 305 / 4.5,
            "training_reset_throughput": 3.05 / 4.5,
            "training_new_world_reset_cpu_s": 2.0,
            "training_reset_cpu_s": 1.5,
        }
    )
    assert {(entry["scenario"], entry["tracker"], entry["n"]) for entry in entries} == {("stereo-follow-v2", "env", 2)}
    assert done == [(0, 2), (1, 2), (2, 2)]


def test_the_command_measures_each_env_of_the_scenario(monkeypatch, tmp_path, capsys):
    cycles: list[tuple[str, int, int]] = []

    def cycle(training: Training, seed: int, frames: int) -> CycleSample:
        cycles.append((training.env, seed, frames))
        return CycleSample((2.0, 1.0), (0.0, 0.0), ((0.01,), (0.01,)), 305)

    monkeypatch.setattr(resets, "measure_cycle", cycle)
    words = ["speed", "stereo-follow", "--resets", "--seeds", "3:5", "--frames", "20", "--out", str(tmp_path)]
    assert tools(words) == 0
    assert cycles == [("frameout/StereoFollow-v2", seed, 20) for seed in (3, 4)]
    told = re.search(r"training_reset_throughput .*?(\d\.\d\d) ", capsys.readouterr().out)
    assert told is not None
    assert float(told[1]) == pytest.approx(3.05 / 4.5, abs=0.005)
    kept = json.loads((tmp_path / "summary.json").read_text())
    assert {entry["metric"] for entry in kept} >= {"training_reset_throughput", "training_reset_cpu_s"}
