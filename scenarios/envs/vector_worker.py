"""Who holds the envs of a vector env: this process, or workers, which are told what to do through pipes.

Only requests and short answers go through a pipe (and pictures that were rendered); actions and all that comes of them
lie in shared arrays.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import pickle
import signal
from collections.abc import Iterator, Mapping
from multiprocessing.connection import Connection
from typing import Any, Protocol

import cv2
import numba
from numpy.typing import NDArray

from scenarios.envs.env_group import EnvGroup, Failure, Plan
from scenarios.envs.shared_arrays import Layout, arrays_in

_FAREWELL_S = 5.0
"""How long a worker may take to close its envs before it is ended: it may be in the middle of a reset."""
_CONTEXT = multiprocessing.get_context("spawn")


class Host(Protocol):
    """Holds some envs. Ask, then take the answer; several hosts work at the same time."""

    indices: tuple[int, ...]

    def ask(self, request: str, *arguments: Any) -> None:
        """Begin a request, see ``EnvGroup.answer``."""
        ...

    def answer(self) -> Any:
        """Wait for the latest request's answer and return it, or a Failure."""
        ...

    def dismiss(self) -> None:
        """Say that no more will be asked, without waiting."""
        ...

    def close(self) -> None:
        """Free everything."""
        ...


class ThisProcess:
    """A host without a worker."""

    def __init__(self, plan: Plan, indices: tuple[int, ...], arrays: Mapping[str, NDArray[Any]]) -> None:
        self.indices = indices
        self._group = EnvGroup(plan, indices, arrays)
        self._request: tuple[Any, ...] | None = None

    def ask(self, request: str, *arguments: Any) -> None:
        """See ``Host``."""
        self._request = (request, *arguments)

    def answer(self) -> Any:
        """See ``Host``."""
        request, self._request = self._request, None
        return None if request is None else self._group.answer(*request)

    def dismiss(self) -> None:
        """See ``Host``."""

    def close(self) -> None:
        """See ``Host``."""
        self._group.close()


class Worker:
    """A host in a process of its own. The first answer, without a request, says whether it has started."""

    def __init__(self, number: int, plan: Plan, indices: tuple[int, ...], block: Any, layout: Layout) -> None:
        self.indices = indices
        self._name = f"worker {number} (envs {', '.join(map(str, indices))})"
        self._is_up = False
        self._connection, far_end = _CONTEXT.Pipe()
        self._process = _CONTEXT.Process(
            target=_serve, args=(far_end, plan, indices, block, layout), name=f"frameout-{number}", daemon=True
        )
        try:
            with _interrupts_blocked():
                self._process.start()
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            self._connection.close()
            wanted = "values that can be pickled, as workers need (or workers=0)"
            raise ValueError(f"keywords: expected {wanted}, got {type(error).__name__}: {error}") from None
        finally:
            # The worker's alone from now on: when it dies, reading finds the end.
            far_end.close()

    @property
    def process_id(self) -> int:
        """Of the worker."""
        assert self._process.pid is not None
        return self._process.pid

    def ask(self, request: str, *arguments: Any) -> None:
        """See ``Host``."""
        # Of a dead worker the answer tells.
        with contextlib.suppress(OSError):
            self._connection.send((request, *arguments))

    def answer(self) -> Any:
        """See ``Host``."""
        try:
            answer = self._connection.recv()
        except (EOFError, OSError):
            return Failure(self._name, "it to answer" if self._is_up else "it to start", self._ending())
        self._is_up = True
        return answer

    def dismiss(self) -> None:
        """See ``Host``."""
        with contextlib.suppress(OSError):
            self._connection.send(None)

    def close(self) -> None:
        """See ``Host``."""
        self._process.join(_FAREWELL_S)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._process.close()
        self._connection.close()

    def _ending(self) -> str:
        self._process.join(_FAREWELL_S)
        code = self._process.exitcode
        hint = "" if self._is_up else "; a script that starts workers needs `if __name__ == '__main__':`"
        return f"its end (exit code {code}){hint}"


def _serve(connection: Connection, plan: Plan, indices: tuple[int, ...], block: Any, layout: Layout) -> None:
    """Live as a worker, until the other end of the pipe says None or is gone."""
    # Ctrl-C reaches every process of a terminal; the one that holds the vector env closes the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    with connection, contextlib.suppress(EOFError, OSError):
        group = EnvGroup(plan, indices, arrays_in(block, layout, plan.num_envs))
        connection.send(None)
        try:
            while (request := connection.recv()) is not None:
                connection.send(group.answer(*request))
        finally:
            group.close()


@contextlib.contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Hold Ctrl-C back: a process that is started meanwhile does not see it before it says what it does about it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
