"""The env ids over their own worlds, with pictures of 84 × 84."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from tests.scenarios.envs.compared import assert_same
from trackers.types import CameraCommand

TRACKERS = {
    "frameout/RoadTownFollow-v3": "colour_pf",
    "frameout/StereoFollow-v3": "stereo_wb",
    "frameout/FishTankFollow-v2": "shoal_chain",
    "frameout/HarbourFollow-v1": "harbour_mog2",
    "frameout/FishTankPtz-v1": "panorama_difference",
    "frameout/HarbourPtz-v1": "panorama_difference",
}
NOT_STOOD_IN_FOR = ("frameout/FishTankFollow-v2", "frameout/HarbourFollow-v1")
STEPS, SEED = 6, 21


def keywords(env_id: str) -> dict[str, Any]:
    changes = {"width_px": 84, "height_px": 84}
    scenario = catalog.envs()[env_id][0]
    common = {"preset": "quick", "changes": changes, "observation": "both", "worlds": 0}
    return {"scenario": scenario, "tracker": TRACKERS[env_id]} | common


def rollout(env: FollowEnv) -> tuple[Any, ...]:
    """Return the results of a few steps of one episode."""
    rng = np.random.default_rng(0)
    results = [env.reset(seed=0, options={"episode_seed": SEED})]
    for _ in range(STEPS):
        results.append(env.step(rng.uniform(-1, 1, env.action_space.shape)))
    return tuple(results)


def test_every_scene_s_latest_env_is_tried():
    envs = {entry.env_id for entry in catalog.entries() if entry.place.startswith("scenarios.")}
    assert {catalog.envs()[name][0] for name in TRACKERS} == {
        catalog.scenario(catalog.unversioned(catalog.envs()[name][0])).id for name in envs - {""}
    }


@pytest.mark.heavy
@pytest.mark.parametrize("env_id", TRACKERS)
def test_an_episode_is_the_catalogue_s_byte_for_byte_and_an_env_from_a_pickle_lives_it_again(env_id):
    env = FollowEnv(**keywords(env_id))
    results = rollout(env)
    again = pickle.loads(pickle.dumps(env))
    env.close()
    assert_same(rollout(again), results)
    again.close()
    settings = env.settings
    scenario = catalog.scenario(settings.scenario)
    episode = scenario.episode(settings.configuration({}), SEED, closed_loop=True)
    for observed, *_, info in results:
        assert observed in env.observation_space
        command = CameraCommand(*info["command"].tolist()) if info["frame"] else None
        frame = episode.step(command)
        np.testing.assert_array_equal(frame.observation.image_rgb, observed["pixels"])
        truth, _ = frame.judged
        np.testing.assert_array_equal(truth.T_world_camera, info["T_world_camera"])
        target = truth.index_of(scenario.target)
        np.testing.assert_array_equal(truth.box_xyxy[target], info["box_xyxy"])
        assert truth.visible_fraction[target] == info["visible_fraction"]
    episode.close()


@pytest.mark.heavy
@pytest.mark.parametrize("env_id", NOT_STOOD_IN_FOR)
def test_a_checker_is_content(env_id):
    """The checker with fewer resets, which are slow here.

    Both run on every mode of the env in ``test_follow_env``, in a quick world that stands in for the other scenes.
    """
    env = FollowEnv(**keywords(env_id))
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(env)
    env.close()


@pytest.mark.heavy
def test_two_worlds_in_one_process_do_not_disturb_each_other(capfd):
    envs = SyncVectorEnv([lambda: FollowEnv(**keywords("frameout/RoadTownFollow-v3"))] * 2)
    single = FollowEnv(**keywords("frameout/RoadTownFollow-v3"))
    both = [envs.reset(seed=3)[0]]
    alone = [single.reset(seed=4)[0]]
    for k in range(STEPS):
        actions = np.full(envs.action_space.shape, np.cos(k))
        both.append(envs.step(actions)[0])
        alone.append(single.step(actions[1])[0])
    for pair, one in zip(both, alone, strict=True):
        assert_same({key: pair[key][1] for key in one}, one)
    assert not np.array_equal(both[0]["pixels"][0], both[0]["pixels"][1])
    envs.close()
    # The world that is still open is not the closed one.
    assert single.step(np.zeros(4))[0] in single.observation_space
    single.close()
    lines = [line for line in capfd.readouterr().err.splitlines() if not line.startswith("compiling kernels")]
    assert lines == []
