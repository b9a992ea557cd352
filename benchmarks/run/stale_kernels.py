"""Compiled kernels of trackers and scenes that are older than what they were compiled from."""

from __future__ import annotations

import contextlib
import math
import os
from functools import cache
from pathlib import Path

from benchmarks.run import own_modules as imports

_PACKAGES = ("trackers", "scenarios")


@cache
def forget_stale_kernels() -> None:
    """Remove compiled kernels that are older than a file that their module imports, directly or not; once a process.

    numba recompiles a kernel when its own file has changed, but not when the file of a kernel that it calls has. A
    kernel that is up to date gets the time of the newest source, so that the next process need not follow its imports.
    The simulator drops its own, some of which get kernels as arguments (``sim.render.compilation``).
    Kernels that numba does not keep beside the sources (``NUMBA_CACHE_DIR``) are ignored.
    """
    root = imports.ROOT
    changed_s = max(_time_s(source) for name in ("sim", *_PACKAGES) for source in (root / name).rglob("*.py"))
    newest_s: dict[str, float] = {}
    for index in (index for name in _PACKAGES for index in (root / name).rglob("__pycache__/*.nbi")):
        # Another process may do the same at the same time, or the folder may belong to another user.
        with contextlib.suppress(OSError):
            compiled_s = _time_s(index)
            if compiled_s >= changed_s:
                continue
            folder = index.parent.parent.relative_to(root)
            module = ".".join((*folder.parts, index.name.partition(".")[0]))
            if module not in newest_s:
                # A module that is gone has none.
                newest_s[module] = max(map(_time_s, imports.imported_files([module])), default=math.inf)
            if compiled_s < newest_s[module]:
                index.unlink()
            else:
                os.utime(index, (changed_s, changed_s))


def _time_s(file: Path) -> float:
    return file.stat().st_mtime
