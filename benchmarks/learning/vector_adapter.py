"""A vector env of Gymnasium as one of stable-baselines3."""

from __future__ import annotations

import time
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from sim.checks import check
from trackers.belief.features import FeatureHistory


class GymnasiumVecEnv(VecEnv):
    """Adapts the interface; the step that ends an episode also resets the env, as stable-baselines3 requires.

    An observation is that of a ``FeatureHistory``. A step holds its action for ``action_repeat`` pictures; its reward
    is the discounted sum of theirs, times ``1 - discount``, since a critic learns values near one fastest. An episode
    that ends within a step is followed by the first pictures of the next one, with the action zero and no reward. The
    info of an episode's end has ``episode``, as stable-baselines3 defines it: the plain sum of rewards ``r``, pictures
    ``l``, seconds ``t``, and here ``in_view``, the share of pictures with the target in view.
    """

    def __init__(
        self, envs: gym.vector.VectorEnv, seed: int, discount: float, history: int = 0, action_repeat: int = 1
    ) -> None:
        """Args:
        discount: of a picture's reward.
        history, action_repeat: numbers of pictures, see ``Policy``.
        """
        mode = envs.metadata["autoreset_mode"]
        check("envs", mode == AutoresetMode.SAME_STEP, "ones that reset within the step", mode)
        # The base class reads attributes during construction.
        self._envs, self._seed, self.num_envs = envs, seed, envs.num_envs
        self._discounts = (1.0 - discount) * discount ** np.arange(action_repeat)
        self._history = FeatureHistory(envs.num_envs, history)
        # A feature in [-1, 1] changes by no more than 2.
        seen = gym.spaces.Box(-2.0, 2.0, (self._history.width,), np.float32)
        super().__init__(envs.num_envs, seen, envs.single_action_space)
        self._actions: NDArray[Any] = np.zeros((0, 0))
        self._begun_s = time.perf_counter()
        self._totals = np.zeros((3, envs.num_envs))

    def reset(self) -> Any:
        """Reset all envs; the first time with the seed."""
        observations, _ = self._envs.reset(seed=self._seed if self._seed >= 0 else None)
        self._seed = -1
        self._totals[:] = 0.0
        self._history.begin(observations)
        return self._history.numbers()

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keep the actions for ``step_wait``."""
        self._actions = np.array(actions)

    def step_wait(self) -> Any:
        """Step all envs."""
        rewards, ended = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=bool)
        details: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for discount in self._discounts:
            observations, reward, terminated, truncated, infos = self._envs.step(self._actions)
            rewards += np.where(ended, 0.0, discount * reward)
            dones = terminated | truncated
            seen = infos["in_view"].astype(float)
            if dones.any():
                # What stands in ``infos`` itself is of the episode that begins.
                seen[dones] = infos["final_info"]["in_view"][dones]
            self._totals += np.stack([np.ones(self.num_envs), reward, seen])
            which = np.flatnonzero(dones)
            latest = observations.copy()
            if len(which):
                latest[which] = np.stack([infos["final_obs"][k] for k in which])
            self._history.add(latest)
            for k, last in zip(which, self._history.numbers(which), strict=True):
                # Of two ends within a step the first one counts, as the second episode had no action of its own.
                episode = self._ended(int(k))
                if not ended[k]:
                    cut = bool(truncated[k] and not terminated[k])
                    details[k] = {"terminal_observation": last, "TimeLimit.truncated": cut, "episode": episode}
            self._history.begin(observations[which], which)
            ended |= dones
            self._actions[ended] = 0.0
        return self._history.numbers(), rewards.astype(np.float32), ended, details

    def _ended(self, k: int) -> dict[str, float]:
        steps, reward, seen = self._totals[:, k].tolist()
        self._totals[:, k] = 0.0
        taken_s = time.perf_counter() - self._begun_s
        return {"r": reward, "l": int(steps), "t": taken_s, "in_view": seen / steps}

    def close(self) -> None:
        """Close them."""
        self._envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the vector env, once for each."""
        return [getattr(self._envs, attr_name, None)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the vector env, which is one for all, e.g. ``progress``."""
        setattr(self._envs, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Raise NotImplementedError: single envs have no methods."""
        raise NotImplementedError("env_method: the envs run together")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return that none is wrapped."""
        return [False] * len(list(self._get_indices(indices)))
