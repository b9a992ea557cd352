"""An env without a tracker: the picture is all that is observed, and reward and ``info`` are as with one."""

from __future__ import annotations

import contextlib
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from scenarios.envs import follow_env
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.vectors import FollowVectorEnv
from tests.fakes_scenario import FAKE_TOWN
from tests.scenarios.envs.compared import assert_same
from tests.scenarios.envs.stand_in import FRAMES, IDS, keywords, make, stand_in

__all__ = ["stand_in"]
ALONE: dict[str, Any] = {"tracker": None, "observation": "pixels"}


@pytest.mark.usefixtures("stand_in")
@pytest.mark.parametrize("env_id", IDS)
def test_both_checkers_are_content(env_id: str) -> None:
    check_env(make(env_id, **ALONE), skip_render_check=True)
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(make(env_id, **ALONE, render_mode="rgb_array"))


@pytest.mark.usefixtures("stand_in")
def test_pictures_rewards_and_truth_are_those_of_an_env_with_a_tracker(monkeypatch: pytest.MonkeyPatch) -> None:
    """All but the error of its estimate, which nobody makes; nor is a belief computed."""
    watched = make(observation="pixels", lost_after_s=0.4)
    theirs: Any = watched.reset(seed=5)
    monkeypatch.setattr(follow_env, "FeatureFilter", None)
    alone = make(**ALONE, lost_after_s=0.4)
    ours: Any = alone.reset(seed=5)
    ended = False
    for k in range(FRAMES):
        assert np.isfinite(theirs[-1].pop("error_px"))
        assert ours[0] in alone.observation_space
        assert_same(ours, theirs)
        if ended:
            break
        action = np.full(4, 0.9 if k > 5 else 0.0, np.float32)
        theirs, ours = watched.step(action), alone.step(action)
        ended = ours[2] or ours[3]
    assert ended


@pytest.mark.parametrize(
    ("others", "told"),
    [
        ({}, "observation: expected no track with tracker=None, got 'track'"),
        ({"observation": "both"}, "observation: expected no track with tracker=None, got 'both'"),
        (ALONE | {"action": "correction"}, "action: expected 'command' with tracker=None, as .*, got 'correction'"),
        (ALONE | {"action": "parameters"}, "action: expected 'command' with tracker=None, as .*, got 'parameters'"),
    ],
)
def test_what_needs_a_tracker_is_refused(others: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        gym.make(IDS[0], **{"tracker": None, "preset": "quick"} | others)


@pytest.mark.heavy
@pytest.mark.parametrize(("workers", "count"), [(0, 2), (1, 1)])
def test_they_run_side_by_side_and_in_processes_of_their_own(workers: int, count: int) -> None:
    single = [FollowEnv(FAKE_TOWN.id, **keywords(**ALONE)) for _ in range(count)]
    made = FollowVectorEnv(count, workers=workers, scenario=FAKE_TOWN.id, **keywords(**ALONE))
    with contextlib.closing(made) as envs:
        pictures, _ = envs.reset(seed=3)
        for k, env in enumerate(single):
            np.testing.assert_array_equal(pictures[k], env.reset(seed=3 + k)[0])
        actions = np.ones(envs.action_space.shape, np.float32)
        pictures, rewards, *_ = envs.step(actions)
        for k, env in enumerate(single):
            mine = env.step(actions[k])
            np.testing.assert_array_equal(pictures[k], mine[0])
            assert rewards[k] == mine[1]
