"""Processes that hold an object each and answer calls of its methods, all at the same time."""

from __future__ import annotations

import contextlib
import importlib
import os
import pickle
import runpy
import signal
import subprocess
import sys
import types
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

import cloudpickle
import cv2
import gymnasium as gym
import numba

from sim.checks import check

_START = "import sys; from scenarios.envs.workers import serve; serve(int(sys.argv[1]))"
_SCRIPT = "__mp_main__"
"""Name under which a process runs the script of another one; multiprocessing's too."""
_TOLD = (ValueError, RuntimeError, TypeError, AttributeError, gym.error.ResetNeeded)
"""Errors that come back as what they are; all others as RuntimeError."""


class Workers:
    """Objects in processes of their own.

    A process imports the modules that it is told, and not the script that runs: that needs no ``if __name__ ==
    "__main__"``. It ignores Ctrl-C, which this process handles, and ends with this one.
    """

    def __init__(self, makes: Sequence[Callable[[], Any]], modules: Sequence[str], shared_fd: int) -> None:
        """Start a process for each object.

        Args:
            makes: return the objects, each in its process; functions and objects of a script are copied there.
            modules: names of those that are imported first. ``__main__``: the script is run, as ``_SCRIPT``.
            shared_fd: file descriptor that the processes inherit.
        """
        self._processes: list[subprocess.Popen[bytes]] = []
        self._connections: list[Connection] = []
        wanted = 'envs made below `if __name__ == "__main__":` only, where it registers what they name itself'
        check("script", sys.modules["__main__"].__name__ != _SCRIPT, wanted, "others")
        script = getattr(sys.modules["__main__"], "__file__", None) if "__main__" in modules else None
        imported = [name for name in modules if name != "__main__"]
        # With -P, no folder comes before those of this process.
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
        try:
            for make in makes:
                own, theirs = Pipe()
                command = [sys.executable, "-P", "-c", _START, str(theirs.fileno())]
                inherited = (theirs.fileno(), shared_fd)
                with theirs, _without_ctrl_c():
                    self._processes.append(subprocess.Popen(command, env=environment, pass_fds=inherited))
                self._connections.append(own)
                own.send_bytes(cloudpickle.dumps((imported, script)))
                own.send_bytes(cloudpickle.dumps(make))
            self._answers()
        except BaseException:
            self.close()
            raise

    @property
    def ids(self) -> list[int]:
        """Numbers of the processes."""
        return [process.pid for process in self._processes]

    def call(self, method: str, *arguments: Sequence[Any]) -> list[Any]:
        """Call a method of every object and return the answers, when all have come.

        Args:
            arguments: of each parameter, a value for each object.

        Raises:
            ChildProcessError: if a process has died; the others are ended, as they are by Ctrl-C meanwhile.
            Exception: the first one that a method raised.
        """
        if not self._processes:
            wanted = "envs: expected processes that run, got none: one died before, or a call was interrupted"
            raise ChildProcessError(wanted)
        with self._whole():
            for connection, *given in zip(self._connections, *arguments, strict=True):
                connection.send_bytes(cloudpickle.dumps((method, given)))
        return self._answers()

    def close(self) -> None:
        """End the processes without waiting for their answers."""
        for process in self._processes:
            process.kill()
        for process in self._processes:
            process.wait()
        for connection in self._connections:
            connection.close()
        self._processes.clear()
        self._connections.clear()

    def _answers(self) -> list[Any]:
        with self._whole():
            answers = [connection.recv() for connection in self._connections]
        for _, error in answers:
            if error is not None:
                kind, text = error
                raise kind(text)
        return [answer for answer, _ in answers]

    @contextlib.contextmanager
    def _whole(self) -> Iterator[None]:
        """End all processes if one dies, or Ctrl-C leaves answers unread, which the next call would take for its."""
        try:
            yield
        except BaseException as error:
            self.close()
            if not isinstance(error, EOFError | ConnectionError):
                raise
            wanted = "envs: expected every process to answer, got the end of one (out of memory?)"
            raise ChildProcessError(wanted) from None


@contextlib.contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """Block Ctrl-C, in processes started meanwhile for good."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve(connection_fd: int) -> None:
    """Answer the calls of the process at the other end of a connection, until it closes it or dies."""
    # Processes share the cores; one alone would start threads on all of them.
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    with Connection(connection_fd) as connection, contextlib.suppress(EOFError, ConnectionError):
        served, error = _tried(partial(_made, *(connection.recv_bytes() for _ in range(2))))
        connection.send((None, error))
        while error is None:
            method, given = cloudpickle.loads(connection.recv_bytes())
            connection.send_bytes(_answer(*_tried(partial(getattr(served, method), *given))))


def _answer(answer: Any, error: tuple[type[Exception], str] | None) -> bytes:
    """Return what is sent, which says so if an answer cannot be."""
    try:
        return pickle.dumps((answer, error))
    except Exception as reason:
        return pickle.dumps((None, (TypeError, f"call: expected a result that can be sent, got {reason}")))


def _made(imported: bytes, make: bytes) -> Any:
    modules, script = cloudpickle.loads(imported)
    for module in modules:
        importlib.import_module(module)
    if script is not None:
        # As multiprocessing does.
        main = types.ModuleType(_SCRIPT)
        sys.modules["__main__"] = sys.modules[_SCRIPT] = main
        main.__dict__.update(runpy.run_path(script, run_name=_SCRIPT))
    return cloudpickle.loads(make)()


def _tried(function: Callable[[], Any]) -> tuple[Any, tuple[type[Exception], str] | None]:
    """Return what a function returns, and the kind and text of what it raises."""
    try:
        return function(), None
    except Exception as error:
        kind = type(error)
        return None, (kind, str(error)) if kind in _TOLD else (RuntimeError, f"{kind.__name__}: {error}")
