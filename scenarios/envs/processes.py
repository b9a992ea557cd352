"""Rendered envs in parallel, one process each."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import resource_tracker
from typing import Any

import gymnasium as gym
from gymnasium.vector import AsyncVectorEnv


class EnvProcesses(AsyncVectorEnv[Any, Any]):
    """Gymnasium's ``AsyncVectorEnv`` that closes without waiting and ignores Ctrl-C, which its owner handles.

    Processes are spawned: threads of OpenCV and numba in this process would not survive a fork.

    Args:
        env_fns: picklable constructors, one per env.
        options: of ``AsyncVectorEnv``.

    Raises:
        ChildProcessError: from ``reset`` and ``step``, if a process has died.
    """

    def __init__(self, env_fns: Sequence[Callable[[], gym.Env[Any, Any]]], **options: Any) -> None:
        # Started later, by the first process, the tracker would unblock Ctrl-C again.
        resource_tracker.ensure_running()
        with _without_ctrl_c(), _naming_deaths():
            super().__init__(env_fns, context="spawn", **options)

    def reset(self, **options: Any) -> Any:
        """See ``AsyncVectorEnv``."""
        with _naming_deaths():
            return super().reset(**options)

    def step(self, actions: Any) -> Any:
        """See ``AsyncVectorEnv``."""
        with _naming_deaths():
            return super().step(actions)

    def close_extras(self, timeout: float | None = None, terminate: bool = False) -> None:
        """Kill the processes; Gymnasium's version waits for answers, which Ctrl-C or a dead process may have lost."""
        for process in self.processes:
            process.kill()
        for process in self.processes:
            process.join()


@contextlib.contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """Block Ctrl-C, in processes started meanwhile for good."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def _naming_deaths() -> Iterator[None]:
    try:
        yield
    except (EOFError, ConnectionError):
        raise ChildProcessError("envs: expected every process to answer, got the end of one (out of memory?)") from None
