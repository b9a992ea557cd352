"""A training yields a policy that steers, continues after a stop, and refuses changed settings."""

from __future__ import annotations

import json
import os
import signal
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.cli.main import main
from benchmarks.learning.training import Training, checkpointed_settings, save_checkpoint
from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv
from tests.benchmarks.no_room import no_room
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.policy import load_policy

pytest.importorskip("stable_baselines3")
import torch

from benchmarks.learning import training
from benchmarks.learning.training import Standing, train
from benchmarks.learning.vector_adapter import GymnasiumVecEnv

STEPS = 2 * 4 * 128
"""Two rounds: the learning rate falls to nothing in the last."""
TINY = Training(
    env="frameout/RoadTownFollow-v2", preset="quick", steps=STEPS, envs=4, episodes=2, episode_steps=40, seed=3
)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Planned episodes are kept in the current folder."""
    monkeypatch.chdir(tmp_path)


def nothing(standing: Standing) -> None:
    pass


@dataclass
class Begun:
    """What a model was when its learning began: steps behind it and left, its weights, steps of its optimiser."""

    behind: int
    left: int
    weights: list[NDArray[np.float32]]
    optimiser_steps: set[float]


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[Begun]:
    """Every learning that begins: a policy alone shows nothing, since one trained from nothing again is the same."""
    found: list[Begun] = []
    learn = training._learn

    def noted(model: Any, left: int, *rest: Any) -> None:
        layers = [*model.policy.mlp_extractor.policy_net, model.policy.action_net]
        weights = [each.weight.detach().numpy().copy() for each in layers if isinstance(each, torch.nn.Linear)]
        steps = {float(each["step"]) for each in model.policy.optimizer.state.values()}
        found.append(Begun(model.num_timesteps, left, weights, steps))
        learn(model, left, *rest)

    monkeypatch.setattr(training, "_learn", noted)
    return found


def test_training_goes_on_from_its_checkpoint_and_leaves_a_policy(tmp_path: Path, begun: list[Begun]) -> None:
    path = train(TINY, tmp_path / "ppo", nothing)
    first = load_policy(str(path))
    assert [(each.behind, each.left, each.optimiser_steps) for each in begun] == [(0, STEPS, set())]
    assert any((a != b).any() for a, b in zip(begun[0].weights, first.weights, strict=True))
    assert first.base is not None
    assert first.base["controller"] == "reentry"
    state = json.loads((tmp_path / "ppo" / "checkpoint" / "state.json").read_text())
    assert state["steps"] == STEPS
    # All steps are done: the same call learns nothing, and weights come back from the checkpoint as they were.
    again = load_policy(str(train(TINY, tmp_path / "ppo", nothing)))
    assert len(begun) == 1
    for ours, theirs in zip(first.weights, again.weights, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    # More steps than before: only those that are missing, from these weights, with what the optimiser remembers.
    told: list[int] = []
    more = load_policy(str(train(replace(TINY, steps=2 * STEPS), tmp_path / "ppo", lambda now: told.append(now.done))))
    assert (begun[1].behind, begun[1].left) == (STEPS, STEPS)
    assert told == [STEPS, STEPS + STEPS // 2, 2 * STEPS]
    for ours, theirs in zip(first.weights, begun[1].weights, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    # Two rounds of six epochs, one batch each.
    assert begun[1].optimiser_steps == {12.0}
    assert any((a != b).any() for a, b in zip(first.weights, more.weights, strict=True))
    assert json.loads((tmp_path / "ppo" / "checkpoint" / "state.json").read_text())["steps"] == 2 * STEPS
    assert controller_entry(f"policy:{path}", "helicopter").create() is not None
    assert not [left.name for left in (tmp_path / "ppo").iterdir() if left.name.startswith(".")]
    with pytest.raises(ValueError, match=r"out: expected a folder of the same training, or a new one \(other: seed\)"):
        train(replace(TINY, seed=4), tmp_path / "ppo", nothing)


def test_the_same_training_twice_is_the_same_policy(tmp_path: Path) -> None:
    first, second = (load_policy(str(train(TINY, tmp_path / name, nothing))) for name in ("a", "b"))
    for ours, theirs in zip((*first.weights, *first.biases), (*second.weights, *second.biases), strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.heavy
def test_the_off_policy_method_goes_on_with_what_it_remembers(tmp_path: Path) -> None:
    tiny = replace(TINY, algorithm="sac", steps=400, envs=4, controller="none")
    first = load_policy(str(train(tiny, tmp_path / "sac", nothing)))
    assert first.base is None
    assert first.output == "tanh"
    with np.load(tmp_path / "sac" / "checkpoint" / "replay.npz", allow_pickle=False) as kept:
        assert len(kept["rewards"]) == 100
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

    owner, method, at = (GymnasiumVecEnv, "step_wait", 140) if within == "step" else (torch.optim.Adam, "step", 2)
    monkeypatch.setattr(owner, method, interrupts(getattr(owner, method), at))
    with pytest.raises(KeyboardInterrupt):
        train(TINY, tmp_path, nothing)
    state = json.loads((tmp_path / "checkpoint" / "state.json").read_text())
    assert state["steps"] == STEPS // 2
    assert not (tmp_path / "policy.json").exists()
    assert signal.getsignal(number) == before
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    train(TINY, tmp_path, nothing)
    assert json.loads((tmp_path / "checkpoint" / "state.json").read_text())["steps"] == STEPS


def test_worlds_are_kept_where_that_is_possible_if_pictures_are_made() -> None:
    def worlds(env: str, **settings: Any) -> int:
        return int(Training(env, pictures=True, **settings).env_keywords["worlds"])

    assert worlds("frameout/RoadTownFollow-v2") == worlds("frameout/StereoFollow-v2") == 2
    assert worlds("frameout/FishTankFollow-v2") == worlds("frameout/RoadTownFollow-v2", worlds=0) == 0
    assert not {"worlds", "episodes_per_world"} & set(TINY.env_keywords)
    assert not {"worlds", "episodes_per_world"} & set(TINY.resolved)
    with pytest.raises(ValueError, match="worlds: expected 0 without pictures, where there are none, got 4"):
        Training("frameout/RoadTownFollow-v2", worlds=4)
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
    assert err.splitlines()[-1] == "error: File too large; what was written before is kept"
    assert checkpointed_settings(tmp_path / "full") is None


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("env", "frameout/MoonFollow-v1", "env: expected one of frameout/RoadTownFollow-v2"),
        ("algorithm", "es", "algorithm: expected ppo or sac, got 'es'"),
        ("steps", 0, "steps: expected a whole number >= 1, got 0"),
        ("seed", -1, "seed: expected a whole number >= 0, got -1"),
    ],
)
def test_what_is_wrong_is_named(name: str, value: object, expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        replace(TINY, **{name: value})  # type: ignore[arg-type]
