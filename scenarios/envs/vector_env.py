"""Many envs as one: workers step them side by side and write what comes of it into shared memory."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from scenarios.envs.actions import checked_actions
from scenarios.envs.env_group import INFORMATION, OBSERVATION, Failure, Plan, layout_of, parts_of
from scenarios.envs.follow_env import FollowEnv, Observed
from scenarios.envs.shared_arrays import arrays_in, shared_block
from scenarios.envs.truth_info import INFO
from scenarios.envs.vector_worker import Host, ThisProcess, Worker
from sim.checks import check

Stepped = tuple[Observed, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


class FollowVectorEnv(VectorEnv):
    """``num_envs`` of ``FollowEnv``, as ``gym.make_vec(id, num_envs=...)`` makes them.

    With the same seeds everything is exactly what Gymnasium's ``SyncVectorEnv`` returns, whatever the number of
    workers. Autoreset is ``NEXT_STEP``, Gymnasium's default: the step after an episode's last one takes no notice of
    the env's action, and returns the first observation of the next episode, with reward 0.

    When an env raises, or a worker dies, everything is closed and a RuntimeError says which env or worker it was and
    why. Ctrl-C closes everything, too.

    Args:
        num_envs: how many.
        max_episode_steps: steps after which an episode is truncated; None or -1: as long as the preset's.
        workers: processes that step the envs, each its share; 0: this process does. None: as many as there are cores
            for it, at most one for each env. A script that starts workers needs ``if __name__ == "__main__":``.
        copy: False returns observations that are overwritten by the next step.
        keywords: of ``FollowEnv``; ``render_mode`` is None or ``rgb_array``.
    """

    metadata: dict[str, Any] = {
        "render_modes": ["rgb_array"],
        "render_fps": FollowEnv.metadata["render_fps"],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        workers: int | None = None,
        copy: bool = True,
        **keywords: Any,
    ) -> None:
        # Read by close(), which is called even if this raises.
        self._hosts: list[Host] = []
        limit = None if max_episode_steps == -1 else max_episode_steps
        render_mode = keywords.get("render_mode")
        check("num_envs", num_envs >= 1, "a whole number >= 1", num_envs)
        check("max_episode_steps", limit is None or limit >= 1, "a whole number >= 1, -1 or None", limit)
        check("workers", workers is None or workers >= 0, "None or a whole number >= 0", workers)
        check("render_mode", render_mode in (None, "rgb_array"), "None or rgb_array", repr(render_mode))
        pattern = FollowEnv(**keywords)
        self.num_envs, self.copy, self.render_mode = num_envs, copy, render_mode
        self.settings = pattern.settings
        self.single_observation_space, self.single_action_space = pattern.observation_space, pattern.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        layout = layout_of(pattern)
        block = shared_block(layout, num_envs)
        self._arrays = arrays_in(block, layout, num_envs)
        self._begun = np.zeros(num_envs, dtype=bool)
        plan = Plan(keywords, num_envs, limit)
        count = min(num_envs, _cores() if workers is None else workers)
        try:
            if count == 0:
                self._hosts = [ThisProcess(plan, tuple(range(num_envs)), self._arrays)]
            for number, share in enumerate(np.array_split(np.arange(num_envs), count) if count else ()):
                self._hosts.append(Worker(number, plan, tuple(share.tolist()), block, layout))
            self._gather(self._hosts)
        except BaseException:
            self.close()
            raise

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin episodes, of all envs or of those that ``options["reset_mask"]`` (N,) bool names.

        ``seed`` n seeds the envs with n, n + 1, …; the other options are ``FollowEnv``'s, the same for all.

        Raises:
            ValueError: for options or a mask that are none, or another number of seeds.
            RuntimeError: if an env raises or a worker dies; everything is closed then.
        """
        self._check_open()
        seeds: Sequence[int | None] = [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            seeds = [int(seed) + k for k in range(self.num_envs)]
        elif seed is not None:
            seeds = seed
        check("seed", len(seeds) == self.num_envs, f"as many as there are envs, {self.num_envs}", len(seeds))
        wanted = dict(options or {})
        mask = self._checked_mask(wanted.pop("reset_mask", None))
        self.settings.with_options(wanted)
        chosen = {index: seeds[index] for index in np.flatnonzero(mask).tolist()}
        self._request([host for host in self._hosts if mask[list(host.indices)].any()], "reset", chosen, wanted or None)
        self._begun |= mask
        return self._observed(), self._information(mask)

    def step(self, actions: NDArray[Any]) -> Stepped:
        """Step every env, or begin its next episode if its last one has ended.

        Raises:
            ResetNeeded: before the first reset.
            ValueError: for actions (N, A) of another shape, not finite or outside [-1, 1]; nothing was stepped then.
            RuntimeError: if an env raises or a worker dies; everything is closed then.
        """
        self._check_open()
        if not self._begun.all():
            raise gym.error.ResetNeeded("step: expected reset() of every env before it, got some not begun")
        arrays = self._arrays
        arrays["action"][:] = checked_actions(actions, self.action_space.shape)
        self._request(self._hosts, "step")
        flags = arrays["terminated"].copy(), arrays["truncated"].copy()
        everyone = np.ones(self.num_envs, dtype=bool)
        return self._observed(), arrays["reward"].copy(), *flags, self._information(everyone)

    def render(self) -> tuple[Any, ...]:
        """Return the picture of every env (H, W, 3) uint8, or Nones without a ``render_mode``."""
        if not self._begun.all():
            raise gym.error.ResetNeeded("render: expected reset() of every env before it, got some not begun")
        return self.call("render")

    def call(self, name: str, *arguments: Any) -> tuple[Any, ...]:
        """Return what a method of every env returns for these arguments, or the value of an attribute."""
        self._check_open()
        found: dict[int, Any] = {}
        for answer in self._request(self._hosts, "call", name, *arguments):
            found |= answer
        return tuple(found[index] for index in range(self.num_envs))

    @property
    def worker_ids(self) -> tuple[int, ...]:
        """Process ids of the workers."""
        return tuple(host.process_id for host in self._hosts if isinstance(host, Worker))

    def close_extras(self, **_: Any) -> None:
        """End the workers, or free the worlds; ``close`` calls it once."""
        hosts, self._hosts = self._hosts, []
        for host in hosts:
            host.dismiss()
        for host in hosts:
            host.close()

    def _request(self, hosts: Sequence[Host], request: str, *arguments: Any) -> list[Any]:
        try:
            for host in hosts:
                host.ask(request, *arguments)
            return self._gather(hosts)
        except BaseException:
            # An answer is missing or was left unread (Ctrl-C): envs and arrays no longer belong together.
            self.close()
            raise

    def _gather(self, hosts: Sequence[Host]) -> list[Any]:
        # Mostly the one asked last is done last: whoever waits for it first is woken once, not once for each.
        answers = [host.answer() for host in reversed(hosts)][::-1]
        for answer in answers:
            if isinstance(answer, Failure):
                raise answer.error()
        return answers

    def _observed(self) -> Observed:
        parts = {part: self._arrays[OBSERVATION + part] for part in parts_of(self.single_observation_space)}
        if self.copy:
            parts = {part: array.copy() for part, array in parts.items()}
        return parts.get("", parts)

    def _information(self, mask: NDArray[np.bool_]) -> dict[str, Any]:
        """Return the info of those envs in Gymnasium's form: an array (N, ...) for each key, and a mask ``_key``."""
        info: dict[str, Any] = {}
        left_out = np.flatnonzero(~mask)
        for key in INFO:
            array = self._arrays[INFORMATION + key].copy()
            if len(left_out):
                array[left_out] = 0
            info[key], info[f"_{key}"] = array, mask.copy()
        return info

    def _checked_mask(self, mask: Any) -> NDArray[np.bool_]:
        if mask is None:
            return np.ones(self.num_envs, dtype=bool)
        good = (
            isinstance(mask, np.ndarray) and mask.shape == (self.num_envs,) and mask.dtype == bool and bool(mask.any())
        )
        check("reset_mask", good, f"an array of bool of shape ({self.num_envs},), not all False", repr(mask))
        return mask

    def _check_open(self) -> None:
        if self.closed:
            raise gym.error.ClosedEnvironmentError("vector env: expected it to be open, got a closed one")


def _cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
