"""Some of the envs of a vector env, stepped one after the other by whoever holds them."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
from numpy.typing import NDArray

from scenarios.envs.follow_env import FollowEnv, Observed
from scenarios.envs.shared_arrays import Field
from scenarios.envs.truth_info import INFO

OBSERVATION, INFORMATION = "observation/", "info/"
"""How the names of arrays begin that hold an observation (or the parts of one) and what ``info`` says."""


@dataclass(frozen=True)
class Plan:
    """What a group is told of the vector env that it belongs to.

    Attributes:
        keywords: of ``FollowEnv``.
        num_envs: of the vector env.
        max_episode_steps: steps after which an episode is truncated, or None.
    """

    keywords: dict[str, Any]
    num_envs: int
    max_episode_steps: int | None


@dataclass(frozen=True)
class Failure:
    """Why a request has no answer: who failed, at what, for which reason, and where in the code ('' if unknown)."""

    who: str
    wanted: str
    reason: str
    trace: str = ""

    def error(self) -> RuntimeError:
        """Return it as an error of one line; the trace is a note beside it."""
        error = RuntimeError(f"{self.who}: expected {self.wanted}, got {self.reason}")
        if self.trace:
            error.add_note(self.trace)
        return error


def layout_of(env: FollowEnv) -> dict[str, Field]:
    """Return the arrays of a vector env of such envs."""
    boxes = parts_of(env.observation_space)
    observation = {OBSERVATION + part: Field(str(box.dtype), tuple(box.shape or ())) for part, box in boxes.items()}
    information = {INFORMATION + key: Field(dtype, shape) for key, (dtype, shape, _) in INFO.items()}
    rest = {
        # Double precision, so that an action is the same number as one handed to an env itself.
        "action": Field("float64", tuple(env.action_space.shape or ())),
        "reward": Field("float64"),
        "terminated": Field("bool"),
        "truncated": Field("bool"),
    }
    return observation | rest | information


def parts_of(space: gym.Space[Any]) -> dict[str, gym.Space[Any]]:
    """Return the boxes that an observation consists of by their names, '' for the only one."""
    return dict(space.spaces) if isinstance(space, gym.spaces.Dict) else {"": space}


class EnvGroup:
    """Envs by their index in the vector env. What they answer goes into the arrays, in the rows of their indices.

    Autoreset is Gymnasium's ``NEXT_STEP``: the step after an episode's last one takes no notice of the action, begins
    another episode and returns its first observation with reward 0.
    """

    def __init__(self, plan: Plan, indices: Iterable[int], arrays: Mapping[str, NDArray[Any]]) -> None:
        self._envs = {index: FollowEnv(**plan.keywords) for index in indices}
        self._arrays = arrays
        self._max_episode_steps = plan.max_episode_steps
        self._steps = dict.fromkeys(self._envs, 0)

    def answer(self, request: str, *arguments: Any) -> Any:
        """Carry out ``reset``, ``step`` or ``call`` for the group's envs; return what that returns, or a Failure."""
        answers: dict[str, Callable[..., Any]] = {"reset": self._reset, "step": self._step, "call": self._call}
        return answers[request](*arguments)

    def close(self) -> None:
        """Free the worlds."""
        for env in self._envs.values():
            env.close()

    def _reset(self, seeds: Mapping[int, int | None], options: dict[str, Any] | None) -> Failure | None:
        """Reset those of the envs that have a seed, which may be None."""
        mine = [index for index in self._envs if index in seeds]
        return self._each("it to reset", lambda index: self._begin(index, seeds[index], options), mine)

    def _step(self) -> Failure | None:
        return self._each("it to step", self._advance, self._envs)

    def _call(self, name: str, *arguments: Any) -> Failure | dict[int, Any]:
        """Return what a method (or an attribute) of every env gives, by index."""
        found: dict[int, Any] = {}

        def ask(index: int) -> None:
            value = getattr(self._envs[index], name)
            found[index] = value(*arguments) if callable(value) else value

        failure = self._each(f"an answer of {name!r}", ask, self._envs)
        return failure or found

    def _each(self, wanted: str, act: Callable[[int], None], indices: Iterable[int]) -> Failure | None:
        for index in indices:
            try:
                act(index)
            except Exception as error:
                reason = f"{type(error).__name__}: {error}"
                return Failure(f"env {index}", wanted, reason, traceback.format_exc())
        return None

    def _advance(self, index: int) -> None:
        arrays = self._arrays
        if arrays["terminated"][index] or arrays["truncated"][index]:
            self._begin(index, None, None)
            return
        observed, reward, terminated, truncated, info = self._envs[index].step(arrays["action"][index])
        self._steps[index] += 1
        out_of_time = self._max_episode_steps is not None and self._steps[index] >= self._max_episode_steps
        self._write(index, observed, reward, terminated, truncated or out_of_time, info)

    def _begin(self, index: int, seed: int | None, options: dict[str, Any] | None) -> None:
        observed, info = self._envs[index].reset(seed=seed, options=options)
        self._steps[index] = 0
        self._write(index, observed, 0.0, False, False, info)

    def _write(
        self, index: int, observed: Observed, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]
    ) -> None:
        arrays = self._arrays
        parts = observed if isinstance(observed, dict) else {"": observed}
        for part, value in parts.items():
            arrays[OBSERVATION + part][index] = value
        arrays["reward"][index] = reward
        arrays["terminated"][index] = terminated
        arrays["truncated"][index] = truncated
        for key, value in info.items():
            arrays[INFORMATION + key][index] = value
