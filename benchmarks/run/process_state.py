"""Settings of this process that a tracker changes: they are its own, and others keep theirs.

A tracker may call ``np.seterr`` or ``os.chdir``, which hold for the whole process. What it sets holds on its own turns
alone, but for settings that nothing reads back (``cv2.setRNGSeed``, ``torch.set_flush_denormal``) and attributes of
modules. Processes that it leaves behind end when it is closed.
"""

from __future__ import annotations

import contextlib
import gc
import operator
import os
import pickle
import random
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

import cv2
import numba
import numpy as np
from joblib.externals.loky.backend import resource_tracker as resource_tracker_of_loky

from benchmarks.contract.text import counted
from trackers.clients.child import running
from trackers.clients.keeper import children_of

_NOTICED_S = 1.0
Setting = tuple[Callable[[], Any], Callable[[Any], Any]]
"""Reads and sets one setting."""


def _folder() -> str | None:
    """Return the working directory; None if it was deleted."""
    with contextlib.suppress(OSError):
        return os.getcwd()
    return None


def _move_to(folder: str | None) -> None:
    with contextlib.suppress(OSError):
        if folder is not None:
            os.chdir(folder)


def _set_environment(values: Mapping[str, str]) -> None:
    os.environ.clear()
    os.environ.update(values)


_SETTINGS: dict[str, Setting] = {
    "NumPy's error state": (np.geterr, lambda state: np.seterr(**state)),
    "NumPy's random numbers": (
        # What users' trackers draw from, not ours; in bytes, as arrays have no truth value.
        lambda: pickle.dumps(np.random.get_state()),  # noqa: NPY002
        lambda state: np.random.set_state(pickle.loads(state)),  # noqa: NPY002
    ),
    "Python's random numbers": (random.getstate, random.setstate),
    "the working directory": (_folder, _move_to),
    "the environment": (os.environ.copy, _set_environment),
    "the filters of warnings": (
        lambda: list(warnings.filters),
        lambda filters: operator.setitem(warnings.filters, slice(None), filters),  # type: ignore[call-overload]
    ),
    "the path of modules": (lambda: list(sys.path), lambda folders: operator.setitem(sys.path, slice(None), folders)),
    "the garbage collector": (gc.isenabled, lambda is_on: gc.enable() if is_on else gc.disable()),
    "OpenCV's threads": (cv2.getNumThreads, cv2.setNumThreads),
    "OpenCV's optimisation": (cv2.useOptimized, cv2.setUseOptimized),
    "numba's threads": (numba.get_num_threads, numba.set_num_threads),
}


def _settings() -> dict[str, Setting]:
    """Return all settings, those of PyTorch too once something has imported it."""
    torch: Any = sys.modules.get("torch")
    if not hasattr(torch, "set_grad_enabled"):
        return _SETTINGS
    return _SETTINGS | {
        "PyTorch's default type": (torch.get_default_dtype, torch.set_default_dtype),
        "PyTorch's threads": (torch.get_num_threads, torch.set_num_threads),
        "PyTorch's gradients": (torch.is_grad_enabled, torch.set_grad_enabled),
        "PyTorch's random numbers": (
            lambda: torch.get_rng_state().numpy().tobytes(),
            lambda state: torch.set_rng_state(torch.tensor(np.frombuffer(state, np.uint8))),
        ),
    }


class ProcessState:
    """What one tracker has set in this process, and started in it."""

    def __init__(self) -> None:
        self._own: dict[str, Any] = {}
        self._children: set[int] = set()

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Have the tracker's settings in this context, and afterwards those from before it.

        A child process that a tracker has forked, and that comes back from its turn, ends here.
        """
        process, children, settings = os.getpid(), _children(), _settings()
        others = {name: read() for name, (read, _) in settings.items()}
        for name, value in self._own.items():
            settings[name][1](value)
        try:
            yield
        finally:
            if os.getpid() != process:
                os._exit(1)
            own = {name: read() for name, (read, _) in settings.items()}
            self._own = {name: value for name, value in own.items() if value != others[name]}
            for name in self._own:
                settings[name][1](others[name])
            self._children |= _children() - children

    def close(self) -> list[str]:
        """End the processes that the tracker has left, and return in words that it has; it is dropped before."""
        if not self._children:
            return []
        # What ends its process when it is dropped may be part of a cycle.
        gc.collect()
        left = sum(map(_end, self._children))
        if not left:
            return []
        # Until a pool of joblib's has noticed, it takes work that nothing does.
        for thread in threading.enumerate():
            if "loky" in type(thread).__module__:
                thread.join(_NOTICED_S)
        return [f"left {counted(left, 'process', 'processes')} running, ended with the episode (start anew in each)"]


def _end(child: int) -> bool:
    """End a child process; return whether it still ran."""
    with contextlib.suppress(ChildProcessError):  # It has been waited for; its number may be another process's now.
        if os.waitpid(child, os.WNOHANG) == (0, 0):
            os.kill(child, signal.SIGKILL)
            return True
    return False


def _children() -> set[int]:
    """Return the processes that this one has started; none where no file lists them (on Linux some do).

    Those that ``multiprocessing`` and joblib's loky start once for all do not count, nor do trackers' own processes,
    which serve several episodes.
    """
    trackers = (getattr(module, "_resource_tracker", None) for module in (resource_tracker, resource_tracker_of_loky))
    return children_of("self") - {getattr(each, "_pid", None) for each in trackers} - running()
