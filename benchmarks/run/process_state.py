"""Settings of this process that a tracker changes: they are its own, and others keep theirs.

A tracker may call ``np.seterr`` or ``os.chdir``, which hold for the whole process. What it sets holds on its own turns
alone, but for settings that nothing reads back (``cv2.setRNGSeed``, ``torch.set_flush_denormal``) and attributes of
modules other than NumPy. Processes and threads that it leaves behind are found when it is closed.
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
from contextlib import ExitStack, contextmanager
from multiprocessing import resource_tracker
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numba
import numpy as np
from joblib.externals.loky.backend import resource_tracker as resource_tracker_of_loky

from benchmarks.contract.text import counted

_JOIN_S = 0.1
"""Time for a thread that has been told to end."""
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


class _Names(dict[str, Any]):
    """Attributes of a module, whose values compare by identity: arrays have no truth value."""

    def __ne__(self, other: object) -> bool:
        assert isinstance(other, _Names)
        return self.keys() != other.keys() or not all(map(operator.is_, self.values(), map(other.get, self)))


def _set_numpy_names(names: Mapping[str, Any]) -> None:
    own = vars(np)
    # Modules of NumPy that have been imported since then stay.
    added = [name for name, value in own.items() if name not in names and not isinstance(value, ModuleType)]
    for name in added:
        del own[name]
    own.update(names)


def _set_environment(values: Mapping[str, str]) -> None:
    for name in os.environ.keys() - values.keys():
        del os.environ[name]
    os.environ.update(values)


def _numpy_stream() -> tuple[Any, ...]:
    # What users' trackers draw from, not ours.
    name, keys, *rest = np.random.get_state()  # noqa: NPY002
    return name, keys.tobytes(), *rest  # type: ignore[attr-defined]


def _set_numpy_stream(state: tuple[Any, ...]) -> None:
    name, keys, *rest = state
    np.random.set_state((name, np.frombuffer(keys, np.uint32), *rest))  # noqa: NPY002


_SETTINGS: dict[str, Setting] = {
    # Old code needs ``np.int = int``; ``np.bool = bool`` breaks NumPy itself.
    "NumPy's names": (lambda: _Names(vars(np)), _set_numpy_names),
    "NumPy's error state": (np.geterr, lambda state: np.seterr(**state)),
    "the working directory": (_folder, _move_to),
    "the filters of warnings": (
        lambda: list(warnings.filters),
        lambda filters: operator.setitem(warnings.filters, slice(None), filters),  # type: ignore[call-overload]
    ),
    "the environment": (os.environ.copy, _set_environment),
    "the path of modules": (lambda: list(sys.path), lambda folders: operator.setitem(sys.path, slice(None), folders)),
    "the garbage collector": (gc.isenabled, lambda is_on: gc.enable() if is_on else gc.disable()),
    "OpenCV's threads": (cv2.getNumThreads, cv2.setNumThreads),
    "OpenCV's optimisation": (cv2.useOptimized, cv2.setUseOptimized),
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


class ProcessState:
    """What one tracker has set in this process, and started in it."""

    def __init__(self) -> None:
        self._own: dict[str, Any] = {}
        self._children: set[int] = set()
        self._threads: set[threading.Thread] = set()

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Have the tracker's settings in this context, and afterwards those from before it.

        A child process that a tracker has forked, and that comes back from its turn, ends here.
        """
        settings = _settings()
        others = {name: read() for name, (read, _) in settings.items()}
        with ExitStack() as afterwards:
            afterwards.callback(self._keep_started, _children(), set(threading.enumerate()))
            for name in reversed(settings):
                afterwards.callback(self._put_back, name, settings[name], others[name])
            afterwards.callback(_end_forked, os.getpid())
            for name, value in self._own.items():
                settings[name][1](value)
            yield

    def _put_back(self, name: str, setting: Setting, others: Any) -> None:
        """Keep the tracker's value of a setting if it differs, and set that of others again."""
        read, set_to = setting
        changed = True
        self._own.pop(name, None)
        try:
            value = read()
            changed = bool(value != others)
            if changed:
                self._own[name] = value
        finally:
            if changed:
                set_to(others)

    def _keep_started(self, children: set[int], threads: set[threading.Thread]) -> None:
        """Take what runs now, and did not before, for the tracker's."""
        self._children |= _children() - children
        # Those that Python did not start cannot be joined, and count as alive for ever.
        started = (each for each in threading.enumerate() if not isinstance(each, threading._DummyThread))
        self._threads |= set(started) - threads

    def close(self) -> list[str]:
        """End the processes that the tracker has left, and return in words what it has left; it is dropped before.

        Threads cannot be ended.
        """
        if self._children or any(thread.is_alive() for thread in self._threads):
            # What ends its process or its threads when it is dropped may be part of a cycle.
            gc.collect()
        running = _parents()
        # The number of a process that has ended may be that of another one now.
        left = [each for each in self._children if running.get(each) == os.getpid()]
        for each in left:
            _end(each, running)
        for thread in self._threads:
            thread.join(_JOIN_S)
        threads = sum(thread.is_alive() and not _is_of_loky(thread) for thread in self._threads)
        ended = (
            f"left {counted(len(left), 'process', 'processes')} running, ended with the episode (start anew in each)"
        )
        return [ended] * bool(left) + [f"left {counted(threads, 'thread')} running"] * bool(threads)


def _end_forked(process: int) -> None:
    """End this process if it is not ``process``."""
    if os.getpid() != process:
        os._exit(1)


def _is_of_loky(thread: threading.Thread) -> bool:
    """Return whether a thread is one of the pool that joblib keeps for all of its callers, or fills a queue for it."""
    return "loky" in type(thread).__module__ or thread.name == "QueueFeederThread"


def _children() -> set[int]:
    """Return the processes that this one has started; none where no file tells them (Linux has some)."""
    found = set[int]()
    with contextlib.suppress(OSError):
        for thread in os.listdir("/proc/self/task"):
            with contextlib.suppress(OSError), open(f"/proc/self/task/{thread}/children", "rb", 0) as file:
                found.update(map(int, file.read().split()))
    return found - _resource_trackers()


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


def _resource_trackers() -> set[int | None]:
    """Return the processes that ``multiprocessing`` and joblib's loky start once for all."""
    modules = (resource_tracker, resource_tracker_of_loky)
    return {getattr(getattr(module, "_resource_tracker", None), "_pid", None) for module in modules}
