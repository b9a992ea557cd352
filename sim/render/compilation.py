"""Says when a wait is the compiler's: kernels are compiled at their first use in an installation, then kept
on disk.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

_announced = False


def announce_compilation(kernel: Callable[..., Any]) -> None:
    """Print one line on stderr, once a process, if ``kernel`` (a numba function) has no compiled form on
    disk.
    """
    global _announced
    if not _announced and not _is_compiled(kernel):
        print("compiling kernels (first run only) …", file=sys.stderr, flush=True)
        _announced = True


def _is_compiled(kernel: Any) -> bool:
    if getattr(kernel, "signatures", True):
        return True
    source = Path(kernel.py_func.__code__.co_filename)
    # The name of the index that numba keeps of a function's compiled forms.
    pattern = f"{source.stem}.{kernel.py_func.__qualname__}-*.nbi"
    return any(Path(kernel.stats.cache_path).glob(pattern))
