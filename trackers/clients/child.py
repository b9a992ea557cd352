"""A tracker's process: its start, its limits, its CPU time, its end, and what it writes besides its answers.

It runs in an empty folder of its own, with the variables of the environment that ``_PASSED`` names, and inherits no
file but the ends of its pipes. What it prints is read and dropped, but for the last words. It and all that it starts
are ended together, by a ``keeper`` between the two, also when this process is ended itself.
"""

from __future__ import annotations

import contextlib
import os
import re
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from io import RawIOBase
from pathlib import Path
from typing import IO

import psutil

from trackers.clients import keeper
from trackers.clients.keeper import children_of

_PASSED = re.compile(
    "PATH|HOME|USER|LOGNAME|SHELL|LANG|LANGUAGE|TZ|TMPDIR|DISPLAY|(DY)?LD_LIBRARY_PATH|(?i:(http|https|no)_proxy)|"
    "(LC|XDG|SSL|CUDA|NVIDIA|HIP|ROCR|HF|TORCH|TF|XLA|JAX|KERAS|NPY|NUMBA|OPENCV|OPENBLAS|OMP|MKL|KMP|UV|PIP)_.*"
)
"""Names of variables that a process gets; no ``PYTHONPATH``, which leads another Python to our packages."""
_TICK_S = 0.05
"""How often limits are looked at while a process works."""
_LISTED_S = 0.2
"""How often its children, and theirs, are listed, whose CPU time and memory count too."""
_ENDING_S = 1.0
"""Longest wait for the end of a process whose pipe is closed."""
_KEEPER_S = 30.0
"""Longest wait for the start and for the end of a keeper."""
_LAST_WORDS = 4096
LONGEST_ANSWER = 1 << 30
"""Bytes."""
_PIECE, _WIDE = 1 << 16, 1 << 20


_RUNNING: weakref.WeakSet[Child] = weakref.WeakSet()


def running() -> set[int]:
    """Return the ids of the keepers of trackers that this process has started."""
    return {child.keeper_pid for child in _RUNNING}


class ProcessError(RuntimeError):
    """A tracker's process ended, broke its protocol, or went beyond a limit."""


@dataclass(frozen=True)
class Limits:
    """What a tracker's process may take.

    Attributes:
        start_s: wall time from its start to its greeting, for imports and weights.
        frame_s: wall time for one answer. frame_cpu_s: CPU time for it, of all its processes.
        memory_gb: resident memory of all its processes, what they share counted once; None = half of the machine's.
    """

    start_s: float = 300.0
    frame_s: float = 600.0
    frame_cpu_s: float = 60.0
    memory_gb: float | None = None

    @property
    def memory_bytes(self) -> float:
        """Resident memory in bytes."""
        return 0.5 * psutil.virtual_memory().total if self.memory_gb is None else 1e9 * self.memory_gb


class Child:
    """A running process. After an error the caller calls ``kill``.

    Attributes:
        spent_cpu_s: CPU time of all its processes on the latest exchange, with what they have spent since the one
            before.
        pid: of the process itself. keeper_pid: of its parent. folder: where it runs.
    """

    def __init__(
        self,
        command: Sequence[str],
        limits: Limits,
        environment: Mapping[str, str],
        files: Sequence[int] = (),
        fill: Callable[[Path], object] = lambda folder: None,
    ) -> None:
        """Start ``command``, with variables ``environment`` beside those of ``_PASSED``; it inherits ``files``, and its
        folder holds what ``fill`` puts there.

        Raises:
            ProcessError: if it cannot be started.
        """
        if not hasattr(select, "poll"):
            raise ProcessError(f"a tracker in its own process needs Linux or macOS, got {sys.platform}")
        self.limits, self.spent_cpu_s = limits, 0.0
        passed = {name: value for name, value in os.environ.items() if _PASSED.fullmatch(name)}
        with ExitStack() as made:
            folder = made.enter_context(tempfile.TemporaryDirectory(prefix="tracker-", ignore_cleanup_errors=True))
            fill(Path(folder))
            leash, held = socket.socketpair()
            made.callback(leash.close)
            with held:
                numbers = str(held.fileno()), ",".join(map(str, files))
                try:
                    process = subprocess.Popen(
                        [sys.executable, "-I", "-S", keeper.__file__, *numbers, *command],
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        stderr=subprocess.PIPE,
                        bufsize=0,
                        cwd=folder,
                        env={**passed, **environment},
                        pass_fds=(held.fileno(), *files),
                        start_new_session=True,
                    )
                except OSError as error:
                    raise ProcessError(f"it cannot be started: {error}") from None
            self.folder = Path(folder)
            self._made = made.pop_all()
        self._close = weakref.finalize(self, _end, os.getpid(), process, leash, self._made)
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        self._leash, self._told = leash, b""
        self._status: int | None = None
        self.keeper_pid = process.pid
        _RUNNING.add(self)
        try:
            self.pid = self._started()
        except BaseException:
            self.kill()
            raise
        self._inputs = list[IO[bytes] | RawIOBase]([process.stdin])
        self.stdin, self.stdout = process.stdin.fileno(), process.stdout.fileno()
        self._stderr = process.stderr.fileno()
        os.set_blocking(self.stdin, False)
        self._said, self._ended = {self.stdout: bytearray(), self._stderr: bytearray()}, set[int]()
        self._poll = select.poll()
        for stream in self._said:
            self._poll.register(stream, select.POLLIN)
        self._known: dict[int, float] = {self.pid: 0.0}
        self._looked_s = time.monotonic()
        self._listed_s = 0.0

    def _started(self) -> int:
        """Return the id of the process that the keeper has started."""
        line = self._line(_KEEPER_S) or "its keeper does not start"
        if not line.startswith("runs "):
            raise ProcessError(f"it cannot be started: {line.removeprefix('failed ')}")
        return int(line.removeprefix("runs "))

    def _status_within(self, limit_s: float) -> int | None:
        """Return the exit status of the process once it has ended, negative for a signal; None if it runs on."""
        if self._status is None and (line := self._line(limit_s)):
            self._status = int(line.removeprefix("ended "))
        return self._status

    def _line(self, limit_s: float) -> str | None:
        """Return the keeper's next line if it comes within a limit."""
        self._leash.settimeout(limit_s)
        with contextlib.suppress(TimeoutError, BlockingIOError):
            while b"\n" not in self._told:
                self._told += self._leash.recv(_PIECE) or b"ended -9\n"  # Of the keeper itself.
            line, _, self._told = self._told.partition(b"\n")
            return line.decode()
        return None

    @property
    def is_alive(self) -> bool:
        """Whether it has not been ended by ``kill``, and runs."""
        return self._close.alive and self._status_within(0.0) is None

    def take_ends(self, requests: RawIOBase, replies: RawIOBase) -> None:
        """Read answers from the pipe ``replies`` too; both pipes are closed with the process."""
        self._inputs.append(requests)
        os.set_blocking(requests.fileno(), False)
        self._said[replies.fileno()] = bytearray()
        self._poll.register(replies, select.POLLIN)
        for pipe in (requests, replies):
            self._made.callback(pipe.close)

    def exchange(
        self, sent: bytes, into: int, answer: Callable[[int, bytearray], int | None], limit_s: float, of: Sequence[int]
    ) -> tuple[int, bytes]:
        """Send bytes and return the file and the bytes of the answer.

        Args:
            sent: maybe none. into: the file that takes them.
            answer: returns how many of the bytes that a file has said so far are a whole answer; None until then.
            limit_s: of wall time.
            of: files that an answer may come from.

        Raises:
            ProcessError: if the process ends, closes a file, goes beyond a limit, or has answered before.
        """
        if not self._close.alive:
            raise ProcessError("it has been ended")
        began_s, unsent = time.monotonic(), memoryview(sent)
        if unsent:
            for file, _ in self._poll.poll(0):
                self._read(file, of)
            if early := self._answer(answer, of):
                raise ProcessError(f"it answered before it was asked: {early[1][:60]!r}")
            if unsent := unsent[self._write(into, unsent) :]:
                self._poll.register(into, select.POLLOUT)
        while True:
            # What is said before the whole request can be read is looked at afterwards.
            if not unsent and (found := self._answer(answer, of)):
                self._account()
                return found
            ready = self._poll.poll(1000.0 * _TICK_S)
            for file, _ in ready:
                if file == into and unsent:
                    unsent = unsent[self._write(file, unsent) :]
                    if not unsent:
                        self._poll.unregister(file)
                else:
                    self._read(file, of)
            if not ready and self._status_within(0.0) is not None:
                raise ProcessError(self._ending())
            if time.monotonic() - max(self._looked_s, began_s) > _TICK_S:
                self._look(began_s, limit_s)

    def _answer(self, answer: Callable[[int, bytearray], int | None], of: Sequence[int]) -> tuple[int, bytes] | None:
        for file in of:
            said = self._said[file]
            if (length := answer(file, said)) is not None:
                whole = bytes(memoryview(said)[:length])
                del said[:length]
                return file, whole
        return None

    def wait(self, limit_s: float) -> None:
        """Wait for its end. Raises ProcessError if that comes late, is no success, or is one of a limit."""
        began_s = time.monotonic()
        while self._status_within(0.0) is None:
            for file, _ in self._poll.poll(1000.0 * _TICK_S):
                self._read(file, (-1,))
            self._look(began_s, limit_s)
        self._account()
        if self._status != 0:
            raise ProcessError(self._ending())

    def strays(self) -> set[int]:
        """Return the processes that it has started and that are not below it any more."""
        if not self._close.alive:
            return set()
        return {pid for pid in children_of(self.keeper_pid) - {self.pid} if _runs(pid)}

    def kill(self) -> None:
        """End it and all that it has started; a second call does nothing."""
        self._close()

    def widen_input(self) -> None:
        """Widen the pipe of its standard input, so that a picture fits into it, where the system allows that."""
        if sys.platform == "linux":
            import fcntl  # Windows has none.

            with contextlib.suppress(OSError):
                fcntl.fcntl(self.stdin, fcntl.F_SETPIPE_SZ, _WIDE)

    def close(self, farewell: bytes = b"") -> None:
        """Send a ``farewell``, close all that it reads, wait a second for its end, and ``kill`` it."""
        if self._close.alive:
            with contextlib.suppress(OSError):
                os.write(self.stdin, farewell)
            for pipe in self._inputs:
                pipe.close()
            self._status_within(_ENDING_S)
        self.kill()

    def _write(self, file: int, unsent: memoryview) -> int:
        try:
            return os.write(file, unsent[:_WIDE])
        except BlockingIOError:
            return 0
        except BrokenPipeError:
            raise ProcessError(self._ending()) from None

    def _read(self, file: int, of: Sequence[int]) -> None:
        """Read what a file has; raise ProcessError at the end of the last one ``of`` which an answer may come."""
        piece = os.read(file, _PIECE)
        if not piece:
            self._poll.unregister(file)
            self._ended.add(file)
            if self._ended.issuperset(of):
                raise ProcessError(self._ending())
        said = self._said[file]
        said += piece
        if len(said) > LONGEST_ANSWER:
            raise ProcessError(f"it says more than {LONGEST_ANSWER:,} bytes that are no whole answer")
        if file not in of:
            del said[:-_LAST_WORDS]

    def _look(self, began_s: float, limit_s: float) -> None:
        """Raise ProcessError for a process that has ended or is beyond a limit."""
        self._looked_s = now_s = time.monotonic()
        if now_s - self._listed_s > _LISTED_S:
            self._list()
        if now_s - began_s > limit_s:
            raise ProcessError(f"it did not answer within {limit_s:g} s")
        self._weigh()
        if self._cpu_s() - sum(self._known.values()) > self.limits.frame_cpu_s:
            raise ProcessError(f"it took longer than {self.limits.frame_cpu_s:g} s of CPU time over one answer")

    def _weigh(self) -> None:
        most = self.limits.memory_bytes
        # What processes share takes milliseconds to find out.
        if sum(map(_resident_bytes, self._known)) > most and (used := sum(map(_share_bytes, self._known))) > most:
            limit = f"{1e-9 * most:.3g} GB"
            raise ProcessError(f"it takes {1e-9 * used:.3g} GB of memory, more than its limit of {limit}")

    def _list(self) -> None:
        self._listed_s = time.monotonic()
        self._known.update({pid: 0.0 for pid in _below(self.keeper_pid) if pid not in self._known})

    def _cpu_s(self) -> float:
        return sum(max(_cpu_s(pid), before) for pid, before in self._known.items())

    def _account(self) -> None:
        if time.monotonic() - self._listed_s > _LISTED_S:
            self._list()
            self._weigh()
        now = {pid: max(_cpu_s(pid), before) for pid, before in self._known.items()}
        self.spent_cpu_s = sum(now.values()) - sum(self._known.values())
        self._known = now

    def _drain(self) -> None:
        """Read what is left in its streams."""
        for file in (self.stdout, self._stderr):
            os.set_blocking(file, False)
            with contextlib.suppress(OSError):
                # No more than the pipe holds: others may go on writing into it.
                self._said[file] = bytearray((self._said[file] + os.read(file, _WIDE))[-_LAST_WORDS:])

    def _ending(self) -> str:
        """Return what became of a process that has closed a file, with its last words after a colon."""
        code = self._status_within(_ENDING_S)
        self._drain()
        fate = "it closed its pipe and runs on" if code is None else f"it ended with exit status {code}"
        if code is not None and code < 0:
            fate = f"it was ended by {signal.Signals(-code).name}"
        said = (self._said[self._stderr] or self._said[self.stdout]).decode(errors="replace").strip().splitlines()
        return f"{fate}: {said[-1][:200]}" if said else f"{fate}, without a word"


def _below(pid: int) -> set[int]:
    """Return the processes that a process has started, and those that these have."""
    children = children_of(pid)
    return children.union(*map(_below, children))


def _cpu_s(pid: int) -> float:
    """Return the CPU time of a process in seconds, of all its threads; 0 if there is none."""
    with contextlib.suppress(OSError, psutil.Error):
        if sys.platform == "linux":
            # The clock of another process, as clock_getcpuclockid(3) returns it.
            return time.clock_gettime((~pid << 3) | 2)
        times = psutil.Process(pid).cpu_times()
        return times.user + times.system
    return 0.0


def _resident_bytes(pid: int) -> int:
    with contextlib.suppress(psutil.Error):
        return int(psutil.Process(pid).memory_info().rss)
    return 0


def _share_bytes(pid: int) -> int:
    """Return the resident memory of a process, of what others share its share."""
    with contextlib.suppress(psutil.Error):
        own = psutil.Process(pid).memory_full_info()
        return int(getattr(own, "pss", own.uss))
    return _resident_bytes(pid)


def _runs(pid: int) -> bool:
    with contextlib.suppress(psutil.Error):
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    return False


def _end(starter: int, process: subprocess.Popen[bytes], leash: socket.socket, made: ExitStack) -> None:
    """Have a keeper end its program and all that this has started; close its files."""
    if os.getpid() != starter:  # A fork has no children of its own.
        return
    with contextlib.suppress(OSError):
        leash.send(b"\0")
    try:
        process.wait(_KEEPER_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    for stream in (process.stdin, process.stdout, process.stderr):
        if stream is not None:
            stream.close()
    made.close()
