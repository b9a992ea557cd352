"""Compilation of kernels at their first use in an installation; compiled forms are kept on disk."""

from __future__ import annotations

import contextlib
import functools
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

from numba import njit
from numba.core.caching import FunctionCache

_PACKAGE = Path(__file__).resolve().parent.parent
_announced = False
_NO_REFERENCE_COUNTING: Any = {"_nrt": False}
_Kernel = TypeVar("_Kernel", bound=Callable[..., Any])


def row_kernel(**options: Any) -> Callable[[_Kernel], _Kernel]:
    """Return ``numba.njit`` for a kernel that makes no arrays, with more options of it.

    It counts no references to arrays, which saves a twentieth of the time of short kernels. So it must not return an
    array either: a caller that counts would release a reference that was never taken.

    It becomes part of whatever kernel calls it. A call would be linked to the form of its own that this process has
    compiled, or, in a process that reads its caller from disk, to a copy that was compiled with the caller: two machine
    codes, which may round differently in the last bit.
    """
    decorator: Callable[[_Kernel], _Kernel] = njit(cache=True, forceinline=True, **_NO_REFERENCE_COUNTING, **options)
    return decorator


class _NamedCache(FunctionCache):
    """Compiled forms of a closure on disk, told apart by its qualified name and the types of its arguments.

    In numba's own key stand the pickled variables of the closure, and a pickled kernel is another one in each process.
    """

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        return sig, codegen.magic_tuple()


def closure_kernel(function: FunctionType, name: str) -> Any:
    """Return a function that calls kernels from its closure as a ``row_kernel``.

    Args:
        name: names function and kernels. Its compiled forms have files of their own by this name: a file with types of
            a module that is missing in another process could not be read there.
    """
    function.__qualname__ = name
    kernel: Any = njit(**_NO_REFERENCE_COUNTING)(function)
    kernel._cache = _NamedCache(function)
    return kernel


@functools.cache
def announce_compilation(kernel: Callable[..., Any]) -> None:
    """Print one line on stderr, once a process, if ``kernel`` (a numba function) has no compiled form on disk.

    Later calls with the same kernel do nothing, as it is called before every picture.
    """
    global _announced
    forget_stale_kernels(_PACKAGE)
    if not _announced and not _is_compiled(kernel):
        print("compiling kernels (first run only) …", file=sys.stderr, flush=True)
        _announced = True


@functools.cache
def forget_stale_kernels(package: Path, caller: Any = None) -> None:
    """Remove compiled kernels that are older than any source file of the package; once a process.

    numba recompiles a kernel when its own file has changed, but not when the file of a kernel that it calls has.
    Kernels that numba does not keep beside the sources (``NUMBA_CACHE_DIR``) are ignored.

    Args:
        caller: a numba function outside the package that calls its kernels: only its compiled forms are removed,
            wherever they are; subpackages are ignored.
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
    """Yield numba's index files of a function's compiled forms."""
    source = Path(kernel.py_func.__code__.co_filename)
    return Path(kernel.stats.cache_path).glob(f"{source.stem}.{kernel.py_func.__qualname__}-*.nbi")
