"""Trains a policy that steers by a tracker's estimate, with Stable-Baselines3: settings, checkpoints, the run."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.learning.evaluation import Evaluation, Evaluations
from benchmarks.learning.settings import EPISODES, Training
from benchmarks.run.own_modules import load_modules
from benchmarks.run.packages import check_packages
from scenarios import catalog
from scenarios.envs.pictureless.error_model import error_model
from sim.checks import check
from trackers.atomic_file import write_atomic
from trackers.belief.features import FEATURES
from trackers.controllers.catalogue import controller_entry
from trackers.controllers.policy import LARGEST_INPUT, Policy, save_policy

CHECKPOINT = "checkpoint.pt"
"""File of a training's folder from which the same command continues."""
_MOMENTS = ("mean", "var", "count")
_REPLAYED = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")


def save_checkpoint(model: Any, out: Path, settings: dict[str, Any]) -> None:
    """Write a model's state atomically: a killed run leaves the previous checkpoint."""
    import torch

    state = {
        "settings": settings,
        "steps": model.num_timesteps,
        "updates": model._n_updates,
        "parameters": model.get_parameters(),
    }
    if isinstance(getattr(model, "log_ent_coef", None), torch.Tensor):
        state["log_ent_coef"] = model.log_ent_coef.detach()
    buffer = getattr(model, "replay_buffer", None)
    observed = model.get_vec_normalize_env().obs_rms
    state["observed"] = {name: torch.as_tensor(getattr(observed, name)) for name in _MOMENTS}
    if buffer is not None:
        state["replay"] = {name: torch.from_numpy(getattr(buffer, name)[: buffer.size()]) for name in _REPLAYED}
        state["replay_position"] = (int(buffer.pos), bool(buffer.full))
    # Not into the file itself: torch does not raise OSError on a full disk.
    content = io.BytesIO()
    torch.save(state, content)
    out.mkdir(parents=True, exist_ok=True)
    write_atomic(out / CHECKPOINT, content.getvalue())


def read_checkpoint(out: Path) -> dict[str, Any] | None:
    """Return what ``save_checkpoint`` wrote in a folder, None if there is nothing. No code of the file is run."""
    import torch

    path = out / CHECKPOINT
    state: dict[str, Any] | None = torch.load(path, weights_only=True) if path.is_file() else None
    return state


def _restore(model: Any, state: dict[str, Any]) -> None:
    """Set a fresh model of the same settings to a checkpoint."""
    model.set_parameters(state["parameters"])
    model.num_timesteps, model._n_updates = state["steps"], state["updates"]
    observed = model.get_vec_normalize_env().obs_rms
    for name in _MOMENTS:
        setattr(observed, name, state["observed"][name].numpy())
    if "log_ent_coef" in state:
        model.log_ent_coef.data.copy_(state["log_ent_coef"])
    if "replay" in state:
        buffer = model.replay_buffer
        for name, values in state["replay"].items():
            getattr(buffer, name)[: len(values)] = values.numpy()
        buffer.pos, buffer.full = state["replay_position"]


_HIDDEN = (128, 64)
_FIRST_SHARE = 0.01
"""Initial scale of the last layer, so that corrections start near zero."""
_CHECKPOINT_S = 60.0
_DISCOUNT = 0.98
"""Of a picture."""
_FIRST_LOG_DEVIATION = -1.8
"""Of an action, whose range is from -1 to 1."""
_SMALLEST_DEVIATION = 0.01
"""A feature that hardly varies is not magnified beyond it."""
_ROLLOUT_STEPS, _BATCH = 64, 2048
_CELLS = 64
"""Of the LSTM of a policy that remembers."""

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


Report = Callable[[Standing | Evaluation], None]


def train(training: Training, out: Path, report: Report) -> Path:
    """Train until all steps are done, from the checkpoint in ``out`` if there is one; return the policy's file.

    An interrupted training leaves a checkpoint after the last rollout that was learnt from.

    Raises:
        KeyboardInterrupt: upon SIGINT or SIGTERM.
        ChildProcessError: if an evaluation fails.
        ValueError: if stable-baselines3 is missing, or ``out`` holds another training's checkpoint.
    """
    needs_stable_baselines()
    import torch

    # For a small network threads cost more than they gain.
    torch.set_num_threads(1)
    settings = json.loads(json.dumps(training.resolved))
    learnt_from = settings | {"error_model": _error_model_hash(training)}
    before = read_checkpoint(out)
    if before is not None:
        kept = before["settings"]
        changed = sorted(name for name in learnt_from if name != "steps" and kept.get(name) != learnt_from[name])
        check("out", not changed, f"a folder of the same training, or a new one (other: {', '.join(changed)})", out)
    # A resumed training draws new episodes and actions.
    seed = training.seed if before is None else training.seed + before["steps"]
    envs, evaluations = _envs(training, seed), Evaluations(training, out)
    # As Ctrl-C: what runs beside is ended.
    handler = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        model = _model(training, envs, out, seed)
        if before is None:
            _start_small(model)
        else:
            _restore(model, before)
        started = time.perf_counter()
        left = -(-training.steps // training.action_repeat) - model.num_timesteps
        if left > 0:
            # The first episodes begin before the first rollout.
            envs.set_attr("progress", round(model.num_timesteps / (model.num_timesteps + left), 2))
            _learn(model, left, training, out, learnt_from, report, evaluations)
        made = {"seconds": round(time.perf_counter() - started, 1)} if before is None else {}
        path = save_policy(policy_of(model, training, {"by": settings} | made), out / "policy.json")
        if training.evaluations > 0:
            evaluations.begin(path, training.steps)
        for evaluation in evaluations.ended(wait=True):
            report(evaluation)
    finally:
        evaluations.stop()
        envs.close()
        signal.signal(signal.SIGTERM, handler)
    return path


def policy_of(model: Any, training: Training, made: dict[str, Any]) -> Policy:
    """Return the actor of a model as a policy of plain arrays."""
    import torch

    cells: tuple[Any, ...] = ()
    if training.algorithm == "sac":
        layers = [*model.actor.latent_pi, model.actor.mu]
    else:
        layers = [*model.policy.mlp_extractor.policy_net, model.policy.action_net]
    if training.algorithm == "recurrent-ppo":
        lstm = model.policy.lstm_actor
        # PyTorch has two biases, of which only the sum counts.
        cells = (lstm.weight_ih_l0, lstm.weight_hh_l0, lstm.bias_ih_l0 + lstm.bias_hh_l0)
    linear = [layer for layer in layers if isinstance(layer, torch.nn.Linear)]
    carrier = catalog.scenario(training.scenario).carrier
    observed, small = model.get_vec_normalize_env().obs_rms, model.get_vec_normalize_env().epsilon
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
        history=training.history,
        action_repeat=training.action_repeat,
        hidden="tanh",
        output="tanh" if training.algorithm == "sac" else "clip",
        mean=observed.mean.astype(np.float32),
        deviation=np.sqrt(observed.var + small).astype(np.float32),
        weights=tuple(layer.weight.detach().numpy().astype(np.float32) for layer in linear),
        biases=tuple(layer.bias.detach().numpy().astype(np.float32) for layer in linear),
        cells=tuple(each.detach().numpy().astype(np.float32) for each in cells),
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
    from gymnasium.vector import AutoresetMode
    from stable_baselines3.common.vec_env import VecNormalize

    from benchmarks.learning.vector_adapter import GymnasiumVecEnv

    keywords = training.env_keywords | {"max_episode_steps": training.episode_steps}
    if training.pictures:
        begin = partial(load_modules, training.modules)
        own: dict[str, Any] = {"autoreset_mode": AutoresetMode.SAME_STEP, "initializer": begin}
    else:
        own = {"starts": training.starts, "seeds": range(training.episodes), "cache": EPISODES}
    envs = gym.make_vec(training.env, training.env_count, pictures=training.pictures, **own, **keywords)
    adapted = GymnasiumVecEnv(envs, seed, _DISCOUNT, training.history, training.action_repeat)
    # Features vary by several times more in one scene than in another.
    return VecNormalize(adapted, norm_reward=False, clip_obs=LARGEST_INPUT, epsilon=_SMALLEST_DEVIATION**2)


def _model(training: Training, envs: Any, out: Path, seed: int) -> Any:
    """Return a fresh model.

    Discount, deviation and the share of corrections were chosen without pictures, in the default env, against 0.99,
    -1.2 and a half, by trainings with three seeds.
    """
    import torch
    from stable_baselines3 import PPO, SAC

    shared: dict[str, Any] = {
        "seed": seed,
        "tensorboard_log": str(out / "tensorboard"),
        "device": "cpu",
        "gamma": _DISCOUNT**training.action_repeat,
        "stats_window_size": max(_LATEST_EPISODES, training.env_count),
        "policy_kwargs": {"net_arch": list(_HIDDEN), "activation_fn": torch.nn.Tanh},
    }
    if training.algorithm == "sac":
        size: dict[str, Any] = {"buffer_size": 300_000, "batch_size": 512, "gradient_steps": 8}
        return SAC("MlpPolicy", envs, learning_rate=training.learning_rate, **size, **shared)
    shared["policy_kwargs"]["log_std_init"] = _FIRST_LOG_DEVIATION
    create: Any = PPO
    policy = "MlpPolicy"
    if training.algorithm == "recurrent-ppo":
        from sb3_contrib import RecurrentPPO

        create, policy = RecurrentPPO, "MlpLstmPolicy"
        shared["policy_kwargs"]["lstm_hidden_size"] = _CELLS
    return create(
        policy,
        envs,
        learning_rate=lambda left: training.learning_rate * left,
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


def _learn(
    model: Any,
    left: int,
    training: Training,
    out: Path,
    settings: dict[str, Any],
    report: Report,
    evaluations: Evaluations,
) -> None:
    """Train the remaining decisions; write a checkpoint every minute and at the end, be it upon SIGINT or SIGTERM."""
    keep = _callback(model.num_timesteps, left, training, out, settings, report, evaluations)
    before = {number: signal.signal(number, keep.stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        model.learn(left, callback=keep, reset_num_timesteps=False, tb_log_name="training")
    except ChildProcessError:
        # Of an evaluation; what was learnt before it stays.
        save_checkpoint(model, out, settings)
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if keep.stopped:
        # Nothing was learnt from the steps of the rollout under way.
        model.num_timesteps = keep.learnt_steps
    save_checkpoint(model, out, settings)
    if keep.stopped:
        raise KeyboardInterrupt


def _callback(
    behind: int,
    left: int,
    training: Training,
    out: Path,
    settings: dict[str, Any],
    report: Report,
    evaluations: Evaluations,
) -> Any:
    from stable_baselines3.common.callbacks import BaseCallback

    held, all_steps = training.action_repeat, behind + left
    # The one at the end is of the policy that is returned.
    due = [all_steps * k // training.evaluations for k in range(1, training.evaluations)]

    class Keep(BaseCallback):
        """Reports progress, writes a checkpoint every minute, and ends the training upon a signal."""

        learnt_steps = behind
        stopped = False
        progress = 0.0
        to_come = tuple(steps for steps in due if steps > behind)

        def stop(self, *_: object) -> None:
            """Handle a signal: the step or the update under way is the last one."""
            self.stopped = True

        def _on_training_start(self) -> None:
            self.saved_s = self.begun_s = time.monotonic()

        def _on_rollout_start(self) -> None:
            self.learnt_steps = self.num_timesteps
            if self.stopped:
                return
            progress = round(min(self.num_timesteps / (behind + left), 1.0), 2)
            if progress != self.progress:
                self.training_env.set_attr("progress", progress)
                self.progress = progress
            report(self.standing())
            if time.monotonic() - self.saved_s > _CHECKPOINT_S:
                save_checkpoint(self.model, out, settings)
                self.saved_s = time.monotonic()
            if self.to_come and self.num_timesteps >= self.to_come[0]:
                self.to_come = tuple(steps for steps in self.to_come if steps > self.num_timesteps)
                file = out / "policies" / f"{held * self.num_timesteps}.json"
                evaluations.begin(save_policy(policy_of(self.model, training, {}), file), held * self.num_timesteps)
            for evaluation in evaluations.ended():
                self.logger.record("pictures/time_seen", evaluation.time_seen)
                self.logger.record("pictures/difference", evaluation.difference)
                report(evaluation)

        def _on_step(self) -> bool:
            return not self.stopped

        def _on_rollout_end(self) -> None:
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
            done, of = min(self.num_timesteps, all_steps), all_steps
            rate = (self.num_timesteps - behind) / taken_s
            return Standing(held * done, held * of, reward, in_view, held * rate)

    return Keep()


def needs_stable_baselines() -> None:
    """Raise ValueError if stable-baselines3, what it lacks, or TensorBoard is not installed."""
    check_packages(("stable_baselines3", "sb3_contrib", "tensorboard"), "train")
