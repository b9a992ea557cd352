"""Envs with pictures side by side, each in a process of its own."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import resource_tracker
from typing import Any

import gymnasium as gym
from gymnasium.vector import AsyncVectorEnv


class EnvProcesses(AsyncVectorEnv[Any, Any]):
    """Gymnasium's ``AsyncVectorEnv``, closed without waiting and deaf to Ctrl-C, which is its owner's to handle.

    Processes are spawned: OpenCV's and numba's threads, which this process may have started, do not outlive a fork.

    Args:
        env_fns: what makes each env, can be pickled.
        options: of ``AsyncVectorEnv``.

    Raises:
        ChildProcessError: from ``reset`` and ``step``, if a process has died.
    """

    def __init__(self, env_fns: Sequence[Callable[[], gym.Env[Any, Any]]], **options: Any) -> None:
        # It would let Ctrl-C through again when it is started by the first process.
        resource_tracker.ensure_running()
        # A process inherits which signals are blocked.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            with _deaths_told():
                super().__init__(env_fns, context="spawn", **options)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def reset(self, **options: Any) -> Any:
        """See ``AsyncVectorEnv``."""
        with _deaths_told():
            return super().reset(**options)

    def step(self, actions: Any) -> Any:
        """See ``AsyncVectorEnv``."""
        with _deaths_told():
            return super().step(actions)

    def close_extras(self, timeout: float | None = None, terminate: bool = False) -> None:
        """End the processes and their worlds; Gymnasium's waits for answers, which Ctrl-C or a death may have lost."""
        for process in self.processes:
            process.kill()
        for process in self.processes:
            process.join()


@contextlib.contextmanager
def _deaths_told() -> Iterator[None]:
    try:
        yield
    except (EOFError, ConnectionError):
        raise ChildProcessError("envs: expected every process to answer, got the end of one (out of memory?)") from None
