"""Settings of this process that a contestant changes: they are its own, and others keep theirs.

A tracker may call ``np.seterr`` or ``os.chdir``, which hold for the whole process. What it sets holds on its own turns
alone. Processes and threads that it leaves behind are found when it is closed.
"""

from __future__ import annotations

import contextlib
import gc
import operator
import os
import random
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

import cv2
import numba
import numpy as np

from benchmarks.report.numbers import counted

_STARTS = ("subprocess.Popen", "os.fork", "os.posix_spawn", "os.spawn", "os.system")
"""Audit events of a process that starts another."""
Setting = tuple[Callable[[], Any], Callable[[Any], Any]]
"""Reads and sets one setting."""


def _folder() -> str | None:
    """Return the working directory; None if it was deleted."""
    with contextlib.suppress(OSError):
        return os.getcwd()
    return None


def _move_to(folder: str | None) -> None:
    with contextlib.suppress(OSError, TypeError):
        os.chdir(folder)  # type: ignore[arg-type]


def _numpy_stream() -> tuple[Any, ...]:
    # What users' trackers draw from, not ours.
    name, keys, *rest = np.random.get_state()  # noqa: NPY002
    return name, keys.tobytes(), *rest  # type: ignore[attr-defined]


def _set_numpy_stream(state: tuple[Any, ...]) -> None:
    name, keys, *rest = state
    np.random.set_state((name, np.frombuffer(keys, np.uint32), *rest))  # noqa: NPY002


_SETTINGS: dict[str, Setting] = {
    # Old code needs ``np.int = int``; ``np.bool = bool`` breaks NumPy itself.
    "NumPy's names": (lambda: dict(vars(np)), lambda names: vars(np).update(names)),
    "NumPy's error state": (np.geterr, lambda state: np.seterr(**state)),
    "the working directory": (_folder, _move_to),
    "the filters of warnings": (
        lambda: list(warnings.filters),
        partial(operator.setitem, warnings.filters, slice(None)),
    ),
    "OpenCV's threads": (cv2.getNumThreads, cv2.setNumThreads),
    "numba's threads": (numba.get_num_threads, numba.set_num_threads),
    "Python's random numbers": (random.getstate, random.setstate),
    "NumPy's random numbers": (_numpy_stream, _set_numpy_stream),
}


def _settings() -> dict[str, Setting]:
    """Return all settings, those of PyTorch too once something has imported it."""
    torch = sys.modules.get("torch")
    if not hasattr(torch, "set_grad_enabled"):
        return _SETTINGS
    return _SETTINGS | {
        "PyTorch's default type": (torch.get_default_dtype, torch.set_default_dtype),  # type: ignore[union-attr]
        "PyTorch's threads": (torch.get_num_threads, torch.set_num_threads),  # type: ignore[union-attr]
        "PyTorch's gradients": (torch.is_grad_enabled, torch.set_grad_enabled),  # type: ignore[union-attr]
        "PyTorch's random numbers": (
            lambda: torch.get_rng_state().numpy().tobytes(),  # type: ignore[union-attr]
            lambda state: torch.set_rng_state(torch.tensor(np.frombuffer(state, np.uint8))),  # type: ignore[union-attr]
        ),
    }


class _Children:
    """The processes that this one has started; they are looked up again once it has started another."""

    def __init__(self) -> None:
        self._starts, self._known_at = 0, -1
        self._known: set[int] = set()

    def now(self) -> set[int]:
        """Return them."""
        if self._known_at < 0:
            sys.addaudithook(self._count)
        if self._known_at != self._starts:
            self._known_at, self._known = self._starts, _children()
        return self._known

    def _count(self, event: str, arguments: object) -> None:
        self._starts += event in _STARTS


_CHILDREN = _Children()


class ProcessState:
    """What one contestant has set in this process, and started in it."""

    def __init__(self) -> None:
        self._own: dict[str, Any] = {}
        self._children: set[int] = set()
        self._threads: set[threading.Thread] = set()

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Have the contestant's settings in this context, and afterwards those from before it.

        A child process that a contestant has forked, and that comes back from its turn, ends here.
        """
        process, settings = os.getpid(), _settings()
        others = {name: read() for name, (read, _) in settings.items()}
        children, threads = _CHILDREN.now(), set(threading.enumerate())
        for name, value in self._own.items():
            settings[name][1](value)
        try:
            yield
        finally:
            if os.getpid() != process:
                os._exit(1)
            for name, (read, set_to) in settings.items():
                value = read()
                self._own.pop(name, None)
                if value != others[name]:
                    self._own[name] = value
                    set_to(others[name])
            self._threads |= set(threading.enumerate()) - threads
            self._children |= _CHILDREN.now() - children

    def close(self) -> list[str]:
        """End the processes that the contestant has left, and return in words what it has left; it is dropped before.

        Threads cannot be ended.
        """
        if self._children:
            # What ends its process when it is dropped may be part of a cycle.
            gc.collect()
        running = _parents()
        left = [each for each in self._children if each in running]
        for each in left:
            _end(each, running)
        threads = sum(thread.is_alive() for thread in self._threads)
        words = [f"left {counted(len(left), 'process', 'processes')} running, now ended"] * bool(left)
        return words + [f"left {counted(threads, 'thread')} running"] * bool(threads)


def _children() -> set[int]:
    """Return the processes that this one has started; none where no file tells them (Linux has some)."""
    return {child for child, parent in _parents().items() if parent == os.getpid()} - {_resource_tracker()}


def _parents() -> dict[int, int]:
    """Return the parent of each process that runs."""
    parents = {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError, ValueError):
            state, parent = file.read_text().rpartition(")")[2].split()[:2]
            if state != "Z":
                parents[int(file.parent.name)] = int(parent)
    return parents


def _end(process: int, parents: Mapping[int, int]) -> None:
    """End a process and all that it has started."""
    with contextlib.suppress(OSError):
        os.kill(process, signal.SIGKILL)
    for child, parent in parents.items():
        if parent == process:
            _end(child, parents)


def _resource_tracker() -> int | None:
    """Return the process that ``multiprocessing`` starts once for all."""
    return getattr(getattr(resource_tracker, "_resource_tracker", None), "_pid", None)
