"""Training of a policy with stable-baselines3, with checkpoints; the policy is stored without pickle."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.learning.checkpoint import checkpointed_settings, checkpointed_steps, load_checkpoint, save_checkpoint
from benchmarks.learning.settings import EPISODES, Training
from benchmarks.learning.stop_signals import StopSignals
from benchmarks.run.own_modules import load_modules
from scenarios import catalog
from scenarios.envs.pictureless.error_model import error_model
from sim.checks import check
from trackers.belief.features import FEATURES
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.policy import Policy, save_policy

_INSTALL = "pip install 'frameout[train]'"
_HIDDEN = (128, 64)
_FIRST_SHARE = 0.01
"""Initial scale of the last layer, so that corrections start near zero."""
_CHECKPOINT_S = 60.0
_DISCOUNT = 0.99
_ROLLOUT_STEPS, _BATCH = 128, 2048

_LATEST_EPISODES = 100
"""At least so many are in the means of ``Standing``, once they have ended."""


@dataclass(frozen=True)
class Standing:
    """How far a training is.

    Attributes:
        done, of: steps of all envs together.
        reward: mean sum of an episode's rewards, of the latest episodes; NaN before one has ended.
        time_in_view: mean share of steps with the target in view, of the same episodes.
        steps_per_s: of all envs together, since this process began to train; learning is included.
    """

    done: int
    of: int
    reward: float
    time_in_view: float
    steps_per_s: float


Report = Callable[[Standing], None]


def train(training: Training, out: Path, report: Report) -> Path:
    """Train until all steps are done, from the checkpoint in ``out`` if there is one; return the policy's file.

    An interrupted training leaves a checkpoint after the last rollout that was learnt from.

    Raises:
        KeyboardInterrupt: upon SIGINT or SIGTERM.
        ValueError: if stable-baselines3 is missing, or ``out`` holds another training's checkpoint.
    """
    needs_stable_baselines()
    import torch

    # For a small network threads cost more than they gain.
    torch.set_num_threads(1)
    settings = json.loads(json.dumps(training.resolved))
    learnt_from = settings | {"error_model": _error_model_hash(training)}
    before = checkpointed_settings(out)
    if before is not None:
        changed = sorted(name for name in learnt_from if name != "steps" and before.get(name) != learnt_from[name])
        check("out", not changed, f"a folder of the same training, or a new one (other: {', '.join(changed)})", out)
    # A resumed training draws new episodes and actions.
    seed = training.seed if before is None else training.seed + checkpointed_steps(out)
    envs = _envs(training, seed)
    try:
        model = _model(training, envs, out, seed)
        if before is None:
            _start_small(model)
        else:
            load_checkpoint(model, out)
        started = time.perf_counter()
        left = training.steps - model.num_timesteps
        if left > 0:
            _learn(model, left, out, learnt_from, report)
        seconds = round(time.perf_counter() - started, 1)
    finally:
        envs.close()
    made = {"by": settings, "seconds": seconds} if before is None else {"by": settings}
    return save_policy(policy_of(model, training, made), out / "policy.json")


def policy_of(model: Any, training: Training, made: dict[str, Any]) -> Policy:
    """Return the actor of a model as a policy of plain arrays."""
    import torch

    if training.algorithm == "ppo":
        layers = [*model.policy.mlp_extractor.policy_net, model.policy.action_net]
    else:
        layers = [*model.actor.latent_pi, model.actor.mu]
    linear = [layer for layer in layers if isinstance(layer, torch.nn.Linear)]
    carrier = catalog.scenario(training.scenario).carrier
    base = None
    if training.controller_name != "none":
        parameters = controller_entry(training.controller_name, carrier.name).parameters(**training.controller_values)
        base = {"controller": training.controller_name, "parameters": dataclasses.asdict(parameters)}
    return Policy(
        env=training.env,
        carrier=carrier,
        tracker=training.tracker_name,
        base=base,
        correction_share=training.correction_share,
        corrects=training.corrects,
        features=FEATURES,
        hidden="tanh",
        output="clip" if training.algorithm == "ppo" else "tanh",
        weights=tuple(layer.weight.detach().numpy().astype(np.float32) for layer in linear),
        biases=tuple(layer.bias.detach().numpy().astype(np.float32) for layer in linear),
        made=made,
    )


def _error_model_hash(training: Training) -> str | None:
    """Return a hash of the error model, None for a training with pictures."""
    if training.pictures:
        return None
    return hashlib.sha256(error_model(training.scenario, training.tracker_name).to_json().encode()).hexdigest()[:10]


def _envs(training: Training, seed: int) -> Any:
    """Return the envs as stable-baselines3 takes them."""
    import gymnasium as gym
    from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv

    from benchmarks.learning.vector_adapter import GymnasiumVecEnv
    from scenarios.envs.processes import EnvProcesses

    keywords = training.env_keywords | {"max_episode_steps": training.episode_steps}
    if training.pictures:
        make = [partial(_env, training.modules, training.env, keywords)] * training.env_count
        kind = EnvProcesses if len(make) > 1 else SyncVectorEnv
        envs: VectorEnv[Any, Any, Any] = kind(make, autoreset_mode=AutoresetMode.SAME_STEP)
    else:
        own: dict[str, Any] = {"starts": training.starts, "seeds": range(training.episodes), "cache": EPISODES}
        envs = gym.make_vec(training.env, training.env_count, pictures=False, **own, **keywords)
    return GymnasiumVecEnv(envs, seed, 1.0 - _DISCOUNT)


def _env(modules: Sequence[str], name: str, keywords: dict[str, Any]) -> Any:
    """Return one env, in a process that may be new: it imports ``scenarios``, which registers envs, and ``modules``."""
    import gymnasium as gym

    load_modules(modules)
    return gym.make(f"scenarios:{name}", **keywords)


def _model(training: Training, envs: Any, out: Path, seed: int) -> Any:
    """Return a fresh model with the settings of a successful trial."""
    import torch
    from stable_baselines3 import PPO, SAC

    shared: dict[str, Any] = {
        "seed": seed,
        "tensorboard_log": str(out / "tensorboard"),
        "device": "cpu",
        "gamma": _DISCOUNT,
        "stats_window_size": max(_LATEST_EPISODES, training.env_count),
        "policy_kwargs": {"net_arch": list(_HIDDEN), "activation_fn": torch.nn.Tanh},
    }
    if training.algorithm == "sac":
        return SAC(
            "MlpPolicy", envs, learning_rate=3e-4, buffer_size=300_000, batch_size=512, gradient_steps=8, **shared
        )
    shared["policy_kwargs"]["log_std_init"] = -1.2
    return PPO(
        "MlpPolicy",
        envs,
        learning_rate=lambda left: 5e-4 * left,
        n_steps=_ROLLOUT_STEPS,
        batch_size=min(_BATCH, _ROLLOUT_STEPS * training.env_count),
        n_epochs=6,
        gae_lambda=0.95,
        **shared,
    )


def _start_small(model: Any) -> None:
    """Make the last layer's weights small and its biases zero."""
    import torch

    last = model.actor.mu if hasattr(model, "actor") else model.policy.action_net
    with torch.no_grad():
        last.weight.mul_(_FIRST_SHARE)
        last.bias.zero_()


def _learn(model: Any, left: int, out: Path, settings: dict[str, Any], report: Report) -> None:
    """Train the remaining steps; write a checkpoint at the end or upon an interrupt."""
    with StopSignals() as signals:
        keep = _callback(model.num_timesteps, left, out, settings, report, signals)
        try:
            model.learn(left, callback=keep, reset_num_timesteps=False, tb_log_name="training")
        except KeyboardInterrupt:
            # Nothing was learnt from the steps of the rollout under way.
            model.num_timesteps = keep.learnt_steps
            save_checkpoint(model, out, settings)
            raise
        save_checkpoint(model, out, settings)


def _callback(behind: int, left: int, out: Path, settings: dict[str, Any], report: Report, signals: StopSignals) -> Any:
    from stable_baselines3.common.callbacks import BaseCallback

    class Keep(BaseCallback):
        """Reports progress, writes a checkpoint every minute, and defers signals during an update of the weights."""

        learnt_steps = behind

        def _on_training_start(self) -> None:
            self.saved_s = self.begun_s = time.monotonic()

        def _on_rollout_start(self) -> None:
            self.learnt_steps = self.num_timesteps
            report(self.standing())
            if time.monotonic() - self.saved_s > _CHECKPOINT_S:
                save_checkpoint(self.model, out, settings)
                self.saved_s = time.monotonic()
            signals.release()

        def _on_step(self) -> bool:
            return True

        def _on_rollout_end(self) -> None:
            signals.hold()
            # Stands beside rollout/ep_rew_mean in TensorBoard.
            self.logger.record("rollout/time_in_view", self.standing().time_in_view)

        def _on_training_end(self) -> None:
            report(self.standing())

        def standing(self) -> Standing:
            episodes = list(self.model.ep_info_buffer or ())
            reward, in_view = (
                float(np.mean([each[key] for each in episodes])) if episodes else float("nan")
                for key in ("r", "in_view")
            )
            taken_s = max(time.monotonic() - self.begun_s, 1e-3)
            done = min(self.num_timesteps, behind + left)
            return Standing(done, behind + left, reward, in_view, (self.num_timesteps - behind) / taken_s)

    return Keep()


def needs_stable_baselines() -> None:
    """Raise ValueError if stable-baselines3 or TensorBoard is not installed."""
    installed = all(map(find_spec, ("stable_baselines3", "tensorboard")))
    check("train", installed, f"stable-baselines3 to be installed ({_INSTALL})", "none")
