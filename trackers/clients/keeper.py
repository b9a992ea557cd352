"""Runs a program for a parent, and ends it with all that it has started: ``keeper.py SOCKET FILES WORD …``.

The program gets the keeper's standard streams and ``FILES``, numbers with commas between them. The keeper writes lines
into ``SOCKET``: ``runs PID`` or ``failed WHY``, then ``ended STATUS``, negative for a signal. A byte from the parent,
or the parent's end, is the end of all. On Linux none gets away: those whose own parent has ended become children of
the keeper, whatever their group, session and environment. On macOS those that have left the program's group do.

Of the standard library alone, so that it starts within milliseconds.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import select
import signal
import socket
import subprocess
import sys
import time

_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
_QUICK_PASSES = 1000
_PASS_S = 0.001


def children_of(pid: int | str) -> set[int]:
    """Return the processes that a process has started, or none on macOS; those that nobody has waited for too.

    Args:
        pid: of it, or ``self``.
    """
    found = set[int]()
    with contextlib.suppress(OSError):
        for thread in os.listdir(f"/proc/{pid}/task"):
            with contextlib.suppress(OSError), open(f"/proc/{pid}/task/{thread}/children", "rb", 0) as file:
                found.update(map(int, file.read().split()))
    return found


def main(leash_file: str, files: str, *command: str) -> None:
    """See the module's docstring."""
    leash, given = socket.socket(fileno=int(leash_file)), tuple(map(int, filter(None, files.split(","))))
    control = ctypes.CDLL(None).prctl if sys.platform == "linux" else lambda *_: 0
    control(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    news, bell = os.pipe()
    os.set_blocking(bell, False)
    signal.set_wakeup_fd(bell, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    try:
        program = subprocess.Popen(
            command,
            pass_fds=given,
            start_new_session=True,
            # One that ends its keeper ends too.
            preexec_fn=lambda: control(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0),
        )
    except OSError as error:
        leash.send(f"failed {error}\n".encode())
        return
    # The parent notices when the program closes them.
    nothing = os.open(os.devnull, os.O_RDWR)
    for file in (0, 1, 2, *given):
        os.dup2(nothing, file)
    leash.send(f"runs {program.pid}\n".encode())
    poll, has_ended = select.poll(), False
    poll.register(leash, select.POLLIN)
    poll.register(news, select.POLLIN)
    while leash.fileno() not in dict(poll.poll()):
        os.read(news, 1 << 12)
        if not has_ended and (status := _status(program.pid)) is not None:
            has_ended = True
            with contextlib.suppress(OSError):
                leash.send(f"ended {status}\n".encode())
        for pid in children_of("self") - {program.pid}:
            os.waitpid(pid, os.WNOHANG)
    _end_all(program.pid)


def _status(pid: int) -> int | None:
    """Return how a child has ended, None if it runs; the parent can still read the clock of its CPU time."""
    if not hasattr(os, "waitid"):  # macOS
        ended, status = os.waitpid(pid, os.WNOHANG)
        return os.waitstatus_to_exitcode(status) if ended else None
    end = os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    return end and (end.si_status if end.si_code == os.CLD_EXITED else -end.si_status)


def _end_all(pid: int) -> None:
    """End the group of a child, then all children, until those that they leave have ended too."""
    with contextlib.suppress(OSError):
        os.killpg(pid, signal.SIGKILL)
    passes = 0
    with contextlib.suppress(ChildProcessError):
        while True:
            for child in children_of("self"):
                with contextlib.suppress(PermissionError):  # It has become another user's.
                    os.kill(child, signal.SIGKILL)
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
            # One that lives for a millisecond, and starts the next one, is met by passes without a pause.
            passes += 1
            if passes > _QUICK_PASSES:
                time.sleep(_PASS_S)


if __name__ == "__main__":
    main(*sys.argv[1:])
