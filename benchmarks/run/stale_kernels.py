"""Compiled kernels that are older than what they were compiled from."""

from __future__ import annotations

import contextlib
import os
from functools import cache
from pathlib import Path

from benchmarks.run.source_files import ROOT, source_files


@cache
def forget_stale_kernels() -> None:
    """Remove compiled kernels that are older than a file that their module imports, directly or not; once a process.

    numba recompiles a kernel when its own file has changed, but not when the file of a kernel that it calls has. The
    simulator, which also runs without this package, drops its own (``sim.render.compilation``).
    Kernels that numba does not keep beside the sources (``NUMBA_CACHE_DIR``) are ignored.
    """
    forget_stale_kernels_below(ROOT, ("sim", "trackers", "scenarios"))


def forget_stale_kernels_below(root: Path, packages: tuple[str, ...]) -> None:
    """Do so in packages that lie in the folder ``root``."""
    changed_s = max(source.stat().st_mtime for name in packages for source in (root / name).rglob("*.py"))
    newest_s: dict[str, float] = {}
    for index in (index for name in packages for index in (root / name).rglob("__pycache__/*.nbi")):
        # Another process may do the same at the same time, or the folder may belong to another user.
        with contextlib.suppress(OSError):
            compiled_s = index.stat().st_mtime
            if compiled_s >= changed_s:
                continue
            folder = index.parent.parent.relative_to(root)
            module = ".".join((*folder.parts, index.name.partition(".")[0]))
            if module not in newest_s:
                newest_s[module] = max(source.stat().st_mtime for source in source_files([module]))
            if compiled_s < newest_s[module]:
                index.unlink()
            else:
                # The next process need not follow its imports.
                os.utime(index, (changed_s, changed_s))
