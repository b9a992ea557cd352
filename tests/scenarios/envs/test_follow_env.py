"""The env's contract in a world without a renderer, which runs all of the env's own code."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any, get_args

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from scenarios.command_link import Link
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.observing import ELSEWHERE, FARTHEST_M, OTHERS, TARGET, depth_of, segmentation_of
from scenarios.envs.settings import CHANNELS, ActionMode
from tests import fakes_scenario, fakes_trackers
from tests.fakes_scenario import FAKE_TOWN
from tests.fakes_trackers import Silent, Still
from tests.scenarios.envs.compared import assert_same
from tests.scenarios.envs.stand_in import FRAMES, IDS, fresh, keywords, make, stand_in
from trackers.belief.features import COMMANDS, RANGES
from trackers.types import Estimate, Observation

__all__ = ["stand_in"]
pytestmark = pytest.mark.usefixtures("stand_in")


class Far(Still):
    """Answers with places outside every picture."""

    def misbehave(self, observation: Observation) -> Estimate:
        return Estimate(np.array([1e12, -1e12]), np.array([-1e12, -1e12, 1e12, 1e12]), in_view_probability=1.0)


class Mute(Still):
    """Answers NaN from the first picture on."""

    def misbehave(self, observation: Observation) -> Estimate:
        return Estimate(np.full(2, np.nan))


@pytest.mark.parametrize("env_id", IDS)
@pytest.mark.parametrize("observation", ["track", "pixels", "both"])
@pytest.mark.parametrize("action", get_args(ActionMode))
def test_both_checkers_are_content(env_id, observation, action, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pytest.importorskip("pygame")
    check_env(make(env_id, observation=observation, action=action))
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(make(env_id, observation=observation, action=action, render_mode="rgb_array"))


@pytest.mark.parametrize("observation", ["depth", "segmentation", ("segmentation", "track"), CHANNELS])
def test_gymnasium_s_checker_is_content_with_privileged_channels(observation):
    check_env(make(observation=observation), skip_render_check=True)


def test_channels_are_those_of_the_truth_and_change_nothing_else():
    env, other = make(observation=CHANNELS, link="late"), make(link="late")
    results, theirs = env.reset(seed=3), other.reset(seed=3)
    frames, pixels_seen = [], set()
    for _ in range(FRAMES - 1):
        observed, truth = results[0], env.episode.seen.truth
        frames.append(truth.frame)
        assert_same(observed["depth"], truth.depth_m)
        of_target = truth.instance_map == truth.instance_id[0]
        expected = np.where(of_target, TARGET, np.where(truth.instance_map >= 0, OTHERS, ELSEWHERE))
        np.testing.assert_array_equal(observed["segmentation"], expected)
        pixels_seen |= {*np.unique(observed["segmentation"])}
        assert_same({name: observed[name] for name in ("track", "pixels")}, theirs[0])
        assert_same(results[1:], theirs[1:])
        observed["depth"][:] = 0.0
        results, theirs = env.step(np.full(4, 0.5)), other.step(np.full(4, 0.5))
    assert frames[:6] == [0, 0, 0, 0, 1, 2]
    assert pixels_seen == {ELSEWHERE, TARGET, OTHERS}


def test_nothing_seen_is_at_no_distance_and_a_class_has_its_number():
    truth = replace(
        FAKE_TOWN.episode("tiny", 0).step().truth,
        depth_m=np.array([[np.inf, 2.0, 1e5]], np.float32),
        instance_map=np.array([[-1, 7, 3]], np.int32),
        instance_id=np.array([3, 5, 7]),
        kinds=("boat", "car", "boat"),
    )
    scenario = replace(FAKE_TOWN, classes={"person": "person", "car": "car", "boat": "boat"}, target=truth.names[0])
    np.testing.assert_array_equal(segmentation_of(scenario, truth), [[ELSEWHERE, OTHERS + 2, TARGET]])
    np.testing.assert_array_equal(depth_of(truth), [[0.0, 2.0, FARTHEST_M]])


@pytest.mark.parametrize("env_id", IDS)
def test_the_same_seed_brings_exactly_the_same_and_an_env_from_a_pickle_too(env_id):
    env = make(env_id, link="noisy", render_mode="rgb_array")
    env.reset(seed=1)
    env.step(env.action_space.high)
    again = pickle.loads(pickle.dumps(env))
    assert again.settings.link == "noisy"
    rollouts = []
    for each in (env, again, env):
        rng = np.random.default_rng(2)
        results: list[Any] = [each.reset(seed=9), each.reset()]
        for _ in range(15):
            results.append(each.step(rng.uniform(-1, 1, each.action_space.shape).astype(np.float32)))
        rollouts.append(tuple(results))
    assert_same(rollouts[0], rollouts[1])
    assert_same(rollouts[0], rollouts[2])
    assert rollouts[0][0][1]["episode_seed"] != rollouts[0][1][1]["episode_seed"]


def test_seeds_are_of_development_unless_one_is_asked_for():
    env = make()
    seeds = [env.reset(seed=seed)[1]["episode_seed"] for seed in range(50)]
    assert len(set(seeds)) > 45
    assert max(seeds) < 10_000
    assert env.reset(options={"episode_seed": 12_345})[1]["episode_seed"] == 12_345


def test_an_option_does_not_shift_what_later_resets_draw():
    env, other = make(), make()
    env.reset(seed=4)
    other.reset(seed=4)
    env.reset(options={"episode_seed": 3})
    other.reset()
    assert env.reset()[1]["episode_seed"] == other.reset()[1]["episode_seed"]


def test_a_refused_option_does_not_shift_what_later_resets_draw_either():
    env, other = make(observation="pixels"), make(observation="pixels")
    env.reset(seed=4)
    other.reset(seed=4)
    with pytest.raises(ValueError, match="options: expected pictures of the size"):
        env.reset(options={"changes": {"width_px": 100}})
    assert env.reset()[1]["episode_seed"] == other.reset()[1]["episode_seed"]


@pytest.mark.parametrize("tracker", [Still, Silent, Far])
@pytest.mark.parametrize("env_id", IDS)
def test_spaces_contain_every_observation_and_info_has_the_same_keys_always(env_id, tracker):
    env = make(env_id, tracker=fresh(tracker))
    observed, first = env.reset(seed=0)
    kinds = {key: (type(value), np.shape(value)) for key, value in first.items()}
    states = set()
    for _ in range(FRAMES - 1):
        assert observed in env.observation_space
        assert all(low <= x <= high for x, (low, high) in zip(observed["track"], RANGES.values(), strict=True))
        observed, reward, _, truncated, info = env.step(env.action_space.low)
        assert {key: (type(value), np.shape(value)) for key, value in info.items()} == kinds
        assert reward == pytest.approx(sum(info[key] for key in info if key.startswith("reward_")))
        states.add(info["state"])
    assert truncated
    assert observed in env.observation_space
    assert len(states) > 1, "the target was in view, and out of it"


def test_arrays_are_the_caller_s_own():
    env, other = make(), make()
    observed, info = env.reset(seed=3)
    other.reset(seed=3)
    kept = observed["track"].copy(), observed["pixels"].copy(), info["T_world_camera"].copy()
    theirs = other.step(np.ones(4, dtype=np.float32))
    action = np.ones(4, dtype=np.float32)
    for array in (observed["track"], observed["pixels"], info["T_world_camera"], info["box_xyxy"]):
        array[...] = 0
    ours = env.step(action)
    assert (action == 1).all()
    assert_same(ours, theirs)
    observed, info = env.reset(seed=3)
    env.step(action)
    for was, now in zip(kept, (observed["track"], observed["pixels"], info["T_world_camera"]), strict=True):
        np.testing.assert_array_equal(was, now)


def run(env: FollowEnv) -> tuple[list[Any], list[Any]]:
    """Return observations and infos of an episode steered to and fro."""
    observed, info = env.reset(seed=6)
    observations, infos = [observed], [info]
    for k in range(FRAMES - 1):
        observed, *_, info = env.step(np.full(4, 0.8 * np.cos(0.4 * k), dtype=np.float32))
        observations.append(observed)
        infos.append(info)
    return observations, infos


def test_over_a_late_link_the_policy_sees_what_was_and_truth_and_reward_are_of_now():
    (seen, infos), (late, late_infos) = (run(make(link=Link(picture_delay_frames=frames))) for frames in (0, 4))
    for k, (observed, info) in enumerate(zip(late, late_infos, strict=True)):
        then = max(k - 4, 0)
        assert_same(observed["pixels"], seen[then]["pixels"])
        np.testing.assert_array_equal(observed["track"][:-COMMANDS], seen[then]["track"][:-COMMANDS])
        np.testing.assert_array_equal(observed["track"][-COMMANDS:], seen[k]["track"][-COMMANDS:])
        assert_same(info, infos[k] | {"error_px": infos[then]["error_px"]})
    assert not np.array_equal(seen[20]["track"], seen[16]["track"])


def test_an_observation_does_not_change_when_truth_alone_does(monkeypatch):
    expected, true_infos = run(make())
    original = fakes_scenario.FakeEpisode._truth

    def elsewhere(self: Any, *arguments: Any) -> Any:
        truth = original(self, *arguments)
        places = truth.T_world_object.copy()
        places[:, :3, 3] += 7.0
        box = truth.box_xyxy + 5.0
        return replace(
            truth, position_px=truth.position_px - 31, box_xyxy=box, T_world_object=places, visible_fraction=np.zeros(3)
        )

    monkeypatch.setattr(fakes_scenario.FakeEpisode, "_truth", elsewhere)
    observations, infos = run(make())
    assert_same(tuple(observations), tuple(expected))
    assert any(a["centring"] != b["centring"] for a, b in zip(infos, true_infos, strict=True))


def test_what_a_silent_tracker_does_not_say_is_not_observed(monkeypatch):
    results = {}
    for tracker in (Silent, fakes_trackers.Knowing):
        for turn_rad_s in (0.5, -0.5):
            # The first box is the same; from there the car drives forward or backward.
            monkeypatch.setattr(fakes_scenario, "TURN_RAD_S", turn_rad_s)
            env = make(tracker=fresh(tracker))
            results[tracker, turn_rad_s] = run_from_the_same_place(env)
    assert_same(results[Silent, 0.5][0], results[Silent, -0.5][0])
    assert not np.allclose(results[Silent, 0.5][1], results[Silent, -0.5][1]), "truth differs"
    knows = [results[fakes_trackers.Knowing, turn][0] for turn in (0.5, -0.5)]
    assert not np.allclose(knows[0][-1]["track"], knows[1][-1]["track"]), "a tracker that sees it reports it"


def run_from_the_same_place(env: FollowEnv) -> tuple[tuple[Any, ...], np.ndarray]:
    """Return observations and target places of an episode whose car starts at phase 0."""
    env.reset(options={"episode_seed": 0})
    steps = [env.step(np.full(4, 0.3, dtype=np.float32)) for _ in range(FRAMES - 1)]
    return tuple(step[0] for step in steps), np.array([step[-1]["place_m"] for step in steps])


def test_without_a_reset_and_after_the_end_there_are_no_steps():
    env = make()
    for act in (lambda: env.step(np.zeros(4)), env.render):
        with pytest.raises(gym.error.ResetNeeded):
            act()
    env.reset(seed=0)
    for _ in range(FRAMES - 1):
        env.step(np.zeros(4))
    with pytest.raises(gym.error.ResetNeeded, match="step: expected an episode that runs"):
        env.step(np.zeros(4))
    env.reset()
    env.close()
    env.close()
    with pytest.raises(gym.error.ResetNeeded):
        env.step(np.zeros(4))


def test_an_episode_ends_when_the_target_is_lost_if_so_asked():
    env = make(tracker=fresh(Silent), lost_after_s=0.4)
    env.reset(seed=0)
    for _ in range(FRAMES - 1):
        *_, terminated, truncated, info = env.step(np.array([-1.0, 0, 0, 0]))
        if terminated:
            break
    assert terminated
    assert not truncated
    assert info["frame"] < FRAMES - 1
    assert not info["in_view"]


@pytest.mark.parametrize(("limits", "steps"), [({}, 399), ({"max_episode_steps": 5}, 5)])
def test_an_episode_has_the_frames_that_are_asked_for_unless_a_limit_of_steps_is(limits, steps):
    env = gym.make(IDS[0], **limits, **keywords(changes={"frame_count": 400}, observation="track"))
    env.reset(seed=0)
    assert [env.step(env.action_space.sample())[3] for _ in range(steps)] == [False] * (steps - 1) + [True]


def test_checkers_are_content_with_a_tracker_that_never_answers():
    env = gym.make(IDS[0], disable_env_checker=False, **keywords(tracker=fresh(Mute)))
    check_env(env.unwrapped, skip_render_check=True)
    env.reset(seed=0)
    *_, info = env.step(env.action_space.sample())
    assert info["error_px"] == np.inf


LONGER = {"frame_count": ((5, 5), (25, 25))}


def test_the_training_s_progress_leads_through_a_curriculum():
    env = gym.make(IDS[0], **keywords(randomise=LONGER))
    lengths = []
    for progress in (None, 0.5, 1):
        if progress is not None:
            env.set_wrapper_attr("progress", progress)
        env.reset(seed=1)
        lengths.append(env.unwrapped.episode.episode.frame_count)
    assert lengths == [5, 15, 25]
    env.reset(options={"progress": 0.0})
    assert env.unwrapped.episode.episode.frame_count == 5
    assert env.get_wrapper_attr("progress") == 1
    with pytest.raises(ValueError, match="progress: expected a number from 0 to 1, got 2"):
        env.set_wrapper_attr("progress", 2)
