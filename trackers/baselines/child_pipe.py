"""A child process that answers requests over its standard streams in a limited time and never outlives its owner."""

from __future__ import annotations

import os
import select
import subprocess
import tempfile
import time
import weakref
from collections.abc import Sequence
from contextlib import ExitStack, suppress

_ENDING_S = 2.0
"""Longest wait for the end of a child that has closed a stream."""


class ChildError(RuntimeError):
    """The child ended, or did not answer in time."""


class ChildPipe:
    """Sends requests to a child process and reads replies of known length.

    The child is killed and waited for by ``close``, when the pipe is dropped, and at the interpreter's exit.
    """

    def __init__(self, command: Sequence[str], limit_s: float) -> None:
        """Start ``command``.

        Args:
            limit_s: longest time of a request with its reply.

        Raises:
            OSError: if there is no such program, or on Windows, where nothing waits for a pipe in a limited time.
        """
        if not hasattr(select, "poll"):
            raise OSError(f"{command[0]}: expected Linux or macOS, for a tracker of its own process, got {os.name}")
        self._limit_s = limit_s
        with ExitStack() as files:
            # A file, since a full pipe that nobody reads would stop the child.
            self._errors = files.enter_context(tempfile.TemporaryFile())
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, bufsize=0
            )
            self._close = weakref.finalize(self, _end, self._process, files.pop_all())
        assert self._process.stdin is not None
        os.set_blocking(self._process.stdin.fileno(), False)

    @property
    def pid(self) -> int:
        """The child's process id."""
        return self._process.pid

    def ask(self, request: bytes, reply_bytes: int) -> bytes:
        """Send a request, maybe empty, and return the reply of ``reply_bytes``.

        Raises:
            ChildError: if the child ends, closes a stream or is late. The message holds its last words on stderr.

        After any exception, one of a signal's handler included, the child is closed: a reply that comes later is never
        taken for that of another request.
        """
        if not self._close.alive:
            raise ChildError("it is closed")
        with ExitStack() as failure:
            failure.callback(self.close)
            try:
                until_s = time.monotonic() + self._limit_s
                self._send(request, until_s)
                reply = self._receive(reply_bytes, until_s)
            except BrokenPipeError:
                raise ChildError(self._ending()) from None
            failure.pop_all()
        return reply

    def close(self) -> None:
        """Kill the child and wait for its end; a second call does nothing."""
        self._close()

    def _send(self, request: bytes, until_s: float) -> None:
        assert self._process.stdin is not None
        unsent = memoryview(request)
        while unsent:
            self._wait(until_s, writing=True)
            unsent = unsent[os.write(self._process.stdin.fileno(), unsent) :]

    def _receive(self, reply_bytes: int, until_s: float) -> bytes:
        assert self._process.stdout is not None
        reply = b""
        while len(reply) < reply_bytes:
            self._wait(until_s, writing=False)
            part = os.read(self._process.stdout.fileno(), reply_bytes - len(reply))
            if not part:
                raise BrokenPipeError
            reply += part
        return reply

    def _wait(self, until_s: float, *, writing: bool) -> None:
        """Wait until the child can take or has bytes."""
        stream = self._process.stdin if writing else self._process.stdout
        assert stream is not None
        waiting = select.poll()
        waiting.register(stream, select.POLLOUT if writing else select.POLLIN)
        if not waiting.poll(max(1000.0 * (until_s - time.monotonic()), 0.0)):
            raise ChildError(f"it did not answer within {self._limit_s:g} s")

    def _ending(self) -> str:
        """Return what became of a child that has closed a stream, with the last line of its stderr after a colon."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_ENDING_S)
        fate = "it closed a stream and runs on" if self._process.returncode is None else "it ended"
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        return f"{fate}: {lines[-1]}" if lines else fate


def _end(process: subprocess.Popen[bytes], files: ExitStack) -> None:
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout, files):
        if stream is not None:
            stream.close()
