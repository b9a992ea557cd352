"""Where numba keeps compiled kernels if neither their sources' folder nor a home can be written, as in a container."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_folder: tempfile.TemporaryDirectory[str] | None = None


def ensure_kernel_cache() -> None:
    """Set a temporary folder for numba's cache, with a note on stderr, where numba would find no place and raise.

    Processes that this one starts use the same folder, which is removed at the end of this one.
    """
    global _folder
    wanted = os.environ.get("NUMBA_CACHE_DIR", _PACKAGE)
    if os.access(wanted, os.W_OK):
        return
    # Imported here: it takes most of a second, and is not needed elsewhere than in such a place.
    from numba import config, njit

    try:
        njit(cache=True)(_anything)
    except RuntimeError:
        _folder = tempfile.TemporaryDirectory(prefix="frameout-kernels-")
        os.environ["NUMBA_CACHE_DIR"] = config.CACHE_DIR = _folder.name  # type: ignore[attr-defined]
        why = f"{wanted} and the home folder cannot be written; NUMBA_CACHE_DIR names a folder that stays"
        print(f"note: compiled kernels are kept in {_folder.name} until this process ends, as {why}", file=sys.stderr)


def _anything() -> None:
    """Be a function of this package, for which numba looks for a place."""
