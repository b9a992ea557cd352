"""Where trackers print while they run."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout

_STDOUT, _STDERR = 1, 2


@contextmanager
def trackers_print_to_stderr() -> Iterator[None]:
    """Send what is printed in this process, and in those that it starts, to stderr: stdout is for results."""
    stdout = sys.stdout
    stdout.flush()
    kept = os.dup(_STDOUT)
    os.dup2(_STDERR, _STDOUT)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        # What was printed past ``sys.stdout``, by a handler that holds the old one or by a library in C, waits in
        # their buffers.
        stdout.flush()
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, _STDOUT)
        os.close(kept)
