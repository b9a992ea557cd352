"""The vector env follows Gymnasium: spaces, seeds, resets within the step, errors in one line."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from scenarios.command_link import Link
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.reward import TERMS
from scenarios.envs.truth_info import INFO
from scenarios.road_town.flight import HELICOPTER
from tests.scenarios.envs.pictureless.hand_made import FRAMES, SEEDS, SETTINGS, bank, model
from trackers.belief.features import COMMANDS
from trackers.controllers.catalogue import controller_entry


def envs(count: int = 5, **changes: Any) -> PicturelessVectorEnv:
    return PicturelessVectorEnv(count, **SETTINGS | {"bank": bank(), "model": model()} | changes)


def rollout(made: PicturelessVectorEnv, seed: int, steps: int = 80) -> list[np.ndarray]:
    rng = np.random.default_rng(1)
    outputs = [made.reset(seed=seed)[0]]
    for _ in range(steps):
        observed, rewards, *_ = made.step(rng.uniform(-1, 1, made.action_space.shape or ()).astype(np.float32))
        outputs += [observed, rewards]
    return outputs


@pytest.mark.heavy
@pytest.mark.parametrize("starts", ["episodes", "frame-outs"])
@pytest.mark.parametrize("link", ["prompt", "delayed", "noisy", "late"])
def test_the_same_seed_repeats_everything(starts: str, link: str) -> None:
    first, again, other = (rollout(envs(starts=starts, link=link), seed) for seed in (4, 4, 5))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert any(not np.array_equal(a, b) for a, b in zip(first, other, strict=True))


def test_spaces_contain_what_is_observed_and_rewards_are_sums_of_their_terms() -> None:
    made = envs(starts="frame-outs", max_episode_steps=20)
    observed, infos = made.reset(seed=1)
    assert made.observation_space.contains(observed)
    assert set(infos["episode_seed"]) <= set(SEEDS)
    for _ in range(50):
        observed, rewards, terminated, truncated, infos = made.step(made.action_space.sample())
        assert made.observation_space.contains(observed)
        ended_with = infos.get("final_info", infos)
        np.testing.assert_allclose(rewards, sum(ended_with[f"reward_{term}"] for term in TERMS))
        assert terminated.dtype == truncated.dtype == bool
        assert not terminated.any()


def test_who_ends_begins_anew_within_the_step() -> None:
    made = envs(3)
    made.reset(seed=1, options={"episode_seed": np.array([3, 8, 3])})
    nothing = np.zeros((3, 4))
    for frame in range(1, FRAMES - 1):
        *_, truncated, infos = made.step(nothing)
        assert not truncated.any()
        assert (infos["frame"] == frame).all()
        assert "final_obs" not in infos
    observed, _, _, truncated, infos = made.step(nothing)
    assert truncated.all()
    assert infos["_final_obs"].all()
    assert infos["_final_info"].all()
    assert (infos["final_info"]["frame"] == FRAMES - 1).all()
    assert (infos["final_info"]["reward_in_view"] > 0.0).any()
    assert (infos["frame"] == 0).all()
    assert not any(infos[f"reward_{term}"].any() for term in TERMS)
    assert made.single_observation_space.contains(infos["final_obs"][0])
    assert not np.array_equal(observed[0], infos["final_obs"][0])
    assert (made.states["frame"] == 0).all()
    assert (made.step(nothing)[4]["frame"] == 1).all()


def test_who_ends_begins_anew_in_the_next_step_if_so_asked() -> None:
    made = envs(3, autoreset_mode="NextStep")
    made.reset(seed=1, options={"episode_seed": np.array([3, 8, 3])})
    ways = np.ones((3, 4)), np.zeros((3, 4))
    for _ in range(2):
        for frame in range(1, FRAMES):
            _, _, terminated, truncated, infos = made.step(ways[0])
            assert (infos["frame"] == frame).all()
            assert truncated.all() == (frame == FRAMES - 1)
            assert "final_obs" not in infos
        observed, rewards, terminated, truncated, infos = made.step(ways[1])
        assert (infos["frame"] == 0).all()
        assert not np.any([rewards, terminated, truncated])
        assert made.single_observation_space.contains(observed[0])


def test_without_autoreset_a_mask_chooses_who_begins_anew() -> None:
    made = envs(3, autoreset_mode=AutoresetMode.DISABLED)
    with pytest.raises(ValueError, match="reset_mask: expected every env in the first reset"):
        made.reset(options={"reset_mask": np.array([True, False, False])})
    made.reset(seed=1)
    for _ in range(5):
        made.step(np.zeros((3, 4)))
    mask = np.array([False, True, False])
    before = made.states.copy()
    _, infos = made.reset(options={"reset_mask": mask, "episode_seed": 8})
    np.testing.assert_array_equal(infos["_frame"], mask)
    np.testing.assert_array_equal(made.states["frame"], [5, 0, 5])
    assert infos["episode_seed"][1] == 8
    assert (made.states[~mask] == before[~mask]).all()
    for _ in range(FRAMES - 6):
        *_, truncated, infos = made.step(np.zeros((3, 4)))
    np.testing.assert_array_equal(truncated, ~mask)
    with pytest.raises(gym.error.ResetNeeded, match=r"step: expected a reset with the option reset_mask .* of env 0"):
        made.step(np.zeros((3, 4)))
    made.reset(options={"reset_mask": ~mask})
    assert (made.step(np.zeros((3, 4)))[-1]["frame"] == [1, FRAMES - 5, 1]).all()
    for bad in ([True, False, False], np.zeros(3, dtype=bool), np.ones(3), np.ones(2, dtype=bool)):
        with pytest.raises(ValueError, match=r"reset_mask: expected an array \(3,\) of bool"):
            made.reset(options={"reset_mask": bad})


@pytest.mark.parametrize(
    "wrapper", ["NormalizeObservation", "NormalizeReward", "RecordEpisodeStatistics", "FlattenObservation"]
)
def test_gymnasium_s_wrappers_take_it(wrapper: str) -> None:
    made = getattr(gym.wrappers.vector, wrapper)(envs(3, autoreset_mode="NextStep"))
    made.reset(seed=[1, 2, 3])
    for _ in range(FRAMES + 2):
        observed = made.step(made.action_space.sample())[0]
    assert observed.shape == made.observation_space.shape


def test_a_list_seeds_all_envs_together() -> None:
    first, again, other = (envs(2).reset(seed=seeds)[0] for seeds in ([1, 2], np.array([1, 2]), [1, 3]))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    np.testing.assert_array_equal(envs(2).reset(seed=4)[0], envs(2).reset(seed=[None, 4])[0])


def test_being_lost_may_end_an_episode() -> None:
    made = envs(4, lost_after_s=0.4)
    made.reset(seed=1)
    ends = [made.step(np.zeros((4, 4)))[2].any() for _ in range(FRAMES - 1)]
    # The gust swings the view aside on frame 30.
    assert ends.index(True) == 30 - 1 + 6 - 1


@pytest.mark.heavy
def test_a_gust_is_lost_and_a_controller_follows_until_then() -> None:
    made = envs(2, action="correction", controller="reentry")
    made.reset(seed=1, options={"episode_seed": 3})
    seen = np.array([made.step(np.zeros((2, 4)))[4]["in_view"] for _ in range(FRAMES - 1)])
    assert seen[:28].all()
    assert not seen[30:33].any()
    command = envs(2)
    command.reset(seed=1, options={"episode_seed": 3})
    away = np.tile([-1.0, 0.0, 0.0, 0.0], (2, 1))
    assert not np.array([command.step(away)[4]["in_view"] for _ in range(28)])[-1].any()


def test_corrections_are_for_the_unseen_alone_if_so_asked() -> None:
    always, unseen = (envs(2, action="correction", controller="centre", corrects=when) for when in ("always", "unseen"))
    for made in (always, unseen):
        made.reset(seed=1)
        for _ in range(20):
            made.step(np.ones((2, 4)))
    assert (always.states["obeyed"][:, 3] > 0).all()
    assert (unseen.states["obeyed"][:, 3] == 0).all(), "it saw its target all the time"


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_late_pictures_are_those_of_some_frames_ago_and_rewards_are_of_now(mode: AutoresetMode) -> None:
    delay = 4
    prompt, late = (
        envs(3, autoreset_mode=mode, starts="frame-outs", max_episode_steps=25, link=Link(picture_delay_frames=frames))
        for frames in (0, delay)
    )
    rng, history = np.random.default_rng(3), [[made.reset(seed=2) for made in (prompt, late)]]
    begun = 0
    for k in range(1, 60):
        actions = rng.uniform(-1, 1, (3, 4))
        ours, theirs = prompt.step(actions), late.step(actions)
        for one, other in zip(ours[1:4], theirs[1:4], strict=True):
            np.testing.assert_array_equal(one, other)
        if (ended := ours[3].any()) and mode == AutoresetMode.SAME_STEP:
            begun = k
        history.append([(ours[0], ours[4]), (theirs[0], theirs[4])])
        (seen, infos), (observed, late_infos) = history[max(k - delay, begun)][0], history[k][1]
        np.testing.assert_array_equal(observed[:, :-COMMANDS], seen[:, :-COMMANDS])
        np.testing.assert_array_equal(observed[:, -COMMANDS:], ours[0][:, -COMMANDS:])
        np.testing.assert_array_equal(late_infos["error_px"], infos["error_px"])
        np.testing.assert_array_equal(late_infos["frame"], ours[4]["frame"])
        if ended and mode == AutoresetMode.NEXT_STEP:
            begun = k + 1
        if ended and mode == AutoresetMode.DISABLED:
            break
    assert begun > 0 or mode == AutoresetMode.DISABLED


@pytest.mark.heavy
def test_controllers_of_many_envs_steer_by_late_pictures_as_one_of_a_single_env(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    together = envs(3, action="correction", controller="centre", link="late")
    kernel_less = replace(controller_entry("centre", HELICOPTER.name), kernel=None)
    monkeypatch.setattr("scenarios.envs.pictureless.vector_env.controller_entry", lambda *_: kernel_less)
    alone = envs(3, action="correction", controller="centre", link="late")
    for made in (together, alone):
        made.reset(seed=4)
    for _ in range(FRAMES + 10):
        observed, *_ = together.step(np.zeros((3, 4)))
        np.testing.assert_allclose(observed, alone.step(np.zeros((3, 4)))[0], atol=1e-5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"starts": "anywhere"}, "starts: expected one of"),
        ({"autoreset_mode": "Sometimes"}, "'Sometimes' is not a valid AutoresetMode"),
        ({"foo": 1}, "keywords: expected one of max_episode_steps, .*preset.*; got 'foo'"),
        ({"seeds": [3, -1], "bank": None}, r"seeds: expected whole numbers >= 0, .*, got \[3, -1\]"),
        ({"seeds": [0.5], "bank": None}, r"seeds: expected whole numbers >= 0, .*, got \[0.5\]"),
        ({"observation": "pixels"}, "observation: expected 'track'"),
        ({"randomise": {"traffic_cars": (1, 3)}}, "randomise: expected nothing with a bank"),
        ({"randomise": {"rate_hz": (10, 15)}}, "randomise: expected fields that plans alone depend on, got 'rate_hz'"),
        ({"action": "parameters", "controller": "centre"}, "action: expected one of"),
        ({"preset": "hard"}, "bank: expected episodes of"),
        ({"model": None, "tracker": "hold"}, "tracker: expected one with a model of its errors in "),
    ],
)
def test_errors_say_what_was_expected(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        envs(**changes)


def test_infos_are_those_of_the_rendered_env_and_mask_who_goes_on() -> None:
    made = envs(4, lost_after_s=0.2)
    _, infos = made.reset(seed=1, options={"episode_seed": np.array([3, 3, 8, 8])})
    keys = {name for name in infos if not name.startswith("_")}
    assert keys <= set(INFO)
    for _ in range(FRAMES):
        _, _, terminated, truncated, infos = made.step(np.tile([-1.0, 0.0, 0.0, 0.0], (4, 1)) * [[1], [0], [1], [0]])
        for name in keys:
            kind, shape, _ = INFO[name]
            assert (infos[name].dtype, infos[name].shape) == (np.dtype(kind), (4, *shape)), name
            assert infos[f"_{name}"].all()
        ended = terminated | truncated
        if ended.any() and not ended.all():
            break
    assert ended.any()
    assert not ended.all()
    final = infos["final_info"]
    np.testing.assert_array_equal(infos["_final_info"], ended)
    np.testing.assert_array_equal(final["_frame"], ended)
    assert (final["frame"][ended] > 0).all()
    assert (final["frame"][~ended] == 0).all()
    assert [each is None for each in infos["final_obs"]] == list(~ended)


def test_actions_out_of_range_are_clipped_if_so_asked_and_those_not_finite_refused() -> None:
    clipping, other = envs(2, out_of_range="clip"), envs(2)
    for made in (clipping, other):
        made.reset(seed=3)
    actions = np.array([[5.0, -0.3, -7.0, 1.01], [0.1, 0.2, 0.3, 0.4]])
    np.testing.assert_array_equal(clipping.step(actions)[0], other.step(np.clip(actions, -1.0, 1.0))[0])
    with pytest.raises(ValueError, match=r"action: expected finite numbers of shape \(2, 4\), .* of env 1"):
        clipping.step(np.array([[0.0] * 4, [np.inf] * 4]))


def test_episodes_are_planned_along_a_curriculum_and_those_near_the_progress_are_played(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    planned: list[Any] = []

    def arrays(self: Any, preset: Any, seed: int) -> dict[str, np.ndarray]:
        planned.append(preset)
        return {name: each[0] for name, each in bank().arrays.items()}

    monkeypatch.setattr("scenarios.road_town.pictureless.bank.RoadPictureless.arrays", arrays)
    limits = ((0.0, 1.0), (20.0, 30.0))
    made = envs(64, bank=None, seeds=range(40, 80), randomise={"attitude_noise_deg": limits})
    assert planned == [made.settings.configuration_of(40 + k, share) for k, share in enumerate(np.linspace(0, 1, 40))]
    for progress, first in ((0.0, 0), (0.5, 15), (1.0, 30)):
        made.progress = progress
        _, infos = made.reset(seed=3)
        assert set(infos["episode_seed"] - 40) <= {*range(first, first + 10)}
        assert len(set(infos["episode_seed"])) > 8
    planned.clear()
    plain = envs(64, bank=None, seeds=range(40, 80), randomise={"attitude_noise_deg": (0.0, 1.0)})
    assert planned == [plain.settings.configuration_of(seed) for seed in range(40, 80)]
    plain.progress = 1.0
    assert len(set(plain.reset(seed=3)[1]["episode_seed"])) > 20


def test_steps_are_checked() -> None:
    made = envs(2)
    refusal = pytest.raises(ValueError, match="episode_seed: expected one of the 2 seeds")
    with refusal:
        made.reset(options={"episode_seed": 99})
    with pytest.raises(gym.error.ResetNeeded):
        made.step(np.zeros((2, 4)))
    made.reset(seed=0)
    with pytest.raises(
        ValueError, match=r"action: expected numbers of shape \(2, 4\) .*, got \[0. 0. 2. 0.\] of env 1"
    ):
        made.step(np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]))
    with pytest.raises(ValueError, match=r"action: .*, got \[nan nan nan nan\] of env 0"):
        made.step(np.full((2, 4), np.nan))
    with pytest.raises(ValueError, match=r"action: .*, got shape \(2, 3\)"):
        made.step(np.zeros((2, 3)))
    with refusal:
        made.reset(options={"episode_seed": 99})
    made.close()
    for refused in (made.reset, lambda: made.step(np.zeros((2, 4)))):
        with pytest.raises(gym.error.ClosedEnvironmentError, match="vector env: expected it to be open"):
            refused()
