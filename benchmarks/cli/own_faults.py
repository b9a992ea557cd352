"""Faults of users' own code in worker processes, e.g. of a street pattern, told without joblib's traceback."""

from __future__ import annotations

import re
from pathlib import Path

from benchmarks.run.own_modules import is_users

_FRAME = re.compile(r'File "([^"]+)", line (\d+), in ')


def workers_fault(error: BaseException) -> str | None:
    """Return an error of a worker process in one line, with the last line of a user's code on the way to it.

    None for an error of this process, or one without such a line.
    """
    cause = error.__cause__
    frames = _FRAME.findall(str(cause)) if type(cause).__name__ == "_RemoteTraceback" else []
    own = [frame for frame in frames if is_users(frame[0])]
    if not own:
        return None
    file, line = own[-1]
    return f"{Path(file).name}, line {line}: {type(error).__name__}: {error}"
