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


class GymnasiumVecEnv(VecEnv):
    """Adapts the interface; the step that ends an episode also resets the env, as stable-baselines3 requires.

    Rewards are multiplied by ``reward_scale``: a critic learns values near one fastest. The info of an episode's end
    has ``episode``, as stable-baselines3 defines it: the unscaled sum of rewards ``r``, steps ``l``, seconds ``t``,
    and here ``in_view``, the share of steps with the target in view.
    """

    def __init__(self, envs: gym.vector.VectorEnv, seed: int, reward_scale: float) -> None:
        mode = envs.metadata["autoreset_mode"]
        check("envs", mode == AutoresetMode.SAME_STEP, "ones that reset within the step", mode)
        # The base class reads attributes during construction.
        self._envs, self._seed, self._reward_scale, self.num_envs = envs, seed, reward_scale, envs.num_envs
        super().__init__(envs.num_envs, envs.single_observation_space, envs.single_action_space)
        self._actions: NDArray[Any] = np.zeros((0, 0))
        self._begun_s = time.perf_counter()
        self._totals = np.zeros((3, envs.num_envs))

    def reset(self) -> Any:
        """Reset all envs; the first time with the seed."""
        observations, _ = self._envs.reset(seed=self._seed if self._seed >= 0 else None)
        self._seed = -1
        self._totals[:] = 0.0
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keep the actions for ``step_wait``."""
        self._actions = actions

    def step_wait(self) -> Any:
        """Step all envs."""
        observations, rewards, terminated, truncated, infos = self._envs.step(self._actions)
        dones = terminated | truncated
        seen = infos["in_view"].astype(float)
        if dones.any():
            # What stands in ``infos`` itself is of the episode that begins.
            seen[dones] = infos["final_info"]["in_view"][dones]
        self._totals += np.stack([np.ones(self.num_envs), rewards, seen])
        details: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for k in np.flatnonzero(dones):
            details[k] = {
                "terminal_observation": infos["final_obs"][k],
                "TimeLimit.truncated": bool(truncated[k] and not terminated[k]),
                "episode": self._ended(int(k)),
            }
        return observations, (self._reward_scale * rewards).astype(np.float32), dones, details

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
        """Raise NotImplementedError: single envs have no attributes."""
        raise NotImplementedError("set_attr: the envs run together")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Raise NotImplementedError: single envs have no methods."""
        raise NotImplementedError("env_method: the envs run together")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return that none is wrapped."""
        return [False] * len(list(self._get_indices(indices)))
