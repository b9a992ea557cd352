"""Says when a wait is the compiler's: kernels are compiled at their first use in an installation, then kept on disk."""

from __future__ import annotations

import contextlib
import functools
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from numba import njit

_PACKAGE = Path(__file__).resolve().parent.parent
_announced = False
_NO_REFERENCE_COUNTING: Any = {"_nrt": False}
_Kernel = TypeVar("_Kernel", bound=Callable[..., Any])


def row_kernel(**options: Any) -> Callable[[_Kernel], _Kernel]:
    """Return ``numba.njit`` for a kernel that makes no arrays, with more options of it.

    It counts no references to arrays: kernels of rows, short and often called, took a twentieth more time for that. So
    it must return none either: a caller that counts would release what it never took.
    """
    decorator: Callable[[_Kernel], _Kernel] = njit(cache=True, **_NO_REFERENCE_COUNTING, **options)
    return decorator


@functools.cache
def announce_compilation(kernel: Callable[..., Any]) -> None:
    """Print one line on stderr, once a process, if ``kernel`` (a numba function) has no compiled form on disk.

    Asked again about the same kernel it does nothing: it is asked before every picture.
    """
    global _announced
    forget_stale_kernels(_PACKAGE)
    if not _announced and not _is_compiled(kernel):
        print("compiling kernels (first run only) …", file=sys.stderr, flush=True)
        _announced = True


@functools.cache
def forget_stale_kernels(package: Path, caller: Any = None) -> None:
    """Remove compiled kernels that are older than any source file of the package; once a process.

    numba compiles a kernel anew when its own file has changed, but not when one that it calls has, in another file.
    Kernels that numba keeps elsewhere than beside the sources (``NUMBA_CACHE_DIR``) are not looked at.

    Args:
        caller: a numba function outside the package that calls its kernels: only compiled forms of it are removed,
            wherever they are, and subpackages are not looked at.
    """
    sources = package.rglob("*.py") if caller is None else package.glob("*.py")
    newest = max(source.stat().st_mtime for source in sources)
    for index in package.rglob("__pycache__/*.nbi") if caller is None else _indices(caller):
        # Another process may do the same at the same time, or the folder may belong to another user.
        with contextlib.suppress(OSError):
            if index.stat().st_mtime < newest:
                index.unlink()


def _is_compiled(kernel: Any) -> bool:
    return bool(getattr(kernel, "signatures", True)) or any(_indices(kernel))


def _indices(kernel: Any) -> Iterator[Path]:
    """Yield the index files that numba keeps of a function's compiled forms."""
    source = Path(kernel.py_func.__code__.co_filename)
    return Path(kernel.stats.cache_path).glob(f"{source.stem}.{kernel.py_func.__qualname__}-*.nbi")
