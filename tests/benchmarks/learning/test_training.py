"""A training yields a policy that steers, continues after a stop, and refuses changed settings."""

from __future__ import annotations

import os
import re
import shlex
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.learning.settings import Training
from benchmarks.learning.training import CHECKPOINT, read_checkpoint, save_checkpoint
from scenarios import catalog
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from scenarios.envs.settings import FollowSettings
from tests.benchmarks.no_room import no_room
from tests.scenarios.envs import stand_in
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.policy import load_policy

pytest.importorskip("stable_baselines3")
import gymnasium as gym
import torch

from benchmarks.learning import evaluation, training
from benchmarks.learning.training import Standing, train
from benchmarks.learning.vector_adapter import GymnasiumVecEnv

STEPS = 2 * 4 * 64 * 4
"""Pictures of two rounds: the learning rate falls to nothing in the last."""
TINY = Training(
    env="frameout/RoadTownFollow-v3",
    preset="quick",
    steps=STEPS,
    envs=4,
    episodes=2,
    episode_steps=40,
    seed=3,
    evaluations=0,
)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Planned episodes are kept in the current folder."""
    monkeypatch.chdir(tmp_path)


def nothing(standing: Standing) -> None:
    pass


def steps_before(out: Path) -> int:
    """Return the number of pictures before the checkpoint in a folder."""
    state = read_checkpoint(out)
    assert state is not None
    return TINY.action_repeat * int(state["steps"])


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int, list[NDArray[np.float32]], set[float]]]:
    """Steps behind and left, weights, and steps of the optimiser at the beginning of every learning.

    A policy alone shows nothing, since one trained from nothing again is the same.
    """
    found = []
    learn = training._learn

    def noted(model: Any, left: int, *rest: Any) -> None:
        layers = [*model.policy.mlp_extractor.policy_net, model.policy.action_net]
        weights = [each.weight.detach().numpy().copy() for each in layers if isinstance(each, torch.nn.Linear)]
        steps = {float(each["step"]) for each in model.policy.optimizer.state.values()}
        found.append((model.num_timesteps, left, weights, steps))
        learn(model, left, *rest)

    monkeypatch.setattr(training, "_learn", noted)
    return found


def test_training_goes_on_from_its_checkpoint_and_leaves_a_policy(tmp_path: Path, begun: list[Any]) -> None:
    path = train(TINY, tmp_path / "ppo", nothing)
    first = load_policy(str(path))
    [(behind, left, weights, optimiser_steps)] = begun
    assert (behind, left, optimiser_steps) == (0, STEPS // 4, set())
    assert any((a != b).any() for a, b in zip(weights, first.weights, strict=True))
    assert first.base is not None
    assert first.base["controller"] == "reentry"
    assert steps_before(tmp_path / "ppo") == STEPS
    # All steps are done: the same call learns nothing, and weights come back from the checkpoint as they were.
    again = load_policy(str(train(TINY, tmp_path / "ppo", nothing)))
    assert len(begun) == 1
    for ours, theirs in zip(first.weights, again.weights, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    # More steps than before: only those that are missing, from these weights, with what the optimiser remembers.
    told: list[int] = []
    more = load_policy(str(train(replace(TINY, steps=2 * STEPS), tmp_path / "ppo", lambda now: told.append(now.done))))
    behind, left, weights, optimiser_steps = begun[1]
    # Two rounds of six epochs, one batch each.
    assert (behind, left, optimiser_steps) == (STEPS // 4, STEPS // 4, {12.0})
    assert told == [STEPS, STEPS + STEPS // 2, 2 * STEPS]
    for ours, theirs in zip(first.weights, weights, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert any((a != b).any() for a, b in zip(first.weights, more.weights, strict=True))
    assert steps_before(tmp_path / "ppo") == 2 * STEPS
    assert controller_entry(f"policy:{path}", "helicopter").create() is not None
    assert not list((tmp_path / "ppo").glob(".*"))
    with pytest.raises(ValueError, match=r"out: expected a folder of the same training, or a new one \(other: seed\)"):
        train(replace(TINY, seed=4), tmp_path / "ppo", nothing)


def test_the_same_training_twice_is_the_same_policy(tmp_path: Path) -> None:
    first, second = (load_policy(str(train(TINY, tmp_path / name, nothing))) for name in ("a", "b"))
    for ours, theirs in zip((*first.weights, *first.biases), (*second.weights, *second.biases), strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("algorithm", ["ppo", "recurrent-ppo"])
def test_a_policy_acts_as_the_model_that_it_was_made_of(algorithm: Any, tmp_path: Path) -> None:
    tiny = replace(TINY, algorithm=algorithm)
    envs = training._envs(tiny, 0)
    model = training._model(tiny, envs, tmp_path, 0)
    envs.obs_rms.mean += 0.1
    policy = training.policy_of(model, tiny, {})
    assert policy.cell_count == (64 if algorithm == "recurrent-ppo" else 0)
    rng, memory, state = np.random.default_rng(2), policy.new_memory(3), None
    for k in range(4):
        seen = rng.uniform(-1, 1, (3, *envs.observation_space.shape)).astype(np.float32)
        wanted, state = model.predict(envs.normalize_obs(seen), state, np.full(3, k == 0), deterministic=True)
        np.testing.assert_allclose(policy.action(seen, memory), wanted, atol=1e-5)
    envs.close()


def test_a_policy_that_remembers_goes_on_with_its_training(tmp_path: Path) -> None:
    tiny = replace(TINY, algorithm="recurrent-ppo")
    first = load_policy(str(train(tiny, tmp_path, nothing)))
    more = load_policy(str(train(replace(tiny, steps=2 * STEPS), tmp_path, nothing)))
    assert any((a != b).any() for a, b in zip(first.cells, more.cells, strict=True))


@pytest.mark.heavy
def test_the_off_policy_method_goes_on_with_what_it_remembers(tmp_path: Path) -> None:
    tiny = replace(TINY, algorithm="sac", steps=400, envs=4, controller="none")
    first = load_policy(str(train(tiny, tmp_path / "sac", nothing)))
    assert first.base is None
    assert first.output == "tanh"
    state = read_checkpoint(tmp_path / "sac")
    assert state is not None
    assert len(state["replay"]["rewards"]) == 25
    more = load_policy(str(train(replace(tiny, steps=800), tmp_path / "sac", nothing)))
    assert any((a != b).any() for a, b in zip(first.weights, more.weights, strict=True))


@pytest.mark.heavy
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("within", ["step", "optimizer"])
def test_a_training_that_is_interrupted_leaves_what_it_has_learnt(
    within: str, number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The signal arrives in a step of the second rollout, or in the first update: the checkpoint is after it."""
    calls = 0
    before = signal.getsignal(number)

    def interrupts(act: Any, at: int) -> Any:
        def acts(*arguments: Any, **keywords: Any) -> Any:
            nonlocal calls
            calls += 1
            if calls == at:
                os.kill(os.getpid(), number)
            return act(*arguments, **keywords)

        return acts

    owner, method, at = (GymnasiumVecEnv, "step_wait", 70) if within == "step" else (torch.optim.Adam, "step", 2)
    monkeypatch.setattr(owner, method, interrupts(getattr(owner, method), at))
    with pytest.raises(KeyboardInterrupt):
        train(TINY, tmp_path, nothing)
    assert steps_before(tmp_path) == STEPS // 2
    assert not (tmp_path / "policy.json").exists()
    assert signal.getsignal(number) == before
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    train(TINY, tmp_path, nothing)
    assert steps_before(tmp_path) == STEPS


def test_there_are_no_worlds_without_pictures() -> None:
    with pytest.raises(ValueError, match="worlds: expected 0 without pictures, where there are none, got 1"):
        PicturelessVectorEnv(2, "road-town-v2", tracker="colour_pf", worlds=1)


def test_a_checkpoint_that_finds_no_room_is_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def save(*arguments: Any) -> None:
        with no_room(1000):
            save_checkpoint(*arguments)

    monkeypatch.setattr("benchmarks.learning.training.save_checkpoint", save)
    words = "train --preset quick --steps 512 --envs 4 --episodes 2 --episode-steps 40 --out full"
    assert main(words.split()) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines()[-1] == "error: full/checkpoint.pt: File too large; what was written before is kept"
    assert not (tmp_path / "full" / CHECKPOINT).exists()


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("env", "frameout/MoonFollow-v1", "env: expected one of frameout/RoadTownFollow-v3"),
        ("steps", 0, "steps: expected a whole number >= 1, got 0"),
        ("seed", -1, "seed: expected a whole number >= 0, got -1"),
    ],
)
def test_what_is_wrong_is_named(name: str, value: object, expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        replace(TINY, **{name: value})  # type: ignore[arg-type]


@pytest.mark.heavy
def test_what_is_told_on_the_way_and_the_command_at_the_end_which_runs_word_for_word(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a world without a renderer, with one episode of the four, in a folder whose name a shell would split."""
    place = f"{stand_in.__name__}:FLOWN"
    scenes = (replace(each, place=place) if each.id == stand_in.FLOWN.id else each for each in catalog._ENTRIES)
    monkeypatch.setattr(catalog, "_ENTRIES", tuple(scenes))
    monkeypatch.setattr(evaluation, "JUDGED", range(9_999, 10_000))
    words = [
        "train",
        "frameout/RoadTownFollow-v3",
        "--pictures",
        "--preset",
        "tiny",
        "--tracker",
        "fake_knowing",
        "--steps",
        "256",
    ]
    assert main([*words, "--envs", "1", "--evaluations", "0", "--out", "a folder"]) == 0
    out, err = capsys.readouterr()
    lines = re.findall(r"([\d,]+) steps: episode reward (\S+), in view (\d+)% of the time, ([\d,]+) steps/s", err)
    assert lines[-1][0] == "256"
    for _, reward, share, rate in lines:
        assert -100.0 < float(reward) <= 239 * 1.2
        assert 0 <= int(share) <= 100
        assert int(rate.replace(",", "")) > 0
    first, _, command = out.splitlines()
    assert first == "policy: a folder/policy.json"
    program, *named = shlex.split(command)
    assert program == "frameout"
    assert main([*named, "--workers", "0"]) == 0
    rows = read_rows(tmp_path / "a folder" / "judged")
    assert {row["controller"] for row in rows} == {"policy:a folder/policy.json", "reentry"}
    assert {row["seed"] for row in rows} == {9_999}
    assert (tmp_path / "a folder" / "judged" / "comparisons.json").is_file()


def test_a_training_tells_its_envs_how_far_it_is() -> None:
    envs = gym.make_vec(TINY.env, 3, pictures=False, seeds=range(2), preset="quick", max_episode_steps=40)
    GymnasiumVecEnv(envs, 4, 0.99).set_attr("progress", 0.25)
    assert envs.progress == 0.25


def test_an_episode_s_reward_and_time_in_view_are_its_own_steps() -> None:
    """Summed here from a second env with the same seed; the step that ends an episode begins the next.

    The helicopter flies off, so that the target is out of view at the end and in view again at once.
    """
    options = {"pictures": False, "seeds": range(2), "preset": "quick", "max_episode_steps": 40}
    ours = GymnasiumVecEnv(gym.make_vec(TINY.env, 3, **options), 4, 0.99)
    theirs = gym.make_vec(TINY.env, 3, **options)
    ours.reset()
    theirs.reset(seed=4)
    rewards, seen = np.zeros(3), np.zeros(3)
    for step in range(1, 81):
        actions = np.array([[1, 1, 0, 0]] * 3, np.float32)
        *_, details = ours.step(actions)
        _, reward, _, truncated, infos = theirs.step(actions)
        rewards += reward
        seen += infos["final_info"]["in_view"] if step % 40 == 0 else infos["in_view"]
        assert truncated.all() == (step % 40 == 0)
        for k in range(3):
            if step % 40:
                assert "episode" not in details[k]
                continue
            episode = details[k]["episode"]
            assert episode["l"] == 40
            assert episode["r"] == pytest.approx(rewards[k])
            assert episode["in_view"] == pytest.approx(seen[k] / 40)
            assert not infos["final_info"]["in_view"][k]
            assert infos["in_view"][k]
            rewards[k] = seen[k] = 0.0


def test_a_step_holds_its_action_and_an_observation_shows_what_changed() -> None:
    """Against the same env, stepped by hand; the second step holds an episode's end."""
    options = {"pictures": False, "seeds": range(2), "preset": "quick", "max_episode_steps": 6}
    ours = GymnasiumVecEnv(gym.make_vec(TINY.env, 2, **options), 4, 0.9, history=2, action_repeat=4)
    theirs = gym.make_vec(TINY.env, 2, **options)
    first, _ = theirs.reset(seed=4)
    np.testing.assert_array_equal(ours.reset(), np.hstack([first, np.zeros((2, 2 * first.shape[1]))]))
    action = np.array([[1, 0.5, 0, 0]] * 2, np.float32)
    seen, rewards = [first], []
    for _ in range(4):
        observed, reward, *_ = theirs.step(action)
        seen.append(observed)
        rewards.append(reward)
    ours.step_async(action)
    observed, reward, ended, _ = ours.step_wait()
    np.testing.assert_array_equal(observed, np.hstack([seen[4], seen[4] - seen[3], seen[4] - seen[2]]))
    np.testing.assert_allclose(reward, 0.1 * sum(0.9**k * each for k, each in enumerate(rewards)), rtol=1e-6)
    assert not ended.any()
    held = [theirs.step(each) for each in (action, action, 0 * action, 0 * action)]
    ours.step_async(action)
    observed, reward, ended, details = ours.step_wait()
    assert ended.all()
    np.testing.assert_allclose(reward, 0.1 * (held[0][1] + 0.9 * held[1][1]), rtol=1e-6)
    last, (began, then, now) = np.stack(held[1][4]["final_obs"]), (each[0] for each in held[1:])
    np.testing.assert_array_equal(observed, np.hstack([now, now - then, now - began]))
    before = held[0][0]
    wanted = np.hstack([last, last - before, last - seen[4]])
    np.testing.assert_array_equal(np.stack([each["terminal_observation"] for each in details]), wanted)
    assert [each["episode"]["l"] for each in details] == [6, 6]


def test_keywords_of_the_env_are_passed_on_unless_an_option_sets_them() -> None:
    assert Training(TINY.env, env_kwargs={"link": "delayed"}).env_keywords["link"] == "delayed"
    with pytest.raises(ValueError, match="env_kwargs: expected none that the training sets by an option of its own"):
        Training(TINY.env, env_kwargs={"preset": "quick"})


@pytest.mark.parametrize(
    "env_id", [each.env_id for each in catalog.entries() if each.place.startswith("scenarios.") and each.env_id]
)
def test_every_env_takes_the_keywords_of_its_training(env_id: str) -> None:
    mine = Training(env_id, pictures=True)
    settings = FollowSettings(mine.scenario, **mine.env_keywords)
    assert settings.preset == catalog.env_preset(mine.scenario)
    assert controller_entry(settings.controller, catalog.scenario(mine.scenario).carrier.name).role == "ours"
