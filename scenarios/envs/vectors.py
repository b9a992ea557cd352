"""Many rendered envs as one, and the entry point of ``gym.make_vec``.

The envs are spread over processes, several in each; all of their numbers stand in one array of records in shared
memory, a row for each env, so that a step costs every process one call, whatever it observes.
"""

from __future__ import annotations

import dataclasses
import mmap
import os
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import gymnasium as gym
import joblib
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.envs.actions import checked_actions
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.observing import Observed
from scenarios.envs.truth_info import info_dtype
from scenarios.envs.vector_results import check_open, checked_mask, final_infos, masked
from scenarios.envs.workers import Workers
from sim.checks import check
from trackers import registry
from trackers.controllers.catalogue import controller_entry


def follow_vector_env(
    num_envs: int = 1, *, pictures: bool = True, **keywords: Any
) -> gym.vector.VectorEnv[Any, Any, Any]:
    """Return a ``FollowVectorEnv``, or a ``PicturelessVectorEnv``.

    Args:
        pictures: whether episodes are rendered.
        keywords: of the one or the other.
    """
    check("num_envs", num_envs >= 1, "a whole number >= 1", num_envs)
    if pictures:
        return FollowVectorEnv(num_envs, **keywords)
    # It imports kernels, which takes seconds.
    from scenarios.envs.pictureless.vector_env import PicturelessVectorEnv

    return PicturelessVectorEnv(num_envs, **keywords)


class FollowVectorEnv(gym.vector.VectorEnv):
    """N envs of ``FollowEnv``; each lives as it would alone, whatever the number of processes.

    Observations, rewards and infos are arrays, N first. ``reset(seed=n)`` seeds env k by n + k, a list each by its own.
    Options of ``reset`` are those of ``FollowEnv`` for all, ``episode_seed`` also one for each (N,), and
    ``reset_mask`` (N,) bool: the envs to reset. ``autoreset_mode`` says when an ended episode is followed by another
    one, as Gymnasium defines it.
    """

    def __init__(
        self,
        num_envs: int,
        *,
        workers: int | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        initializer: Callable[[], object] | None = None,
        **keywords: Any,
    ) -> None:
        """Make the envs; worlds are built at the first reset.

        Args:
            workers: number of processes; 0: this one alone. None: one for each core, if there are several.
            max_episode_steps: longer episodes are truncated; None: at their last frame.
            autoreset_mode: ``NextStep``, ``SameStep`` or ``Disabled``.
            initializer: is called first in every process, e.g. to import what registers a tracker. Modules that define
                what ``keywords`` name are imported anyway.
            keywords: of ``FollowEnv``.
        """
        most = max_episode_steps
        check("max_episode_steps", most is None or most >= 1, "None or a whole number >= 1", most)
        check("workers", workers is None or workers >= 0, "None or a whole number >= 0", workers)
        self._mode, self.num_envs = AutoresetMode(autoreset_mode), num_envs
        probe = FollowEnv(**keywords)
        probe.close()
        self.settings, self.carrier, self.render_mode = probe.settings, probe.carrier, probe.render_mode
        self.metadata = {**probe.metadata, "autoreset_mode": self._mode}
        self.single_observation_space, self.single_action_space = probe.observation_space, probe.action_space
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, num_envs)
        row = _row_dtype(probe)
        cores = joblib.cpu_count() if workers is None else workers
        count = min(cores, num_envs)
        shares = np.array_split(np.arange(num_envs), max(count, 1))
        self._slices = [slice(int(own[0]), int(own[-1]) + 1) for own in shares]
        make = partial(_env, keywords, max_episode_steps)
        self._workers: Workers | None = None
        if count == 0 or (workers is None and count == 1):
            self._rows = np.zeros(num_envs, row)
            self._here = EnvShare([make] * num_envs, self._rows, self._mode)
        else:
            with _SharedFile(num_envs * row.itemsize) as shared:
                self._rows = np.frombuffer(shared.mapped, row)
                makes = [partial(_share, initializer, make, own, shared.fd, row, self._mode) for own in self._slices]
                self._workers = Workers(makes, _modules_of(self.settings), shared.fd)
        self._begun = False

    @property
    def worker_ids(self) -> list[int]:
        """Numbers of the processes that run the envs; none if this one does."""
        return [] if self._workers is None else self._workers.ids

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin an episode in every env, or in those of ``reset_mask``; see the class."""
        check_open(self)
        wanted = dict(options or {})
        mask = checked_mask(wanted.pop("reset_mask", None), self.num_envs, self._begun)
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else int(seed) + k for k in range(self.num_envs)]
        else:
            seeds = [None if each is None else int(each) for each in seed]
        check("seed", len(seeds) == self.num_envs, f"a number, or one for each of {self.num_envs} envs", len(seeds))
        episodes = wanted.get("episode_seed")
        if isinstance(episodes, Sequence | np.ndarray):
            check("episode_seed", np.shape(episodes) == (self.num_envs,), "one, or one for each env", episodes)
            each = [wanted | {"episode_seed": episode} for episode in np.asarray(episodes).tolist()]
        else:
            each = [wanted] * self.num_envs
        self._call("reset", self._split(seeds), self._split(each), self._split(mask.tolist()))
        self._begun = True
        return self._of(self._rows["observed"]), masked(self._of_infos("info"), mask)

    def step(
        self, actions: NDArray[Any]
    ) -> tuple[Observed, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Advance all envs by a frame; actions are (N, A).

        Raises:
            ResetNeeded: before the first reset, and with autoreset_mode ``Disabled`` after an end.
            ClosedEnvironmentError: after closing.
            ValueError: for actions that ``FollowEnv`` refuses.
            RuntimeError: if a tracker raises, or returns no valid estimate; the other envs have advanced.
            ChildProcessError: if a process has died; the others are ended.
        """
        check_open(self)
        if not self._begun:
            raise gym.error.ResetNeeded("step: expected reset() before it, got episodes not begun")
        rows = self._rows
        rows["action"] = checked_actions(actions, self.action_space.shape, self.settings.out_of_range)
        self._call("step")
        terminated, truncated = rows["terminated"].copy(), rows["truncated"].copy()
        infos = masked(self._of_infos("info"), np.ones(self.num_envs, dtype=bool))
        ended = terminated | truncated
        if self._mode == AutoresetMode.SAME_STEP and ended.any():
            last = self._of(rows["final_observed"])
            infos |= final_infos(last, self._of_infos("final_info"), ended)
        return self._of(rows["observed"]), rows["reward"].copy(), terminated, truncated, infos

    @property
    def progress(self) -> float:
        """Of the training, see ``FollowSettings``; set it for later episodes of all envs."""
        return self.settings.progress

    @progress.setter
    def progress(self, progress: float) -> None:
        self.set_attr("progress", progress)

    def render(self) -> tuple[Any, ...]:
        """Return each env's larger view, see ``FollowEnv.render``."""
        return self.call("render")

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Call a method of every env, and return its results; of an attribute return the values."""
        check_open(self)
        answers = self._call("call", *([value] * len(self._slices) for value in (name, args, kwargs)))
        return tuple(value for answer in answers for value in answer)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of every env."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of every env, to one value or to one of a list each."""
        check_open(self)
        each = list(values) if isinstance(values, list | tuple) else [values] * self.num_envs
        check("values", len(each) == self.num_envs, f"one value, or a list of {self.num_envs}", len(each))
        self._call("set", [name] * len(self._slices), self._split(each))
        if name == "progress" and each:
            self.settings = dataclasses.replace(self.settings, progress=each[0])

    def close_extras(self, **_: Any) -> None:
        """End the processes, and the envs of this one."""
        if self._workers is not None:
            self._workers.close()
        elif hasattr(self, "_here"):
            self._here.close()

    def _call(self, method: str, *arguments: Sequence[Any]) -> list[Any]:
        """Call a method of the shares; of each parameter there is a value for each share."""
        if self._workers is not None:
            return self._workers.call(method, *arguments)
        return [getattr(self._here, method)(*(each[0] for each in arguments))]

    def _split(self, values: list[Any]) -> list[list[Any]]:
        """Return the values of each share."""
        return [values[own] for own in self._slices]

    def _of(self, observed: NDArray[np.void]) -> Observed:
        """Return a copy of observations in records."""
        if isinstance(self.single_observation_space, gym.spaces.Dict):
            return {name: observed[name].copy() for name in self.single_observation_space}
        return observed["alone"].copy()

    def _of_infos(self, field: str) -> dict[str, NDArray[Any]]:
        infos = self._rows[field]
        return {name: infos[name].copy() for name in infos.dtype.names or ()}


_PARTS = ("observed", "info")


class EnvShare:
    """Some envs of a vector env, one after the other; their results stand in records."""

    def __init__(self, makes: Sequence[Callable[[], Any]], rows: NDArray[np.void], mode: AutoresetMode) -> None:
        """``rows`` (K,) are those of its envs, see ``_row_dtype``."""
        self._envs = [make() for make in makes]
        self._rows, self._mode = rows, mode
        self._over = [False] * len(makes)
        # Views of the records' fields; to look for them in every step takes as long as to write them.
        self._fields = {
            prefix: [
                {name: rows[prefix + part][name] for name in rows.dtype[prefix + part].names or ()} for part in _PARTS
            ]
            for prefix in ("", "final_")
        }

    def reset(self, seeds: list[int | None], options: list[dict[str, Any]], mask: list[bool]) -> None:
        """Reset the envs of ``mask`` (K,)."""
        self._all(partial(self._reset, seeds, options), np.flatnonzero(mask).tolist())

    def step(self) -> None:
        """Step every env by the action in its row."""
        self._all(self._step, range(len(self._envs)))

    def call(self, name: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> list[Any]:
        """See ``FollowVectorEnv``."""
        found = [env.get_wrapper_attr(name) for env in self._envs]
        return [each(*args, **kwargs) if callable(each) else each for each in found]

    def set(self, name: str, values: list[Any]) -> None:
        """See ``FollowVectorEnv.set_attr``."""
        for env, value in zip(self._envs, values, strict=True):
            env.set_wrapper_attr(name, value)

    def close(self) -> None:
        """Close the envs."""
        for env in self._envs:
            env.close()

    def _all(self, act: Callable[[int], None], which: Sequence[int]) -> None:
        """Act on envs; the first error is raised when all have had their turn."""
        errors = []
        for k in which:
            try:
                act(k)
            except Exception as error:
                errors.append(error)
        if errors:
            raise errors[0]

    def _reset(self, seeds: list[int | None], options: list[dict[str, Any]], k: int) -> None:
        self._write(k, "", *self._envs[k].reset(seed=seeds[k], options=options[k]))
        self._over[k] = False

    def _step(self, k: int) -> None:
        rows, env = self._rows, self._envs[k]
        if self._over[k] and self._mode == AutoresetMode.NEXT_STEP:
            observed, info = env.reset()
            reward, terminated, truncated = 0.0, False, False
        elif self._over[k] and self._mode == AutoresetMode.DISABLED:
            # Gymnasium's TimeLimit would step on.
            raise gym.error.ResetNeeded("step: expected an episode that runs, got one that has ended")
        else:
            observed, reward, terminated, truncated, info = env.step(rows["action"][k])
        self._over[k] = terminated or truncated
        if self._over[k] and self._mode == AutoresetMode.SAME_STEP:
            self._write(k, "final_", observed, info)
            observed, info = env.reset()
        self._write(k, "", observed, info)
        rows["reward"][k], rows["terminated"][k], rows["truncated"][k] = reward, terminated, truncated

    def _write(self, k: int, prefix: str, observed: Observed, info: dict[str, Any]) -> None:
        channels, infos = self._fields[prefix]
        for name, value in (observed if isinstance(observed, dict) else {"alone": observed}).items():
            channels[name][k] = value
        for name, value in info.items():
            infos[name][k] = value


def _env(keywords: dict[str, Any], max_episode_steps: int | None) -> gym.Env[Any, Any]:
    env = FollowEnv(**keywords)
    return env if max_episode_steps is None else gym.wrappers.TimeLimit(env, max_episode_steps)


def _share(
    initializer: Callable[[], object] | None,
    make: Callable[[], gym.Env[Any, Any]],
    own: slice,
    shared_fd: int,
    row: np.dtype[Any],
    mode: AutoresetMode,
) -> EnvShare:
    """Return the envs of a process."""
    if initializer is not None:
        initializer()
    rows = np.frombuffer(mmap.mmap(shared_fd, 0), row)
    return EnvShare([make] * (own.stop - own.start), rows[own], mode)


def _row_dtype(env: FollowEnv) -> np.dtype[Any]:
    """Return the record of an env: its action, and all that ``step`` returns."""
    space = env.observation_space
    spaces = space.spaces if isinstance(space, gym.spaces.Dict) else {"alone": space}
    observed = np.dtype([(name, each.dtype, each.shape) for name, each in spaces.items()], align=True)
    info = info_dtype(catalog.scenario(env.settings.scenario).truth, env.settings.tracker is not None)
    ends = [("reward", "f8"), ("terminated", "?"), ("truncated", "?")]
    results = [("observed", observed), ("info", info), ("final_observed", observed), ("final_info", info)]
    return np.dtype([("action", "f8", env.action_space.shape), *ends, *results], align=True)


def _modules_of(settings: Any) -> list[str]:
    """Return the modules that register what settings name."""
    scenario = catalog.scenario(settings.scenario)
    named = {entry.place.partition(":")[0] for entry in catalog.entries() if entry.id == scenario.id}
    if isinstance(settings.tracker, str):
        named.add(registry.entry(settings.tracker).tracker.__module__)
    if isinstance(settings.controller, str):
        named.add(controller_entry(settings.controller, scenario.carrier.name).controller.__module__)
    return sorted(named)


class _SharedFile:
    """Memory that processes share by a file descriptor, without a name: nothing of it is left behind."""

    def __init__(self, size: int) -> None:
        if hasattr(os, "memfd_create"):
            self.fd = os.memfd_create("envs")
        else:
            with tempfile.TemporaryFile() as file:
                self.fd = os.dup(file.fileno())
        os.ftruncate(self.fd, size)
        self.mapped = mmap.mmap(self.fd, size)

    def __enter__(self) -> _SharedFile:
        return self

    def __exit__(self, *_: object) -> None:
        # What is mapped stays.
        os.close(self.fd)
